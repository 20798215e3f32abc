//! The kernels: a table of what they bind, WGSL made from it, and the same computed on the CPU.
//! All data are u32 and all arithmetic is a hash of everything read, so results are equal or wrong.

use framegraph::{ComputeKernel, KernelDesc, RasterKernel, RasterKernelDesc, State};

use crate::common::storage_layout;
use crate::frame::{Frame, Node};
use crate::model::Contents;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum In {
    /// One mip and layer, sampled.
    Texture,
    /// A range of mips and layers, sampled.
    Layers,
    /// One mip and layer as a read-only storage texture.
    Storage,
    /// A read-only storage buffer.
    Buffer,
    /// A buffer of at least 16 words as a uniform.
    Uniform,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Out {
    /// One mip and layer, overwritten.
    Texture,
    /// One mip and layer of which every other texel is written.
    TexturePart,
    /// One mip and layer, read and written.
    TextureUpdate,
    /// All layers of one mip, overwritten.
    Layers,
    /// A buffer, overwritten.
    Buffer,
    /// A buffer of which every other word is written.
    BufferPart,
    /// A buffer, read and written.
    BufferUpdate,
}

pub struct Signature {
    pub inputs: &'static [In],
    pub outputs: &'static [Out],
}

macro_rules! table {
    ($([$($i:ident),*] -> [$($o:ident),*];)*) => {
        [$(Signature { inputs: &[$(In::$i),*], outputs: &[$(Out::$o),*] }),*]
    };
}

/// What writes.
pub static WRITERS: [Signature; 23] = table! {
    [] -> [Texture];
    [Texture] -> [Texture];
    [Texture, Texture] -> [Texture];
    [Texture, Storage, Buffer] -> [Texture];
    [Storage] -> [Texture];
    [Layers] -> [Texture];
    [Buffer] -> [Texture];
    [] -> [TextureUpdate];
    [Texture, Texture] -> [TextureUpdate];
    [Texture] -> [TexturePart];
    [Texture] -> [Texture, TextureUpdate];
    [Texture] -> [Texture, Buffer];
    [] -> [Layers];
    [Layers] -> [Layers];
    [] -> [Buffer];
    [Buffer] -> [Buffer];
    [Buffer, Buffer] -> [Buffer];
    [Texture] -> [Buffer];
    [Buffer] -> [BufferUpdate];
    [] -> [BufferPart];
    [Uniform] -> [Buffer];
    [Layers, Buffer] -> [BufferUpdate];
    [Buffer, Uniform, Texture] -> [Buffer, BufferPart];
};

/// What only reads, and leaves a hash of all it read where the graph does not see it.
pub static LOOKERS: [Signature; 4] = table! {
    [Texture] -> [];
    [Layers] -> [];
    [Buffer] -> [];
    [Texture, Buffer] -> [];
};

pub fn input_state(input: In) -> State {
    match input {
        In::Texture | In::Layers => State::Sampled,
        In::Storage | In::Buffer => State::StorageRead,
        In::Uniform => State::Uniform,
    }
}

pub fn output_state(output: Out) -> State {
    match output {
        Out::Texture | Out::TexturePart | Out::Layers => State::StorageWrite,
        Out::TextureUpdate | Out::Buffer | Out::BufferPart | Out::BufferUpdate => {
            State::StorageReadWrite
        }
    }
}

const HASH: &str = "
    fn hash(x: u32) -> u32 {
        let y = x * 747796405u + 2891336453u;
        let z = ((y >> ((y >> 28u) + 4u)) ^ y) * 277803737u;
        return (z >> 22u) ^ z;
    }
    // Seed, and the place that a looker writes to.
    @group(0) @binding(0) var<uniform> params: vec4u;
";

/// pcg_hash of Jarzynski and Olano, 'Hash Functions for GPU Rendering', JCGT 2020.
pub fn hash(x: u32) -> u32 {
    let y = x.wrapping_mul(747796405).wrapping_add(2891336453);
    let z = ((y >> ((y >> 28) + 4)) ^ y).wrapping_mul(277803737);
    (z >> 22) ^ z
}

fn declarations(s: &Signature) -> String {
    let mut text = HASH.to_string();
    for (i, input) in s.inputs.iter().enumerate() {
        let (space, of) = match input {
            In::Texture => ("", "texture_2d<u32>"),
            In::Layers => ("", "texture_2d_array<u32>"),
            In::Storage => ("", "texture_storage_2d<r32uint, read>"),
            In::Buffer => ("<storage, read>", "array<u32>"),
            In::Uniform => ("<uniform>", "array<vec4u, 4>"),
        };
        text += &format!("@group(0) @binding({}) var{space} in{i}: {of};\n", i + 1);
    }
    for (o, output) in s.outputs.iter().enumerate() {
        let (space, of) = match output {
            Out::Texture | Out::TexturePart => ("", "texture_storage_2d<r32uint, write>"),
            Out::TextureUpdate => ("", "texture_storage_2d<r32uint, read_write>"),
            Out::Layers => ("", "texture_storage_2d_array<r32uint, write>"),
            _ => ("<storage, read_write>", "array<u32>"),
        };
        let binding = s.inputs.len() + o + 1;
        text += &format!("@group(0) @binding({binding}) var{space} out{o}: {of};\n");
    }
    text
}

/// Folds what the invocation at `p` reads of input i into `h`.
fn fold(i: usize, input: In) -> String {
    match input {
        In::Texture => {
            format!("h = hash(h + textureLoad(in{i}, p % textureDimensions(in{i}), 0).x);\n")
        }
        In::Storage => {
            format!("h = hash(h + textureLoad(in{i}, p % textureDimensions(in{i})).x);\n")
        }
        In::Layers => format!(
            "for (var m = 0u; m < textureNumLevels(in{i}); m++) {{
                 for (var l = 0u; l < textureNumLayers(in{i}); l++) {{
                     h = hash(h + textureLoad(in{i}, p % textureDimensions(in{i}, m), l, m).x);
                 }}
             }}\n"
        ),
        In::Buffer => {
            format!(
                "for (var k = 0u; k < arrayLength(&in{i}); k++) {{ h = hash(h + in{i}[k]); }}\n"
            )
        }
        In::Uniform => {
            format!("for (var k = 0u; k < 16u; k++) {{ h = hash(h + in{i}[k / 4u][k % 4u]); }}\n")
        }
    }
}

fn writer(s: &Signature) -> String {
    let mut text = declarations(s);
    text += "@compute @workgroup_size(4, 4) fn main(@builtin(global_invocation_id) id: vec3u) {
        let p = id.xy;
        var h = hash(params.x ^ hash(p.x + 64u * p.y));\n";
    for (i, &input) in s.inputs.iter().enumerate() {
        text += &fold(i, input);
    }
    for (o, output) in s.outputs.iter().enumerate() {
        let inside = format!("all(p < textureDimensions(out{o}))");
        let within = format!("p.y == 0u && p.x < arrayLength(&out{o})");
        let odd = "(p.x + p.y + params.x) % 2u == 1u";
        let v = format!("hash(h + {}u", o + 1);
        text += &match output {
            Out::Texture => format!("if {inside} {{ textureStore(out{o}, p, vec4u({v}))); }}\n"),
            Out::TexturePart => {
                format!("if {inside} && {odd} {{ textureStore(out{o}, p, vec4u({v}))); }}\n")
            }
            Out::TextureUpdate => format!(
                "if {inside} {{ textureStore(out{o}, p, vec4u({v} + textureLoad(out{o}, p).x))); }}\n"
            ),
            Out::Layers => format!(
                "if {inside} {{ for (var l = 0u; l < textureNumLayers(out{o}); l++) {{
                     textureStore(out{o}, p, l, vec4u({v} + l)));
                 }} }}\n"
            ),
            Out::Buffer => format!("if {within} {{ out{o}[p.x] = {v}); }}\n"),
            Out::BufferPart => format!("if {within} && {odd} {{ out{o}[p.x] = {v}); }}\n"),
            Out::BufferUpdate => format!("if {within} {{ out{o}[p.x] = {v} + out{o}[p.x]); }}\n"),
        };
    }
    text + "}"
}

fn looker(s: &Signature) -> String {
    let mut text = declarations(s);
    text += "@group(1) @binding(0) var<storage, read_write> observed: array<u32>;
        @compute @workgroup_size(1) fn main() {
            var h = hash(params.x);
            for (var n = 0u; n < 36u; n++) {
                let p = vec2u(n % 6u, n / 6u);\n";
    for (i, &input) in s.inputs.iter().enumerate() {
        text += &fold(i, input);
    }
    text + "}\nobserved[params.y] = h; }"
}

/// Writes arguments of an indirect dispatch of 0 to 4 workgroups.
const ARGUMENTS: &str = "
    @group(0) @binding(1) var<storage, read_write> out0: array<u32>;
    @compute @workgroup_size(16) fn main(@builtin(global_invocation_id) id: vec3u) {
        if id.x < arrayLength(&out0) {
            let h = hash(params.x + id.x);
            out0[id.x] = select(select(h, 1u, id.x < 3u), h % 5u, id.x == 0u);
        }
    }";

/// One word for each workgroup.
const INDIRECT: &str = "
    @group(0) @binding(1) var<storage, read_write> out0: array<u32>;
    @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
        if id.x < arrayLength(&out0) { out0[id.x] = hash(params.x ^ id.x); }
    }";

/// Covers the target, or every other texel of it.
const RASTER: &str = "
    @group(0) @binding(1) var in0: texture_2d<u32>;
    @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
        return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
    }
    @fragment fn fs(@builtin(position) at: vec4f) -> @location(0) vec4u {
        let p = vec2u(at.xy);
        if params.y == 1u && (p.x + p.y + params.x) % 2u == 0u { discard; }
        let h = hash(params.x ^ hash(p.x + 64u * p.y));
        return vec4u(hash(h + textureLoad(in0, p % textureDimensions(in0), 0).x));
    }";

pub struct Kernels {
    pub writers: Vec<ComputeKernel>,
    pub lookers: Vec<ComputeKernel>,
    pub arguments: ComputeKernel,
    pub indirect: ComputeKernel,
    pub raster: RasterKernel,
    pub observed: wgpu::BindGroupLayout,
}

impl Kernels {
    pub fn new(device: &wgpu::Device) -> Self {
        let observed = storage_layout(device);
        let make = |wgsl: &str, external_groups: &[(u32, &wgpu::BindGroupLayout)]| {
            let desc = KernelDesc {
                label: "random",
                wgsl,
                entry: "main",
                external_groups,
            };
            ComputeKernel::new(device, &desc).unwrap_or_else(|e| panic!("{e:?}\n{wgsl}"))
        };
        Kernels {
            writers: WRITERS.iter().map(|s| make(&writer(s), &[])).collect(),
            lookers: LOOKERS
                .iter()
                .map(|s| make(&looker(s), &[(1, &observed)]))
                .collect(),
            arguments: make(&format!("{HASH}{ARGUMENTS}"), &[]),
            indirect: make(&format!("{HASH}{INDIRECT}"), &[]),
            raster: RasterKernel::new(
                device,
                &RasterKernelDesc {
                    label: "random",
                    wgsl: &format!("{HASH}{RASTER}"),
                    vertex: "vs",
                    fragment: "fs",
                    external_groups: &[],
                    targets: &[wgpu::TextureFormat::R32Uint],
                    depth: None,
                    depth_compare: wgpu::CompareFunction::Always,
                    cull: None,
                    topology: wgpu::PrimitiveTopology::TriangleList,
                },
            )
            .unwrap(),
            observed,
        }
    }
}

/// `fold` on the CPU.
fn read(frame: &Frame, contents: &Contents, node: &Node, i: usize, p: [u32; 2], mut h: u32) -> u32 {
    let u = &node.uses[i];
    let mut take = |word: u32| h = hash(h.wrapping_add(word));
    match frame.resources[u.resource].shape.words() {
        Some(_) => contents[u.resource][0].iter().for_each(|&w| take(w)),
        None => {
            for (sub, [w, h]) in frame.subresources(u) {
                take(contents[u.resource][sub][(p[1] % h * w + p[0] % w) as usize]);
            }
        }
    }
    h
}

/// What a looker leaves.
pub fn look(frame: &Frame, contents: &Contents, node: &Node, inputs: usize, seed: u32) -> u32 {
    (0..36).fold(hash(seed), |h, n| {
        (0..inputs).fold(h, |h, i| read(frame, contents, node, i, [n % 6, n / 6], h))
    })
}

/// What the fragment at `p` has, from input 0.
pub fn fragment(frame: &Frame, contents: &Contents, node: &Node, seed: u32, p: [u32; 2]) -> u32 {
    let h = hash(seed ^ hash(p[0] + 64 * p[1]));
    read(frame, contents, node, 0, p, h)
}

/// Whether a part is written at `p`.
pub fn is_odd(seed: u32, p: [u32; 2]) -> bool {
    (p[0].wrapping_add(p[1]).wrapping_add(seed)) % 2 == 1
}

/// A writer on the CPU. No output is also an input, so each can be written in place.
pub fn write(frame: &Frame, contents: &mut Contents, node: &Node, s: &Signature, seed: u32) {
    for (o, output) in s.outputs.iter().enumerate() {
        let u = &node.uses[s.inputs.len() + o];
        for (l, (sub, [width, height])) in frame.subresources(u).into_iter().enumerate() {
            for n in 0..width * height {
                let p = [n % width, n / width];
                let h = (0..s.inputs.len()).fold(hash(seed ^ hash(p[0] + 64 * p[1])), |h, i| {
                    read(frame, contents, node, i, p, h)
                });
                let h = h.wrapping_add(o as u32 + 1);
                let texel = &mut contents[u.resource][sub][n as usize];
                match output {
                    Out::Texture | Out::Buffer => *texel = hash(h),
                    Out::TexturePart | Out::BufferPart if is_odd(seed, p) => *texel = hash(h),
                    Out::TexturePart | Out::BufferPart => {}
                    Out::TextureUpdate | Out::BufferUpdate => {
                        *texel = hash(h.wrapping_add(*texel));
                    }
                    Out::Layers => *texel = hash(h.wrapping_add(l as u32)),
                }
            }
        }
    }
}
