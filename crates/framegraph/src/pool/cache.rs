//! Views, samplers and bind groups, made once and found again by what they are made of.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hash};

use super::store::next_id;
use crate::handle::Subresources;

/// A multiply-and-rotate hash: keys are a few small integers, made by the graph itself.
#[derive(Clone, Copy, Default)]
pub(crate) struct Mix(u64);

impl std::hash::Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(word.into());
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

pub(crate) type Hasher = BuildHasherDefault<Mix>;

/// A value and whether it was used since the last sweep.
struct Entry<T>(T, bool);

#[derive(Default)]
pub(crate) struct Cache {
    /// Where keys of groups are put together.
    pub key: Vec<u64>,
    views: HashMap<(u32, u64, u64), Entry<wgpu::TextureView>, Hasher>,
    samplers: Vec<(wgpu::SamplerDescriptor<'static>, wgpu::Sampler)>,
    groups: HashMap<Vec<u64>, Entry<wgpu::BindGroup>, Hasher>,
    textures: HashMap<wgpu::Texture, Entry<u32>>,
    buffers: HashMap<wgpu::Buffer, Entry<u32>>,
}

impl Cache {
    /// Lets go of what was not used since the last sweep.
    pub fn sweep(&mut self) {
        self.views.retain(|_, e| std::mem::take(&mut e.1));
        self.groups.retain(|_, e| std::mem::take(&mut e.1));
        self.textures.retain(|_, e| std::mem::take(&mut e.1));
        self.buffers.retain(|_, e| std::mem::take(&mut e.1));
    }

    /// The number of an imported texture.
    pub fn texture_id(&mut self, texture: &wgpu::Texture) -> u32 {
        intern(&mut self.textures, texture)
    }

    /// The number of an imported buffer.
    pub fn buffer_id(&mut self, buffer: &wgpu::Buffer) -> u32 {
        intern(&mut self.buffers, buffer)
    }

    pub fn view(
        &mut self,
        (texture, id, format): (&wgpu::Texture, u32, wgpu::TextureFormat),
        range: Subresources,
        dimension: wgpu::TextureViewDimension,
        aspect: wgpu::TextureAspect,
    ) -> &wgpu::TextureView {
        let how = (format.is_srgb() as u64) << 16 | (dimension as u64) << 8 | aspect as u64;
        let entry = self
            .views
            .entry((id, range.bits(), how))
            .or_insert_with(|| {
                Entry(
                    texture.create_view(&wgpu::TextureViewDescriptor {
                        format: (format != texture.format()).then_some(format),
                        dimension: Some(dimension),
                        aspect,
                        base_mip_level: range.mip,
                        mip_level_count: Some(range.mips),
                        base_array_layer: range.layer,
                        array_layer_count: Some(range.layers),
                        ..Default::default()
                    }),
                    true,
                )
            });
        entry.1 = true;
        &entry.0
    }

    /// The number of a sampler; the few there are are compared one by one.
    pub fn sampler_id(
        &mut self,
        device: &wgpu::Device,
        desc: &wgpu::SamplerDescriptor<'static>,
    ) -> u32 {
        if let Some(i) = self.samplers.iter().position(|(d, _)| d == desc) {
            return i as u32;
        }
        self.samplers
            .push((desc.clone(), device.create_sampler(desc)));
        self.samplers.len() as u32 - 1
    }

    pub fn find_sampler(&self, desc: &wgpu::SamplerDescriptor<'static>) -> Option<&wgpu::Sampler> {
        self.samplers
            .iter()
            .find(|(d, _)| d == desc)
            .map(|(_, sampler)| sampler)
    }

    pub fn group(&mut self, key: &[u64]) -> Option<wgpu::BindGroup> {
        let entry = self.groups.get_mut(key)?;
        entry.1 = true;
        Some(entry.0.clone())
    }

    pub fn keep_group(&mut self, key: &[u64], group: wgpu::BindGroup) {
        self.groups.insert(key.to_vec(), Entry(group, true));
    }
}

fn intern<T: Clone + Eq + Hash>(known: &mut HashMap<T, Entry<u32>>, value: &T) -> u32 {
    if let Some(entry) = known.get_mut(value) {
        entry.1 = true;
        return entry.0;
    }
    let id = next_id();
    known.insert(value.clone(), Entry(id, true));
    id
}
