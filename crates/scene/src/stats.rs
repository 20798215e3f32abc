//! Sizes and bounds of a scene.

use crate::model::{Aabb, Instance, Mesh, Scene, Stats};

impl Scene {
    /// The box of everything at rest (time 0), in world space; [`Aabb::EMPTY`] without geometry.
    pub fn bounds(&self) -> Aabb {
        let pose = self.pose(0.0);
        let mut bounds = Aabb::EMPTY;
        for (instance, transform) in self.instances.iter().zip(&pose.instances) {
            let deformed = pose.deformed.iter().find(|d| d.mesh == instance.mesh);
            let positions = match deformed {
                Some(deformed) => &deformed.positions,
                None => &self.mesh(instance).positions,
            };
            for &position in positions {
                bounds = bounds.grown(transform.transform_point3(position));
            }
        }
        bounds
    }

    /// How large the scene is.
    pub fn stats(&self) -> Stats {
        let triangles = |mesh: &Mesh| mesh.indices.len() as u64;
        Stats {
            triangles: self.instances.iter().map(|i| triangles(self.mesh(i))).sum(),
            mesh_triangles: self.meshes.iter().map(triangles).sum(),
            vertices: self.meshes.iter().map(|m| m.positions.len() as u64).sum(),
            meshes: self.meshes.len(),
            instances: self.instances.len(),
            materials: self.materials.len(),
            textures: self.textures.len(),
            texture_bytes: self.textures.iter().map(|t| t.rgba8.len() as u64).sum(),
            lights: self.lights.len(),
            emissive_triangles: self
                .instances
                .iter()
                .map(|i| self.mesh(i))
                .filter(|mesh| self.materials[mesh.material as usize].is_emissive())
                .map(triangles)
                .sum(),
            cameras: self.cameras.len(),
            animation_seconds: self.animation.seconds(),
        }
    }

    /// The mesh of an instance.
    pub fn mesh(&self, instance: &Instance) -> &Mesh {
        &self.meshes[instance.mesh as usize]
    }
}
