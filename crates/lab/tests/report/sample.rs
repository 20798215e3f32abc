//! Results with everything that a report shows, and names that are trouble.

use scumble_lab::{
    CameraDesign, Design, Exposed, Factorial, Failure, FrameRecord, Images, Record, Results, Sweep,
    SweepPoint, VariantDesign,
};
use scumble_metrics::Image;
use std::path::Path;

pub const SIZE: [u32; 2] = [32, 24];
/// What HTML would take for its own.
pub const ODD: &str = "a \"quoted\" <b>&amp;</b> 'name'</script>";
pub const EXPOSURE: f64 = 0.5;
const FRAMES: [u32; 2] = [3, 7];

/// Radiance of a method at a frame; that of the reference is `None`.
pub fn radiance(method: Option<usize>, frame: u32, x: u32, y: u32) -> [f32; 3] {
    let scale = method.map_or(1.0, |m| 1.5 + 0.25 * m as f32 - 0.0625 * frame as f32);
    [x as f32 / 32.0, y as f32 / 24.0, 0.5].map(|v| v * scale)
}

fn image(method: Option<usize>, frame: u32) -> Image {
    Image::from_fn(SIZE[0], SIZE[1], |x, y| radiance(method, frame, x, y))
}

fn design() -> Design {
    let variant = |name: &str| VariantDesign {
        name: name.to_owned(),
        about: format!("about {name}"),
        changes: Vec::new(),
        options: vec!["g.ron".into(), "--set".into(), "a.b=1".into()],
        paths: 1.0,
    };
    let point = |value: &str, variant| SweepPoint {
        values: vec![value.into()],
        variant,
    };
    Design {
        name: "sample".into(),
        about: format!("What is {ODD}?"),
        command: "scumble ablate sample.ron".into(),
        scenes: vec!["cornell".into(), "a & b".into()],
        cameras: vec![CameraDesign {
            name: "still".into(),
            frames: 8,
            references: FRAMES.into(),
        }],
        variants: ["base", ODD, "without x", "both"].map(variant).into(),
        factorial: Some(Factorial {
            factors: vec![ODD.into(), "without x".into()],
            variants: vec![0, 1, 2, 3],
        }),
        sweep: Some(Sweep {
            params: vec!["p.spacing".into()],
            points: vec![point("4", 1), point("8", 2)],
        }),
        metrics: ["relmse", "ssim", "flip", "energy", "flicker"]
            .map(String::from)
            .into(),
        seeds: vec![1, 2, 3],
        size: SIZE,
        equal_rays: Some(1.0),
        reference_samples: 64,
        ..Design::default()
    }
}

fn record(design: &Design, scene: &str, method: usize, seed: u32) -> Record {
    // Numbers that differ in everything, with many digits.
    let noise = f64::from(seed * 37 % 11) * 0.0013 + method as f64 * 0.0171;
    let frame = |frame: u32| FrameRecord {
        frame,
        reference: format!("reference of {scene}"),
        metrics: [
            ("relmse", 0.3 / f64::from(frame) + noise),
            ("ssim", 0.9 - noise),
            ("flip", 0.1 + noise / 3.0),
            ("energy", 1.0 + noise / 7.0),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into(),
    };
    let times = |ms: f64| {
        (0..8)
            .map(|i| ms * (1.0 + 0.1 * f64::from(i)))
            .collect::<Vec<_>>()
    };
    Record {
        key: format!("{scene}-{method}-{seed}-0123456789abcdef"),
        scene: scene.to_owned(),
        camera: "still".into(),
        variant: design.variants[method].name.clone(),
        seed,
        adapter: "adapter <1>".into(),
        driver: "driver & co".into(),
        exposure: EXPOSURE,
        counts: [("a.samples".to_owned(), 3)].into(),
        rates: [].into(),
        rays: vec![2000.0; 8],
        seconds: times(0.004 * (method + 1) as f64),
        passes: [("a", 1.0), ("b/c", 2.5)]
            .map(|(name, ms)| (name.into(), times(ms)))
            .into(),
        memory: 1_234_567,
        frames: FRAMES.map(frame).into(),
        flicker: Some(0.01 + noise),
    }
}

/// Results whose images are written into a folder.
pub fn results(folder: &Path) -> Results {
    let design = design();
    let mut records = Vec::new();
    for scene in &design.scenes {
        for method in 0..design.variants.len() {
            let seeds = design.seeds.iter();
            records.extend(seeds.map(|seed| record(&design, scene, method, *seed)));
        }
    }
    let images = Images::new(folder);
    let exposed = |image: &Image| Exposed::new(image, EXPOSURE);
    let truth = image(None, 0);
    for record in records.iter().filter(|r| r.seed == 1) {
        let method = design
            .variants
            .iter()
            .position(|v| v.name == record.variant);
        for frame in FRAMES {
            let radiance = image(method, frame);
            let pair = [&exposed(&radiance), &exposed(&truth)];
            images.write_run(record, frame, pair, &radiance).unwrap();
        }
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"90\" height=\"30\">\
                   <style>text { fill: #123456 }</style><text y=\"20\">a graph</text></svg>";
        images.write_graph(record, svg).unwrap();
        let (scene, key) = (&record.scene, &record.frames[0].reference);
        images
            .write_reference(scene, "still", key, &exposed(&truth), &truth)
            .unwrap();
    }
    let failure = Failure {
        scene: Some("nowhere <i>".into()),
        message: "there is no such file".into(),
        ..Failure::default()
    };
    Results::of(design, records, vec![failure])
}
