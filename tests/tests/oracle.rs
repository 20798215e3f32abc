//! Full path tracing against an independent renderer: images of the same files with the same BRDF by Mitsuba 3.
//!
//! The scenes and images are not in the repository: `SCUMBLE_SHARED` names the folder with `scenes/` and `oracle/`.
//! By default images are small (the oracle box-downsampled) and samples few; `SCUMBLE_FULL=1` renders them whole at
//! 512 spp, which takes the better part of an hour on a CPU.

use std::path::Path;

use scumble::{Edits, resolve};
use scumble_metrics::{BlockError, Image, block_error};
use scumble_scene::{LoadOptions, MaterialOverride, load};
use scumble_tests::{Renderer, View, graph_file};

/// Samples per pixel of a frame.
const SAMPLES: u32 = 2;

struct Case {
    scene: &'static str,
    oracle: &'static str,
    lambert: bool,
    /// Factor of the small version.
    shrink: u32,
    /// Samples per pixel of the small version.
    spp: u32,
    /// How far image means may lie apart.
    mean: f64,
}

/// Two independent halves of one rendering.
struct Halves([Image; 2]);

impl Halves {
    fn whole(&self) -> Image {
        let [a, b] = &self.0;
        let data = a
            .data
            .iter()
            .zip(&b.data)
            .map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c])))
            .collect();
        Image::new(a.width, a.height, data).unwrap()
    }
}

fn render(case: &Case, scene: &Path, size: [u32; 2], spp: u32) -> Halves {
    let options = LoadOptions {
        material_override: case.lambert.then_some(MaterialOverride::Lambert),
        ..LoadOptions::default()
    };
    let scene = load(scene, &options).unwrap();
    let renderer = Renderer::new();
    let edits = Edits {
        set: [
            ("gbuffer.source", "RayTraced".into()),
            ("path-trace.samples", SAMPLES.to_string()),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into(),
        ..Edits::default()
    };
    let graph = resolve(graph_file("reference.ron"), &renderer.registry, &edits).unwrap();

    // The first and the second half of the frames: both spread evenly over the pixel, which even and odd ones would not.
    // The second is what the mean of all has beyond that of the first.
    let half = (spp / SAMPLES).div_ceil(2);
    let (mut first, mut second) = (Vec::new(), Vec::new());
    let view = View {
        scene,
        size,
        frames: 2 * half,
        seed: 1,
    };
    renderer.render(graph, view, &["linear"], |frame, mean| {
        let mean = || mean[0].iter().map(|&[r, g, b, _]| [r, g, b]);
        if frame + 1 == half {
            first = mean().collect();
        } else if frame + 1 == 2 * half {
            let rest =
                |(all, first): ([f32; 3], &[f32; 3])| [0, 1, 2].map(|c| 2.0 * all[c] - first[c]);
            second = mean().zip(&first).map(rest).collect();
        }
    });
    Halves([first, second].map(|data| Image::new(size[0], size[1], data).unwrap()))
}

fn check(case: &Case) {
    let (Some(scene), Some(oracle)) = (
        scumble_scene::shared(format!("scenes/{}", case.scene)),
        scumble_scene::shared(format!("oracle/{}", case.oracle)),
    ) else {
        eprintln!(
            "SKIPPED: scenes/{} and oracle/{} are not there; set SCUMBLE_SHARED to the folder that has them",
            case.scene, case.oracle
        );
        return;
    };
    let full = std::env::var_os("SCUMBLE_FULL").is_some_and(|v| v == "1");
    let oracle = scumble_metrics::read(oracle).unwrap();
    let (oracle, spp) = match full {
        true => (oracle, 512),
        false => (oracle.box_downsample(case.shrink).unwrap(), case.spp),
    };
    let halves = render(case, &scene, [oracle.width, oracle.height], spp);
    let ours = halves.whole();
    let against: BlockError = block_error(&ours, &oracle).unwrap();
    let noise: BlockError = block_error(&halves.0[0], &halves.0[1]).unwrap();
    println!(
        "{} at {}x{}, {spp} spp: {against:?}; halves: {noise:?}",
        case.oracle, ours.width, ours.height
    );
    // Half the difference of the halves is one draw of the noise of the mean: small against what is allowed, or the
    // comparison says nothing.
    assert!(
        0.5 * noise.mean.abs() < 0.5 * case.mean,
        "{}: too noisy to say: {noise:?}",
        case.oracle
    );
    assert!(
        against.mean.abs() < case.mean,
        "{}: {against:?}",
        case.oracle
    );
    // Errors of 16x16 block means: twice what two halves differ by, one per cent for the oracle's own noise.
    let limit = (2.0 * noise.p95 + 0.01).min(0.08);
    assert!(
        against.p95 <= limit,
        "{}: p95 {} above {limit}; {noise:?}",
        case.oracle,
        against.p95
    );
}

#[test]
fn coffee_lambert() {
    check(&Case {
        scene: "coffee.glb",
        oracle: "coffee-diffuse.exr",
        lambert: true,
        shrink: 5,
        spp: 128,
        mean: 0.01,
    });
}

#[test]
fn coffee_gltf() {
    check(&Case {
        scene: "coffee.glb",
        oracle: "coffee-gltf.exr",
        lambert: false,
        shrink: 5,
        spp: 128,
        mean: 0.02,
    });
}

#[test]
fn kitchen_lambert() {
    check(&Case {
        scene: "kitchen.glb",
        oracle: "kitchen-diffuse.exr",
        lambert: true,
        shrink: 5,
        spp: 128,
        mean: 0.01,
    });
}

#[test]
fn kitchen_gltf() {
    check(&Case {
        scene: "kitchen.glb",
        oracle: "kitchen-gltf.exr",
        lambert: false,
        shrink: 5,
        spp: 128,
        mean: 0.02,
    });
}
