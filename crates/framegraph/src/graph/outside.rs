//! What comes from outside of the graph and what leaves it.

use super::{Export, FrameGraph, Import, Kind, Resource, Shape, Word, here};
use crate::error::{Code, GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Texture};

impl FrameGraph<'_> {
    /// The engine's texture. It has contents; what the graph last writes to it is kept from culling.
    /// Another texture of the same shape may come each frame, at no cost. One that was imported before is the
    /// same resource still, and its latest version is returned.
    #[track_caller]
    pub fn import_texture(&mut self, name: impl Into<Label>, texture: &wgpu::Texture) -> Texture {
        let import = Import::Texture(texture.clone());
        let (shape, usage) = (Shape::of(texture), texture.usage().bits());
        Texture(self.import(name.into(), import, shape, usage, here()))
    }

    /// The engine's buffer. It has contents; what the graph last writes to it is kept from culling.
    /// Another buffer of the same size may come each frame, at no cost. One that was imported before is the
    /// same resource still, and its latest version is returned.
    #[track_caller]
    pub fn import_buffer(&mut self, name: impl Into<Label>, buffer: &wgpu::Buffer) -> Buffer {
        let import = Import::Buffer(buffer.clone());
        let shape = Shape::Buffer {
            bytes: buffer.size(),
        };
        Buffer(self.import(name.into(), import, shape, buffer.usage().bits(), here()))
    }

    /// As two resources one texture would have no hazards between what is done to the one and the other.
    fn import(
        &mut self,
        label: Label,
        import: Import,
        shape: Shape,
        allowed: u32,
        site: Site,
    ) -> Raw {
        if let Some(known) = self.imports.iter().position(|i| *i == import) {
            let known = Kind::Imported(known as u32);
            let mut resources = (0..).zip(&self.resources);
            if let Some((resource, _)) = resources.find(|(_, r)| r.kind == known) {
                return Raw {
                    brand: self.brand,
                    resource,
                    version: self.latest[resource as usize],
                };
            }
        }
        self.imports.push(import);
        let sample = self.shape_caps(&shape).and_then(|caps| caps.sample);
        self.add_resource(Resource {
            label,
            kind: Kind::Imported(self.imports.len() as u32 - 1),
            shape,
            extra_usage: 0,
            allowed,
            sample,
            site,
        })
    }

    /// Keeps this version from culling and makes it available as
    /// [`Pool::exported_texture`](crate::Pool::exported_texture) after encoding, with usage for sampling and copying.
    #[track_caller]
    pub fn export_texture(&mut self, key: impl Into<Label>, texture: Texture) {
        self.export(key.into(), texture.0, here());
    }

    /// Keeps this version from culling and makes it available as
    /// [`Pool::exported_buffer`](crate::Pool::exported_buffer) after encoding, with usage for copying.
    #[track_caller]
    pub fn export_buffer(&mut self, key: impl Into<Label>, buffer: Buffer) {
        self.export(key.into(), buffer.0, here());
    }

    fn export(&mut self, key: Label, raw: Raw, site: Site) {
        if self.resolve(raw, site).is_none() {
            return;
        }
        if let Some(&first) = self.export_keys.get(&key) {
            let error = GraphError::new(
                Code::DuplicateKey,
                format!("`{key}` is exported twice"),
                site,
                "give each export its own key",
            );
            let error = error.with("first exported", first);
            self.errors.push(error);
            return;
        }
        self.note(Word::Export, raw.resource.into(), Some(raw.version.into()));
        self.export_keys.insert(key.clone(), site);
        self.exports.push(Export { key, raw, site });
    }
}
