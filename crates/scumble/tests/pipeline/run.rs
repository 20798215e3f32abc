//! A frame is what its passes say; looking at it changes nothing.

use scumble::{FrameInput, Pipeline, Readback, ReportValue, jittered, wgsl};

use crate::rig::{Rig, Row, gpu, graph, read};
use crate::toys::registry;

const BLURRED: &[Row] = &[
    ("ramp", "ramp", &[]),
    ("blur", "blur", &[("value", "ramp.value")]),
];

#[test]
fn a_blurred_ramp_is_the_ramp_inside_and_pulled_in_at_the_border() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "blur.value")]),
        [5, 4],
    );
    let texels = rig.frame(0, "out");
    // Multiples of 1/2 below 2048 are exact in half floats.
    assert_eq!(texels[5 + 2][0], 102.0);
    assert_eq!(texels[0][0], 50.5);
    assert_eq!(texels.len(), 20);
}

#[test]
fn one_pixel_is_an_image() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "blur.value")]),
        [1, 1],
    );
    assert_eq!(rig.frame(0, "out"), [[0.0, 0.0, 0.0, 1.0]]);
}

#[test]
fn a_tap_changes_nothing_and_shows_the_port() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        (
            "sum",
            "past-copy",
            &[("value", "ramp.value"), ("past", "sum.value@prev")],
        ),
        ("blur", "blur", &[("value", "sum.value")]),
    ];
    let rendered = |taps: &[&str]| {
        let mut rig = Rig::new(graph(&registry(), rows, &[("out", "blur.value")]), [17, 9]);
        taps.iter().for_each(|tap| rig.pipeline.tap(tap).unwrap());
        let frames: Vec<_> = (0..3).map(|frame| rig.frame(frame, "out")).collect();
        let tapped: Vec<_> = taps
            .iter()
            .map(|tap| read(rig.pipeline.tapped(tap).unwrap()))
            .collect();
        let bits: Vec<_> = frames
            .concat()
            .iter()
            .map(|t| t.map(f32::to_bits))
            .collect();
        (bits, tapped)
    };
    let (plain, _) = rendered(&[]);
    let (tapped, seen) = rendered(&["ramp.value", "ramp.mask", "sum.value"]);
    assert_eq!(plain, tapped);
    assert_eq!(seen[0][18][0], 101.0);
    assert!(
        seen[1].iter().all(|t| t[0].to_bits() == 7),
        "the mask is only made when somebody looks"
    );
    assert_eq!(
        seen[2][18][0],
        4.0 * 101.0,
        "the first sum counts the value twice"
    );
}

#[test]
fn a_tap_that_is_taken_back_leaves_the_frame_as_it_was() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "blur.value")]),
        [8, 8],
    );
    rig.pipeline.keep_plan(true);
    let plan = |rig: &mut Rig| {
        rig.frame(0, "out");
        rig.pipeline.plan().unwrap().text.clone()
    };
    let plain = plan(&mut rig);
    rig.pipeline.tap("ramp.mask").unwrap();
    assert_ne!(plan(&mut rig), plain, "the mask is made");
    rig.pipeline.untap("ramp.mask");
    assert_eq!(plan(&mut rig), plain);
    assert!(rig.pipeline.tapped("ramp.mask").is_none());
}

#[test]
fn part_of_a_texture_comes_back_without_waiting() {
    let Some((device, queue)) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "ramp.value")]),
        [9, 5],
    );
    let whole = rig.frame(0, "out");
    let output = rig.pipeline.output("out").unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    // Two texels stand left of the border, four are asked for.
    let mut part = Readback::record(device, &mut encoder, output, [7, 3], [4, 1]).unwrap();
    assert!(part.take().is_none(), "it was not submitted");
    queue.submit([encoder.finish()]);
    part.submitted();
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let texels = part.take().unwrap().unwrap();
    assert_eq!(texels.size(), [2, 1]);
    assert_eq!(texels.decode(), whole[3 * 9 + 7..][..2]);
    assert!(part.take().is_none(), "it comes once");
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(_) = gpu() else { return };
    let run = || {
        let mut rig = Rig::new(
            graph(&registry(), BLURRED, &[("out", "blur.value")]),
            [33, 17],
        );
        rig.frame(4, "out")
            .iter()
            .map(|t| t.map(f32::to_bits))
            .collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

#[test]
fn an_output_may_have_several_names_and_formats_follow_the_port() {
    let Some(_) = gpu() else { return };
    let rows: &[Row] = &[
        ("ramp", "ramp", &[]),
        ("mean", "mean", &[("value", "ramp.value")]),
    ];
    let outputs = [
        ("a", "mean.value"),
        ("b", "mean.value"),
        ("c", "ramp.value"),
    ];
    let mut rig = Rig::new(graph(&registry(), rows, &outputs), [8, 8]);
    assert_eq!(rig.frame(0, "a"), rig.read("b"));
    assert_eq!(
        rig.pipeline.output("a").unwrap().format(),
        wgpu::TextureFormat::Rgba32Float,
        "a precise port"
    );
    assert_eq!(
        rig.pipeline.output("c").unwrap().format(),
        wgpu::TextureFormat::Rgba16Float
    );
    assert!(rig.pipeline.output("d").is_none());
}

#[test]
fn passes_are_timed_and_report() {
    let Some((device, _)) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "blur.value")]),
        [16, 16],
    );
    rig.pipeline.debug().timestamps = true;
    rig.pipeline.keep_plan(true);
    rig.frame(0, "out");
    if device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        let times = rig.pipeline.timings();
        let names: Vec<&str> = times.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["ramp", "blur"]);
        assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
    }
    let recorded = rig.pipeline.recording_times();
    assert_eq!(recorded[1].0, "blur");
    assert!(recorded.iter().all(|(_, ms)| *ms > 0.0), "{recorded:?}");
    let reports = rig.pipeline.reports().unwrap();
    let built = reports
        .iter()
        .find(|r| (r.pass.as_str(), r.key) == ("ramp", "built"))
        .unwrap();
    assert_eq!(built.value, ReportValue::Number(1.0));
    assert!(rig.pipeline.plan().unwrap().text.contains("blur/blur"));
    let memory = rig.pipeline.memory();
    assert!(
        memory.transient >= 2 * 16 * 16 * 8,
        "two half-float images: {memory:?}"
    );
}

#[test]
fn a_lost_device_is_an_error() {
    let Some(_) = gpu() else { return };
    let mut rig = Rig::new(
        graph(&registry(), BLURRED, &[("out", "blur.value")]),
        [4, 4],
    );
    rig.pipeline.device_lost_handler()(wgpu::DeviceLostReason::Unknown, "unplugged".to_owned());
    let error = rig.try_render(&FrameInput::default()).unwrap_err();
    assert_eq!(error.to_string(), "the device is lost: Unknown: unplugged");
}

#[test]
fn the_conventions_of_the_shaders_hold() {
    let Some((device, queue)) = gpu() else { return };
    // One thread per direction: encodes, decodes, and keeps the angle's sine; then the tests of one value each.
    let text = "
#include \"scumble/conventions.wgsl\"
@group(0) @binding(0) var out: texture_storage_2d<r32float, write>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    var result = 0.0;
    if i < 512u {
        let z = 1.0 - 2.0 * (f32(i) + 0.5) / 512.0;
        let phi = 2.399963 * f32(i);
        let n = normalize(vec3f(sqrt(1.0 - z * z) * cos(phi), sqrt(1.0 - z * z) * sin(phi), z));
        result = length(cross(n, octahedral_decode(octahedral_encode(n))));
    } else if i == 512u {
        result = f32(is_sky(SKY_Z)) + 2.0 * f32(is_hole(HOLE_Z)) + 4.0 * f32(is_surface(1.0))
            + 8.0 * f32(is_surface(SKY_Z)) + 16.0 * f32(is_surface(HOLE_Z)) + 32.0 * f32(is_sky(1e6)) + 64.0 * f32(is_hole(0.0));
    } else if i == 513u {
        result = luminance709(vec3f(1.0)) + f32(is_finite(bitcast<f32>(0x7f800000u | (i & 0u))))
            + f32(is_finite(bitcast<f32>(0x7fc00000u | (i & 0u)))) + 2.0 * f32(is_finite(F16_MAX));
    } else if i == 514u {
        result = octahedral_decode(octahedral_encode(vec3f(0.0, 0.0, -1.0))).z;
    }
    textureStore(out, vec2u(i, 0u), vec4f(result));
}";
    let composed = wgsl::compose("test.wgsl", text, &wgsl::Modules::new(), &[]).unwrap();
    let desc = framegraph::KernelDesc {
        label: "test",
        wgsl: composed.wgsl(),
        entry: "main",
        external_groups: &[],
    };
    let kernel = framegraph::ComputeKernel::new(device, &desc).unwrap();
    let mut pool = framegraph::Pool::new(device, queue);
    let mut g = pool.frame(framegraph::FrameParams {
        size: [1, 1],
        frame: 0,
    });
    let size = framegraph::Size::Absolute([576, 1]);
    let out = g.texture(
        "out",
        framegraph::TextureDesc::d2(wgpu::TextureFormat::R32Float, size),
    );
    let mut node = g.compute("test", &kernel);
    let out = node.overwrite("out", out);
    node.dispatch([9, 1, 1]);
    g.export_texture("out", out);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    g.compile()
        .unwrap()
        .encode(&mut encoder, &mut pool)
        .unwrap();
    queue.submit([encoder.finish()]);
    let out: Vec<f32> = read(pool.exported_texture("out").unwrap())
        .iter()
        .map(|t| t[0])
        .collect();
    // Two snorm16 over the octahedron: a step is 2/65534 in the plane, at most twice that on the sphere.
    let worst = out[..512].iter().copied().fold(0.0, f32::max);
    assert!(worst < 1e-4, "{worst}");
    assert_eq!(out[512], 7.0);
    assert!((out[513] - 3.0).abs() < 1e-6, "{}", out[513]);
    assert_eq!(out[514], -1.0);
}

#[test]
fn matrices_and_jitter_agree_with_the_uv_convention() {
    let camera = scumble::Camera::look_at([0.0, 0.0, 2.0], [0.0; 3], 90.0);
    let m = jittered(
        camera.clip_from_world([4, 4]),
        glam::Vec2::new(0.5, -0.5),
        [4, 4],
    );
    let clip = m * glam::Vec4::new(0.0, 0.0, 0.0, 1.0);
    let uv = [0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w];
    // What stood at the image centre now stands half a pixel left and down, at (0.5 - 0.5/4, 0.5 + 0.5/4).
    assert!(
        (uv[0] - 0.375).abs() < 1e-6 && (uv[1] - 0.625).abs() < 1e-6,
        "{uv:?}"
    );
}

#[test]
fn requirements_are_known_without_a_device() {
    let resolved = graph(&registry(), BLURRED, &[("out", "blur.value")]);
    let requirements = Pipeline::requirements(&resolved);
    assert!(requirements.features.is_empty() && requirements.host.is_empty());
    assert_eq!(requirements.limits.max_storage_buffers_per_shader_stage, 8);
    assert_eq!(requirements.passes.len(), 2);
}
