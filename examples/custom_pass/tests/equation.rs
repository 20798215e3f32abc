//! One step on a row of three texels, against the equation by hand.

use half::f16;
use scumble::{Edits, FrameInput, Host, Pipeline, readback, resolve_text};

const GRAPH: &str = r#"(
    version: 1,
    inputs: {
        "light": (signal: irradiance, resolution: full),
        "depth": (signal: view_z, resolution: full),
    },
    passes: [(use: "diffusion", with: (iterations: 1, lambda: 0.25, kappa: 0.5), in: {"value": "light", "view_z": "depth"})],
    outputs: {"light": "diffusion.value", "conduction": "diffusion.conduction"},
)"#;

#[test]
fn light_flows_as_the_equation_says() {
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter).expect("an adapter; Mesa's software driver is one");
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    let mut registry = scumble_passes::registry();
    custom_pass::register(&mut registry);
    let graph = resolve_text("row.ron", GRAPH, &registry, &Edits::default()).unwrap();
    let mut host = Host::new();
    let mut pipeline = Pipeline::new(&device, &queue, &registry, graph, &host, [3, 1]).unwrap();

    let texture = |format, bytes: &[u8]| {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: 3,
                height: 1,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32),
            rows_per_image: None,
        };
        queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        texture
    };
    let row = [1.0f32, 2.0, 2.25];
    let texels = row.map(|v| [v, v, v, 1.0].map(|x| f16::from_f32(x).to_le_bytes()));
    let light = texture(
        wgpu::TextureFormat::Rgba16Float,
        texels.as_flattened().as_flattened(),
    );
    let depth = [1.0f32; 3].map(f32::to_le_bytes);
    let depth = texture(wgpu::TextureFormat::R32Float, depth.as_flattened());
    pipeline.bind_input("light", &light).unwrap();
    pipeline.bind_input("depth", &depth).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    pipeline
        .render(&mut encoder, &FrameInput::default(), &mut host)
        .unwrap();
    queue.submit([encoder.finish()]);
    let read = |name: &str| readback(&device, &queue, pipeline.output(name).unwrap()).unwrap();

    let g = |a: f64, b: f64| (-((b - a) / (0.5 * (a + b + 0.001))).powi(2)).exp();
    let [a, b, c] = row.map(f64::from);
    let expected = [
        (a + 0.25 * g(a, b) * (b - a), g(a, b)),
        (
            b + 0.25 * (g(a, b) * (a - b) + g(b, c) * (c - b)),
            0.5 * (g(a, b) + g(b, c)),
        ),
        (c + 0.25 * g(b, c) * (b - c), g(b, c)),
    ];
    for (i, (light, conduction)) in expected.into_iter().enumerate() {
        // Half a step of a half float below 4 (2^-10), and what a GPU's exp may be off (3 + 2 |x| steps of f32).
        let found = f64::from(read("light")[i][0]);
        assert!(
            (found - light).abs() < 1e-3,
            "texel {i}: {found}, not {light}"
        );
        let found = f64::from(read("conduction")[i][0]);
        assert!(
            (found - conduction).abs() < 1e-5,
            "texel {i}: {found}, not {conduction}"
        );
    }
}
