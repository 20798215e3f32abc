//! A frame as deferred renderers have it: shadows, G-buffer, ambient occlusion, lighting, reflections, temporal
//! antialiasing, bloom, tone mapping.
//! ```text
//! shadow -> map --------------------------\
//! gbuffer -> albedo, normal, material, z --+-> light -> hdr -> ssr -> lit -> taa -> aa -> bloom -> tonemap => export
//! ssao -> half ao -> blur -> blur -> ao ---/                     taa@-1 ----/
//! ```
//! Only what is declared matters for memory, so every node is foreign and records nothing.

use framegraph::*;
use wgpu::TextureFormat as F;

const TARGET: wgpu::TextureUsages = wgpu::TextureUsages::RENDER_ATTACHMENT;
const STORED: wgpu::TextureUsages = wgpu::TextureUsages::STORAGE_BINDING;

struct Frame<'f> {
    graph: FrameGraph<'f>,
}

impl Frame<'_> {
    /// A node that reads and overwrites; the next versions of what it writes.
    fn node<const N: usize>(
        &mut self,
        name: &'static str,
        reads: &[Texture],
        writes: [Texture; N],
        usage: wgpu::TextureUsages,
    ) -> [Texture; N] {
        let mut node = self.graph.foreign(name);
        for &read in reads {
            node.read(read, wgpu::TextureUsages::TEXTURE_BINDING);
        }
        let written = writes.map(|texture| node.overwrite(texture, usage));
        node.record(|_, _| {});
        written
    }

    fn texture(&mut self, name: &'static str, format: F, size: Size) -> Texture {
        self.graph.texture(name, TextureDesc::d2(format, size))
    }
}

pub fn plan<'f>(pool: &Pool, size: [u32; 2]) -> Plan<'f> {
    let graph = pool.frame(FrameParams { size, frame: 0 });
    let mut f = Frame { graph };
    let (full, half) = (Size::Frame, Size::PerTexels(2));
    let map = f.texture("shadow map", F::Depth32Float, Size::Absolute([2048; 2]));
    let [map] = f.node("shadow", &[], [map], TARGET);
    let z = f.texture("depth", F::Depth32Float, full);
    let albedo = f.texture("albedo", F::Rgba8UnormSrgb, full);
    let normal = f.texture("normal", F::Rgb10a2Unorm, full);
    let material = f.texture("material", F::Rgba8Unorm, full);
    let motion = f.texture("motion", F::Rg16Float, full);
    let [z, albedo, normal, material, motion] = f.node(
        "gbuffer",
        &[],
        [z, albedo, normal, material, motion],
        TARGET,
    );

    let mut ao = f.texture("ssao", F::R8Unorm, half);
    [ao] = f.node("ssao", &[z, normal], [ao], TARGET);
    for name in ["ssao blur x", "ssao blur y"] {
        let blurred = f.texture(name, F::R8Unorm, half);
        [ao] = f.node(name, &[ao, z], [blurred], TARGET);
    }
    let hdr = f.texture("hdr", F::Rgba16Float, full);
    let [hdr] = f.node(
        "light",
        &[map, z, albedo, normal, material, ao],
        [hdr],
        STORED,
    );

    let traced = f.texture("ssr", F::Rgba16Float, half);
    let [traced] = f.node("ssr", &[hdr, z, normal, material], [traced], STORED);
    let filtered = f.texture("ssr filtered", F::Rgba16Float, half);
    let [filtered] = f.node("ssr filter", &[traced, z, normal], [filtered], STORED);
    let lit = f.texture("lit", F::Rgba16Float, full);
    let [lit] = f.node("combine", &[hdr, filtered, albedo, material], [lit], STORED);

    let desc = TextureDesc::d2(F::Rgba16Float, full);
    let history = f
        .graph
        .history_texture("taa", desc, 1, First::Clear([0.0; 4]));
    let before = history.previous[0].unwrap_or(lit);
    let [aa] = f.node("taa", &[lit, before, motion, z], [history.current], STORED);
    let sharp = f.texture("sharp", F::Rgba16Float, full);
    let [sharp] = f.node("sharpen", &[aa], [sharp], STORED);

    let sizes = [2, 4, 8, 16, 32].map(Size::PerTexels);
    let mut levels = vec![sharp];
    for (name, size) in ["down 2", "down 4", "down 8", "down 16", "down 32"]
        .into_iter()
        .zip(sizes)
    {
        let level = f.texture(name, F::Rgba16Float, size);
        let from = levels[levels.len() - 1];
        levels.extend(f.node(name, &[from], [level], STORED));
    }
    let mut glow = levels[5];
    for (i, name) in [(4, "up 16"), (3, "up 8"), (2, "up 4"), (1, "up 2")] {
        let level = f.texture(name, F::Rgba16Float, sizes[i - 1]);
        [glow] = f.node(name, &[glow, levels[i]], [level], STORED);
    }
    let display = f.texture("display", F::Rgba8UnormSrgb, full);
    let [display] = f.node("tonemap", &[sharp, glow], [display], TARGET);
    f.graph.export_texture("display", display);
    f.graph.compile().unwrap()
}
