//! What is read from shaders.

use framegraph::*;

fn access(r: &Reflection, name: &str) -> BindingAccess {
    r.binding(name)
        .unwrap_or_else(|| panic!("no `{name}`"))
        .access
}

/// Offsets, sizes and types as WGSL lays them out.
#[test]
fn uniform_layout() {
    let r = Reflection::of(
        "struct Inner { x: f32 }
         struct Params {
             gain: f32, count: u32, bias: i32,
             direction: vec3f,
             sigma: f32,
             cells: vec2u,
             world_from_clip: mat4x4f,
             weights: array<vec4f, 5>,
             rotation: mat3x3f,
             inner: Inner,
         }
         @group(0) @binding(0) var<uniform> params: Params;
         @group(0) @binding(1) var<uniform> plain: vec3f;
         @group(0) @binding(2) var<storage, read_write> out: f32;
         @compute @workgroup_size(4, 2, 1) fn main() { out = params.gain + plain.x; }",
        "main",
    )
    .unwrap();
    assert_eq!(r.workgroup_size, [4, 2, 1]);
    let BindingKind::Uniform(layout) = &r.binding("params").unwrap().kind else {
        panic!()
    };
    assert_eq!(layout.size, 256);
    let members: Vec<_> = layout
        .members
        .iter()
        .map(|m| (m.name.as_str(), m.offset, m.ty.clone()))
        .collect();
    let vec = |n, scalar| MemberType::Vec { n, scalar };
    assert_eq!(
        members,
        [
            ("gain", 0, MemberType::F32),
            ("count", 4, MemberType::U32),
            ("bias", 8, MemberType::I32),
            ("direction", 16, vec(3, Scalar::F32)),
            ("sigma", 28, MemberType::F32),
            ("cells", 32, vec(2, Scalar::U32)),
            ("world_from_clip", 48, MemberType::Mat4),
            (
                "weights",
                112,
                MemberType::Array {
                    of: Box::new(vec(4, Scalar::F32)),
                    len: 5,
                    stride: 16
                }
            ),
            ("rotation", 192, MemberType::Other("mat3x3<f32>".into())),
            ("inner", 240, MemberType::Other("Inner".into())),
        ]
    );
    let BindingKind::Uniform(layout) = &r.binding("plain").unwrap().kind else {
        panic!()
    };
    assert_eq!((layout.size, layout.members.len()), (12, 1));
}

/// Access is what the entry point does, through the functions it calls, not what is declared.
#[test]
fn access_is_what_the_entry_point_does() {
    let r = Reflection::of(
        "@group(0) @binding(0) var<storage, read_write> only_read: array<f32>;
         @group(0) @binding(1) var<storage, read_write> only_written: array<f32>;
         @group(0) @binding(2) var<storage, read_write> both: array<f32>;
         @group(0) @binding(3) var<storage, read_write> counter: atomic<u32>;
         @group(0) @binding(4) var<storage, read> length: array<f32>;
         @group(0) @binding(5) var<storage, read> unused: array<f32>;
         @group(0) @binding(6) var image: texture_2d<f32>;
         @group(0) @binding(7) var size_only: texture_2d<u32>;
         @group(0) @binding(8) var target_: texture_storage_2d<r32float, read_write>;
         fn deep(i: u32) -> f32 { return only_read[i]; }
         @compute @workgroup_size(1) fn main() {
             only_written[0] = deep(0u) + f32(arrayLength(&length)) + textureLoad(image, vec2u(0), 0).x;
             both[1] += 1.0;
             atomicAdd(&counter, textureDimensions(size_only).x);
             textureStore(target_, vec2u(0), vec4f(0.0));
         }
         @compute @workgroup_size(1) fn other() { only_written[0] = unused[0]; }",
        "main",
    )
    .unwrap();
    use BindingAccess::*;
    assert_eq!(access(&r, "only_read"), Read);
    assert_eq!(access(&r, "only_written"), Write);
    assert_eq!(access(&r, "both"), ReadWrite);
    assert_eq!(access(&r, "counter"), ReadWrite);
    assert_eq!(access(&r, "length"), Read);
    assert_eq!(access(&r, "image"), Read);
    assert_eq!(access(&r, "size_only"), Read);
    assert_eq!(access(&r, "target_"), Write);
    assert_eq!(r.binding("unused"), None);
}

/// A texture is laid out as filterable only where a sampler meets it, also inside a function.
#[test]
fn filtering_follows_the_sampler() {
    let r = Reflection::of(
        "@group(0) @binding(0) var loaded: texture_2d<f32>;
         @group(0) @binding(1) var sampled: texture_2d<f32>;
         @group(0) @binding(2) var linear: sampler;
         @group(0) @binding(3) var depth: texture_depth_2d;
         @group(0) @binding(4) var layers: texture_2d_array<i32>;
         @group(1) @binding(0) var<storage, read_write> out: vec4f;
         fn fetch(t: texture_2d<f32>, s: sampler) -> vec4f {
             return textureSampleLevel(t, s, vec2f(0.5), 0.0);
         }
         @compute @workgroup_size(1) fn main() {
             out = fetch(sampled, linear) + textureLoad(loaded, vec2u(0), 0)
                 + textureLoad(depth, vec2u(0), 0) + vec4f(textureLoad(layers, vec2u(0), 0, 0));
         }",
        "main",
    )
    .unwrap();
    let kind = |name: &str| r.binding(name).unwrap().kind.clone();
    let dimension = wgpu::TextureViewDimension::D2;
    let float = |filtered| BindingKind::Sampled {
        sample: Sample::Float,
        dimension,
        filtered,
    };
    assert_eq!(kind("loaded"), float(false));
    assert_eq!(kind("sampled"), float(true));
    assert_eq!(kind("linear"), BindingKind::Sampler { comparison: false });
    assert_eq!(
        kind("depth"),
        BindingKind::Sampled {
            sample: Sample::Depth,
            dimension,
            filtered: false
        }
    );
    let dimension = wgpu::TextureViewDimension::D2Array;
    assert_eq!(
        kind("layers"),
        BindingKind::Sampled {
            sample: Sample::Sint,
            dimension,
            filtered: false
        }
    );
    assert_eq!(
        r.bindings.last().map(|b| (b.group, b.name.as_str())),
        Some((1, "out"))
    );
}

/// Mistakes point into the text.
#[test]
fn errors_point_into_the_text() {
    let text = "@compute @workgroup_size(1) fn main() { let x: f32 = 1u; }";
    let e = Reflection::of(text, "main").unwrap_err();
    assert_eq!(
        e.message,
        "the type of `x` is expected to be `f32`, but got `u32`"
    );
    assert_eq!(&text[e.labels[0].0.clone()], "x");
    let e = Reflection::of("@compute @workgroup_size(1) fn blur_x() {}", "blurx").unwrap_err();
    assert_eq!(e.message, "no entry point `blurx`: did you mean `blur_x`?");
    let e = Reflection::of(
        "@group(0) @binding(0) var t: texture_multisampled_2d<f32>;
         @compute @workgroup_size(1) fn main() { _ = textureLoad(t, vec2u(0), 0); }",
        "main",
    )
    .unwrap_err();
    assert_eq!(
        e.message,
        "`t` is a multisampled texture, which a frame graph cannot bind"
    );
    let e = Reflection::of(
        "override n: u32 = 8; @compute @workgroup_size(n) fn main() {}",
        "main",
    )
    .unwrap_err();
    assert_eq!(
        e.message,
        "the workgroup size of `main` must be literal numbers"
    );
}
