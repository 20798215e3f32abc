//! The white furnace: a convex white body under a white sky.
//!
//! Every facet sees nothing but the sky, so a white Lambert surface has exactly the radiance of
//! the sky and cannot be told from it. The facets are flat: with smooth normals part of the
//! shading hemisphere would lie below the facet and be lost.

use glam::{Affine3A, Vec3};

use super::shape::icosphere;
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::{Camera, Instance, Material, Mesh, Scene, Sky};

pub(super) fn scene() -> Result<Scene, SceneError> {
    let mut builder = SceneBuilder::new("furnace");
    let material = builder.material(Material::lambert("white", Vec3::ONE))?;
    let mesh = builder.mesh(Mesh {
        name: "sphere".to_owned(),
        material,
        ..icosphere(4)
    })?;
    builder.instance(Instance::new(mesh, Affine3A::IDENTITY));
    builder.sky(Sky::Constant(Vec3::ONE));
    builder.camera(Camera {
        name: "furnace".to_owned(),
        ..Camera::look_at(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 45_f32.to_radians())
    });
    builder.build()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_convex() {
        let sphere = icosphere(4);
        assert_eq!(sphere.indices.len(), 5120);
        // A closed surface is convex when no neighbouring vertex rises above a facet; here every
        // vertex is tried for a sample of the facets.
        for &[a, b, c] in sphere.indices.iter().step_by(7) {
            let [a, b, c] = [a, b, c].map(|i| sphere.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            assert!(normal.dot(a) > 0.99);
            for p in &sphere.positions {
                // 1e-6: rounding of unit vectors in f32.
                assert!(normal.dot(*p - a) < 1e-6);
            }
        }
    }
}
