//! Figure 1 of Boughida et al. 2016: direct light, path tracing at 1 spp, and the upsampled image of the atrium,
//! judged by their high frequencies. What the filters must remove is noise from pixel to pixel, so an image's error
//! here is that of x minus its 3x3 mean.

use scumble::{Edits, Resolved, resolve};
use scumble_metrics::Image;
use scumble_tests::{Renderer, View, graph_file};

/// What an image has beyond the mean of its 3x3 neighbourhood (of the pixels there are), per pixel and channel.
fn high_pass(image: &Image) -> Vec<f64> {
    let (w, h) = (image.width as i64, image.height as i64);
    let mut high = Vec::new();
    for y in 0..h {
        for x in 0..w {
            let around: Vec<_> = (-1..=1)
                .flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
                .filter(|&(x, y)| (0..w).contains(&x) && (0..h).contains(&y))
                .map(|(x, y)| image.data[(y * w + x) as usize])
                .collect();
            for c in 0..3 {
                let mean: f64 =
                    around.iter().map(|p| f64::from(p[c])).sum::<f64>() / around.len() as f64;
                high.push(f64::from(image.data[(y * w + x) as usize][c]) - mean);
            }
        }
    }
    high
}

/// Energy of the high-pass error, per pixel and channel.
fn high_pass_error(image: &Image, reference: &Image) -> f64 {
    let (a, b) = (high_pass(image), high_pass(reference));
    a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64
}

#[test]
fn high_pass_error_of_known_images() {
    let flat = Image::from_fn(8, 8, |_, _| [0.5; 3]);
    let ramp = Image::from_fn(8, 8, |x, y| [x as f32, y as f32, 0.0]);
    let dot = Image::from_fn(8, 8, |x, y| [f32::from(u8::from(x == 4 && y == 4)); 3]);
    assert_eq!(high_pass_error(&ramp, &ramp), 0.0);
    assert_eq!(
        high_pass_error(&flat, &Image::from_fn(8, 8, |_, _| [0.0; 3])),
        0.0
    );
    // The dot keeps 8/9 of itself and gives each of its eight neighbours -1/9.
    let expected = ((8.0f64 / 9.0).powi(2) + 8.0 / 81.0) / 64.0;
    assert!((high_pass_error(&dot, &flat) - expected).abs() < 1e-6);
}

/// At most 1/20 of the high-pass error of 1 spp is left. The reference samples the centre of each pixel, as both
/// images do: what is compared is noise, not antialiasing. Its own noise, 1/64 of that of 1 spp, is counted against
/// us.
#[test]
fn upsampling_removes_the_noise_of_path_tracing() {
    let full = std::env::var_os("SCUMBLE_FULL").is_some_and(|v| v == "1");
    let (size, reference_frames) = if full {
        ([512, 512], 256)
    } else {
        ([96, 96], 64)
    };
    let renderer = Renderer::new();
    let graph = |name: &str, edits: &Edits| -> Resolved {
        resolve(graph_file(name), &renderer.registry, edits).unwrap()
    };
    let image = |graph: Resolved, frames: u32, seed: u32| {
        let scene = scumble_scene::builtin("atrium").unwrap();
        let view = View {
            scene,
            size,
            frames,
            seed,
        };
        renderer.image(graph, view, "linear")
    };
    let centre = Edits {
        set: vec![("gbuffer.jitter".into(), "Off".into())],
        ..Edits::default()
    };
    let reference = image(graph("reference.ron", &centre), reference_frames, 7);
    let traced = image(graph("path-trace-1spp.ron", &Edits::default()), 1, 1);
    let ours = image(graph("upsample-2016.ron", &Edits::default()), 1, 1);
    let (traced, ours) = (
        high_pass_error(&traced, &reference),
        high_pass_error(&ours, &reference),
    );
    println!(
        "{size:?}: 1 spp {traced:.3e}, upsampled {ours:.3e}: 1/{:.1}",
        traced / ours
    );
    assert!(ours * 20.0 <= traced, "1 spp {traced}, upsampled {ours}");
}
