//! What a result depends on, as one name.

use scumble::Camera;
use scumble_scene::Scene;
use sha2::{Digest, Sha256};
use std::fmt::{self, Debug, Write};

/// Gathers all that a result depends on; two that differ in anything have different names.
#[derive(Clone)]
pub struct Key(Sha256);

/// Text that goes into a key piece by piece.
struct Sink<'a>(&'a mut Sha256);

impl Write for Sink<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Key {
    /// Of something of this kind, made by this code. The Rust code of all crates that compute is in it; shaders
    /// are not: those of a graph are added to what depends on them.
    pub fn new(kind: &str) -> Key {
        let mut key = Key(Sha256::new());
        key.add(kind);
        key.add(env!("SCUMBLE_CODE"));
        key
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Key {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds a text.
    pub fn add(&mut self, text: &str) -> &mut Key {
        self.bytes(text.as_bytes())
    }

    /// Adds a plain value: its `Debug` form has every bit of its numbers.
    pub fn value(&mut self, value: &(impl Debug + ?Sized)) -> &mut Key {
        let mut own = Sha256::new();
        // A digest takes any text.
        let _ = write!(Sink(&mut own), "{value:?}");
        let digest = own.finalize();
        self.bytes(&digest)
    }

    /// Adds where a camera stands and looks.
    pub fn camera(&mut self, camera: &Camera) -> &mut Key {
        self.value(camera)
    }

    /// Adds everything of a scene that is not only shown to people.
    pub fn scene(&mut self, scene: &Scene) -> &mut Key {
        let Scene {
            name: _,
            meshes,
            materials,
            textures,
            instances,
            lights,
            sky,
            cameras,
            animation,
            warnings: _,
        } = scene;
        self.value(meshes).value(materials).value(instances);
        self.value(lights).value(sky).value(cameras);
        self.value(animation);
        for texture in textures {
            let facts = (texture.width, texture.height, texture.srgb, texture.wrap);
            self.value(&facts).bytes(&texture.rgba8);
        }
        self
    }

    /// The name: 32 hexadecimal digits.
    pub fn name(&self) -> String {
        let mut name = format!("{:x}", self.0.clone().finalize());
        name.truncate(32);
        name
    }
}

#[cfg(test)]
mod tests {
    use super::Key;

    #[test]
    fn whatever_differs_changes_the_name() {
        let name = |parts: &[&str]| {
            let mut key = Key::new("test");
            parts.iter().for_each(|part| {
                key.add(part);
            });
            key.name()
        };
        assert_eq!(name(&["a", "b"]), name(&["a", "b"]));
        assert_ne!(name(&["a", "b"]), name(&["ab"]));
        assert_ne!(name(&["a", "b"]), name(&["b", "a"]));
        assert_eq!(name(&[]).len(), 32);
        assert_ne!(
            Key::new("t").value(&[0.0f32, 1.0]).name(),
            Key::new("t").value(&[-0.0f32, 1.0]).name()
        );
    }

    #[test]
    fn a_scene_differs_by_one_texel_or_vertex() {
        let scene = scumble_scene::builtin("cornell").unwrap();
        let name = |scene: &_| Key::new("t").scene(scene).name();
        let mut other = scene.clone();
        other.meshes[0].positions[0].x += 1e-6;
        assert_eq!(name(&scene), name(&scene.clone()));
        assert_ne!(name(&scene), name(&other));
    }
}
