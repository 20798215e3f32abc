//! Whether a scene's indices stay inside its lists; a scene is a plain value anyone may edit.

use super::GpuSceneError;
use crate::{Mesh, Scene};

pub(crate) fn check(scene: &Scene) -> Result<(), GpuSceneError> {
    let invalid = |message: String| Err(GpuSceneError::Invalid(message));
    for mesh in &scene.meshes {
        check_mesh(mesh, scene.materials.len())?;
    }
    for (i, instance) in scene.instances.iter().enumerate() {
        if instance.mesh as usize >= scene.meshes.len() {
            return invalid(format!(
                "instance {i} places mesh {}, of {}",
                instance.mesh,
                scene.meshes.len()
            ));
        }
    }
    for material in &scene.materials {
        for texture in material.texture_refs() {
            let Some(image) = scene.textures.get(texture.texture as usize) else {
                return invalid(format!(
                    "material '{}' uses texture {}, of {}",
                    material.name,
                    texture.texture,
                    scene.textures.len()
                ));
            };
            let texels = u64::from(image.width) * u64::from(image.height);
            if texels == 0 || image.rgba8.len() as u64 != 4 * texels {
                return invalid(format!(
                    "texture '{}' is {} x {} but has {} bytes",
                    image.name,
                    image.width,
                    image.height,
                    image.rgba8.len()
                ));
            }
        }
    }
    if let crate::Sky::Equirect {
        width, height, rgb, ..
    } = &scene.sky
        && (*width == 0
            || *height == 0
            || rgb.len() as u64 != u64::from(*width) * u64::from(*height))
    {
        return invalid(format!(
            "the sky is {width} x {height} but has {} texels",
            rgb.len()
        ));
    }
    Ok(())
}

fn check_mesh(mesh: &Mesh, materials: usize) -> Result<(), GpuSceneError> {
    let vertices = mesh.positions.len();
    let problem = if mesh.material as usize >= materials {
        format!("uses material {}, of {materials}", mesh.material)
    } else if mesh.normals.len() != vertices || mesh.uvs.len() != vertices {
        format!(
            "has {vertices} positions, {} normals and {} uvs",
            mesh.normals.len(),
            mesh.uvs.len()
        )
    } else if !mesh.tangents.is_empty() && mesh.tangents.len() != vertices {
        format!(
            "has {vertices} positions and {} tangents",
            mesh.tangents.len()
        )
    } else if let Some(index) = mesh
        .indices
        .iter()
        .flatten()
        .find(|&&i| i as usize >= vertices)
    {
        format!("has an index {index} to {vertices} vertices")
    } else if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
        format!("has a position that is not finite, vertex {i}")
    } else {
        return Ok(());
    };
    Err(GpuSceneError::Invalid(format!(
        "mesh '{}' {problem}",
        mesh.name
    )))
}
