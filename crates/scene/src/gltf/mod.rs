//! Loading glTF 2.0: the first client of [`SceneBuilder`].

mod accessor;
mod animation;
mod container;
mod material;
mod mesh;
mod nodes;
mod options;
mod place;
mod sky;
mod texture;
mod uri;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use rayon::prelude::*;

use self::accessor::Data;
use self::container::File;
use self::mesh::Deformation;
use self::texture::Textures;
use crate::animation::Animation;
use crate::builder::SceneBuilder;
use crate::error::SceneError;
use crate::model::Scene;

pub use self::options::{LoadOptions, MaterialOverride};
pub(crate) use self::sky::SKY_KEY;

/// Loads a .glb or .gltf file.
///
/// What cannot be shown as the file says is noted in [`Scene::warnings`].
///
/// ```no_run
/// let scene = scumble_scene::load("kitchen.glb".as_ref(), &Default::default())?;
/// println!("{} triangles", scene.stats().triangles);
/// # Ok::<(), scumble_scene::SceneError>(())
/// ```
///
/// # Errors
/// When a file is missing, unreadable or not valid; never a panic, whatever the bytes.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => SceneError::NotFound {
            path: path.to_owned(),
        },
        _ => SceneError::Read {
            path: path.to_owned(),
            error,
        },
    })?;
    let name = path
        .file_stem()
        .map_or_else(|| "scene".to_owned(), |s| s.to_string_lossy().into_owned());
    let folder = path.parent().unwrap_or(Path::new(""));
    container::parse(&bytes, Some(folder))
        .and_then(|file| import(&file, &name, options))
        .map_err(|error| SceneError::InFile {
            path: path.to_owned(),
            error: Box::new(error),
        })
}

/// Loads a .glb or a .gltf with embedded data from memory, as a scene called `name`.
///
/// # Errors
/// As [`load`]; references to other files are errors too.
pub fn load_bytes(bytes: &[u8], name: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    container::parse(bytes, None).and_then(|file| import(&file, name, options))
}

fn import(file: &File<'_>, name: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    let data = Data {
        root: &file.root,
        buffers: &file.buffers,
    };
    let mut builder = SceneBuilder::new(name);
    if let Some(sky) = sky::read(data, &file.more)? {
        builder.sky(sky);
    }
    let mut textures = Textures::decode(file)?;
    let no_material = file
        .root
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.primitives)
        .any(|primitive| primitive.material.is_none());
    let uv_sets = material::add_all(file, &mut textures, &mut builder, no_material)?;
    if options.material_override == Some(MaterialOverride::Lambert) {
        for material in builder.materials_mut() {
            *material = std::mem::take(material).into_lambert();
        }
    }
    if let Some(sky) = &options.sky {
        builder.sky(sky.clone());
    }

    let tree = nodes::tree(&file.root)?;
    let uses = place::uses(&file.root, &tree, &animation::weight_driven(&file.root));
    let moves = !file.root.animations.is_empty() || uses.iter().any(|u| u.deforms());
    let mut animation = Animation::default();
    if moves {
        animation.skins = animation::skins(data, &tree)?;
        animation.nodes = tree.nodes.clone();
    }
    let jobs = jobs(&uses);
    let read: Vec<Result<mesh::Read, SceneError>> = jobs
        .par_iter()
        .map(|&(mesh, primitive, deformation)| {
            let material = file.root.meshes[mesh].primitives[primitive].material;
            let material = material.map_or(uv_sets.len() - 1, |m| m.value());
            let uv_set = uv_sets[material];
            mesh::read(data, mesh, primitive, material as u32, uv_set, deformation)
        })
        .collect();
    place::add(
        file,
        &tree,
        &uses,
        read.into_iter().collect::<Result<_, _>>()?,
        &mut animation,
        &mut builder,
    )?;
    if moves {
        let morphing: HashSet<u32> = animation
            .deformers
            .iter()
            .filter(|d| !d.targets.is_empty())
            .map(|d| d.node)
            .collect();
        animation.clips = animation::clips(data, &tree, &morphing, &mut builder)?;
    }
    builder.animation(animation);
    builder.build()
}

/// What has to be read: each primitive once, and once more for each use that deforms it.
fn jobs(uses: &[place::Use]) -> Vec<(usize, usize, Deformation)> {
    let mut seen = HashMap::new();
    uses.iter()
        .filter(|u| u.deforms() || seen.insert((u.mesh, u.primitive), ()).is_none())
        .map(|u| (u.mesh, u.primitive, u.deformation))
        .collect()
}
