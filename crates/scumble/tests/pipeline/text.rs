//! From the text of a graph file to an image.

use scumble::{Edits, FrameInput, PortSignal, resolve_text, signal};

use crate::rig::{Rig, gpu};
use crate::toys::registry;

const GRAPH: &str = r#"(
    version: 1,
    about: "a ramp on a grid, summed over frames",
    passes: [
        (use: "ramp", with: (gain: 2.0, angle: 180.0)),
        (use: "down", with: (spacing: 8), in: {"value": "ramp.value"}),
        (use: "up", in: {"value": "down.value"}),
        (use: "past-copy", as: "sum", in: {"value": "up.value", "past": "sum.value@prev"}),
        (use: "blur", in: {"value": "sum.value"}),
    ],
    outputs: {"out": "blur.value", "sum": "sum.value"},
)"#;

fn rig(edits: &Edits) -> Rig {
    let resolved =
        resolve_text("test.ron", GRAPH, &registry(), edits).unwrap_or_else(|e| panic!("{e}"));
    Rig::new(resolved, [16, 16])
}

#[test]
fn a_text_becomes_an_image() {
    let Some(_) = gpu() else { return };
    let mut rig = rig(&Edits::default());
    rig.frame(0, "out");
    // Every pixel of the first cell shows its traced pixel (4, 4), twice in the first frame.
    assert_eq!(
        rig.read("sum")[0],
        [1616.0, std::f32::consts::PI.to_half() * 2.0, 0.0, 2.0]
    );
    assert_eq!(rig.read("out")[0][0], 1616.0);
    rig.frame(1, "out");
    assert_eq!(rig.read("sum")[0][0], 3.0 * 808.0);
}

trait ToHalf {
    fn to_half(self) -> f32;
}

impl ToHalf for f32 {
    fn to_half(self) -> f32 {
        half::f16::from_f32(self).to_f32()
    }
}

#[test]
fn edits_set_and_bypass() {
    let Some(_) = gpu() else { return };
    let edits = Edits {
        set: vec![
            ("ramp.gain".into(), "1".into()),
            ("down.spacing".into(), "4".into()),
        ],
        bypass: vec!["blur".into(), "up".into()],
        ..Edits::default()
    };
    let mut rig = rig(&edits);
    rig.frame(0, "out");
    // `up` now interpolates: at the traced pixel (6, 2) it is the ramp itself.
    let out = rig.read("out");
    assert_eq!(out[2 * 16 + 6][0], 2.0 * 206.0);
    assert_eq!(out, rig.read("sum"));
}

#[test]
fn a_graph_fed_by_the_host_runs_on_its_images() {
    let Some((device, queue)) = gpu() else { return };
    let text = r#"(
        version: 1,
        inputs: {"image": (signal: radiance, resolution: full)},
        passes: [(use: "blur", in: {"value": "image"})],
        outputs: {"out": "blur.value", "same": "image"},
    )"#;
    let resolved = resolve_text("fed.ron", text, &registry(), &Edits::default())
        .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(resolved.passes[0].ty.inputs[0].signal, PortSignal::Any);
    let mut rig = Rig::new(resolved, [2, 1]);
    let error = rig.try_render(&FrameInput::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "graph input `image`: no texture is bound to it"
    );
    let image = |[width, height]: [u32; 2], format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    use wgpu::TextureUsages as U;
    let all = U::TEXTURE_BINDING | U::COPY_SRC | U::COPY_DST;
    let mut refused = |name: &str, texture| {
        rig.pipeline
            .bind_input(name, &texture)
            .unwrap_err()
            .to_string()
    };
    let wrong = image([2, 1], wgpu::TextureFormat::R32Float, all);
    assert_eq!(
        refused("image", wrong),
        "graph input `image`: it carries radiance, which is Rgba16Float, and not R32Float"
    );
    let bare = image([2, 1], wgpu::TextureFormat::Rgba16Float, U::COPY_SRC);
    assert!(refused("image", bare).contains("lacks the usage TEXTURE_BINDING"));
    let other = image([2, 1], wgpu::TextureFormat::Rgba16Float, all);
    assert_eq!(
        refused("imge", other),
        "there is no graph input `imge`; did you mean `image`?"
    );

    rig.pipeline
        .bind_input(
            "image",
            &image([3, 1], wgpu::TextureFormat::Rgba16Float, all),
        )
        .unwrap();
    let error = rig.try_render(&FrameInput::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "graph input `image`: the texture is 3x1, and must be 2x1"
    );

    // A precise texture feeds the same graph.
    let fed = image([2, 1], wgpu::TextureFormat::Rgba32Float, all);
    let texels: [[f32; 4]; 2] = [[1.0; 4], [3.0; 4]];
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(32),
        rows_per_image: None,
    };
    queue.write_texture(
        fed.as_image_copy(),
        bytemuck::cast_slice(&texels),
        layout,
        fed.size(),
    );
    rig.pipeline.bind_input("image", &fed).unwrap();
    assert_eq!(rig.frame(0, "out"), [[2.0, 2.0, 2.0, 1.0]; 2]);
    assert_eq!(rig.read("same"), texels);

    // The format of specular light is that of radiance, and it is not radiance.
    let error = rig.pipeline.bind_signal("image", signal::SPECULAR, &fed);
    assert_eq!(
        error.unwrap_err().to_string(),
        "graph input `image`: it takes radiance, and the texture carries specular"
    );
    rig.pipeline
        .bind_signal("image", signal::RADIANCE, &fed)
        .unwrap();
    let deep = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 2,
            height: 1,
            depth_or_array_layers: 2,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: all,
        view_formats: &[],
    });
    let error = rig.pipeline.bind_input("image", &deep).unwrap_err();
    assert_eq!(
        error.to_string(),
        "graph input `image`: the texture is not a single 2D image"
    );
    rig.pipeline.unbind_input("image").unwrap();
    let error = rig.try_render(&FrameInput::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "graph input `image`: no texture is bound to it"
    );
}

#[test]
fn what_the_host_fed_in_the_frame_before_is_kept_for_who_reads_it() {
    let Some((device, queue)) = gpu() else { return };
    let text = r#"(
        version: 1,
        inputs: {"image": (signal: radiance, resolution: full)},
        passes: [(use: "past-skip", in: {"value": "image", "past": "image@prev"})],
        outputs: {"out": "past-skip.value"},
    )"#;
    let resolved = resolve_text("fed.ron", text, &registry(), &Edits::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let mut rig = Rig::new(resolved, [1, 1]);
    use wgpu::TextureUsages as U;
    let image = |usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage,
            view_formats: &[],
        })
    };
    let bare = image(U::TEXTURE_BINDING | U::COPY_DST);
    assert_eq!(
        rig.pipeline
            .bind_input("image", &bare)
            .unwrap_err()
            .to_string(),
        "graph input `image`: the texture lacks the usage COPY_SRC: its previous frame is read, so it is copied"
    );
    let fed = image(U::TEXTURE_BINDING | U::COPY_DST | U::COPY_SRC);
    rig.pipeline.bind_input("image", &fed).unwrap();
    let mut frame = |value: f32, cut: bool| {
        let texel = [[value, value, value, 1.0]];
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(16),
            rows_per_image: None,
        };
        queue.write_texture(
            fed.as_image_copy(),
            bytemuck::cast_slice(&texel),
            layout,
            fed.size(),
        );
        rig.render(&FrameInput {
            cut,
            ..FrameInput::default()
        });
        rig.read("out")[0][0]
    };
    // `past-skip` adds 1000 where it has no past.
    assert_eq!(frame(1.0, false), 1001.0);
    assert_eq!(frame(2.0, false), 3.0);
    assert_eq!(frame(4.0, false), 6.0);
    assert_eq!(frame(8.0, true), 1008.0, "after a cut");
    assert_eq!(frame(16.0, false), 24.0);
}
