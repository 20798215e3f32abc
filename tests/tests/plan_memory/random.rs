//! Random graphs: each node reads a few of what was written before and writes something new.

use framegraph::*;
use wgpu::TextureFormat as F;

/// What a node writes: a stored texture of one of these, a target of one of these, or a buffer.
const STORED: [(F, &str); 3] = [
    (F::R32Float, "r32float"),
    (F::Rgba16Float, "rgba16float"),
    (F::Rgba8Unorm, "rgba8unorm"),
];
const TARGETS: [F; 4] = [
    F::Rgba8Unorm,
    F::Rgba8UnormSrgb,
    F::Rgba16Float,
    F::Rg16Float,
];

const READS: &str = "
    @group(0) @binding(0) var a: texture_2d<f32>;
    @group(0) @binding(1) var b: texture_2d<f32>;
    @group(0) @binding(2) var<storage, read> words: array<u32>;
    fn all(at: vec2u) -> vec4f {
        return textureLoad(a, at, 0) + textureLoad(b, at, 0) + f32(words[0]);
    }";

pub struct Kernels {
    stored: Vec<ComputeKernel>,
    targets: Vec<RasterKernel>,
    words: ComputeKernel,
}

impl Kernels {
    pub fn new(device: &wgpu::Device) -> Kernels {
        let compute = |wgsl: &str| {
            let desc = KernelDesc {
                label: "compute",
                wgsl,
                entry: "main",
                external_groups: &[],
            };
            ComputeKernel::new(device, &desc).unwrap()
        };
        let stored = STORED.map(|(_, name)| {
            compute(&format!(
                "{READS}
                @group(0) @binding(3) var out: texture_storage_2d<{name}, write>;
                @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {{
                    textureStore(out, id.xy, all(id.xy));
                }}"
            ))
        });
        let words = compute(&format!(
            "{READS}
            @group(0) @binding(3) var<storage, read_write> out: array<u32>;
            @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{
                out[id.x] = u32(all(id.xy).x);
            }}"
        ));
        let targets = TARGETS.map(|format| {
            let wgsl = format!(
                "{READS}
                @vertex fn vs() -> @builtin(position) vec4f {{ return vec4f(0.0); }}
                @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                    return all(vec2u(p.xy));
                }}"
            );
            let desc = RasterKernelDesc {
                label: "raster",
                wgsl: &wgsl,
                vertex: "vs",
                fragment: "fs",
                external_groups: &[],
                targets: &[format],
                depth: None,
                depth_compare: wgpu::CompareFunction::Always,
                cull: None,
                topology: wgpu::PrimitiveTopology::TriangleList,
            };
            RasterKernel::new(device, &desc).unwrap()
        });
        Kernels {
            stored: stored.into(),
            targets: targets.into(),
            words,
        }
    }
}

/// Steele, Lea and Flood 2014, SplitMix64: enough to draw graphs with.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    /// Mostly one of the last few, as in a pipeline; now and then any.
    fn recent<T: Copy>(&mut self, all: &[T]) -> T {
        let window = if self.below(4) == 0 {
            all.len()
        } else {
            all.len().min(4)
        };
        all[all.len() - 1 - self.below(window)]
    }
}

pub fn plan<'f>(pool: &Pool, kernels: &Kernels, seed: u64) -> Plan<'f> {
    let mut random = Random(seed);
    let mut fg = pool.frame(FrameParams {
        size: super::SIZE,
        frame: 0,
    });
    let size = |random: &mut Random| Size::PerTexels([1, 2, 4][random.below(3)]);
    let first = fg.texture("first", TextureDesc::d2(F::R32Float, Size::Frame));
    let mut textures = vec![fg.clear_texture("first", first, [0.0; 4])];
    let first = fg.buffer("words", 1 << 16);
    let mut buffers = vec![fg.fill_buffer("words", first, 0)];
    macro_rules! read {
        ($node:expr) => {
            $node
                .read("a", random.recent(&textures))
                .read("b", random.recent(&textures))
                .read_buffer("words", random.recent(&buffers))
        };
    }
    for i in 0..5 + random.below(56) {
        match random.below(8) {
            0 => {
                let bytes = 4 * (1 + random.below(1 << 20)) as u64;
                let out = fg.buffer(format!("b{i}"), bytes);
                let mut node = fg.compute(format!("n{i}"), &kernels.words);
                read!(node);
                buffers.push(node.overwrite_buffer("out", out));
                node.dispatch([1, 1, 1]);
            }
            1..4 => {
                let which = random.below(TARGETS.len());
                let desc = TextureDesc::d2(TARGETS[which], size(&mut random));
                let out = fg.texture(format!("t{i}"), desc);
                let mut node = fg.raster(format!("n{i}"), &kernels.targets[which]);
                read!(node);
                textures.push(node.color(0, out, Load::Clear(wgpu::Color::BLACK)));
                node.draw(|_| {});
            }
            _ => {
                let which = random.below(STORED.len());
                let desc = TextureDesc::d2(STORED[which].0, size(&mut random));
                let out = fg.texture(format!("t{i}"), desc);
                let mut node = fg.compute(format!("n{i}"), &kernels.stored[which]);
                read!(node);
                textures.push(node.overwrite("out", out));
                node.dispatch([1, 1, 1]);
            }
        }
    }
    fg.export_texture("last", textures[textures.len() - 1]);
    fg.export_buffer("words", buffers[buffers.len() - 1]);
    fg.compile().unwrap()
}
