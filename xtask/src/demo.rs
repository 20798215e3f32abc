//! Figure 1 of Boughida, Groueix and Boubekeur 2016, of the built-in atrium.

use crate::command::{Done, run as run_command, scumble};
use crate::setup;

/// The three graphs of the figure, left to right.
pub const GRAPHS: [(&str, &str); 3] = [
    ("direct-only", "direct light only"),
    ("path-trace-1spp", "path tracing, 1 sample per pixel"),
    (
        "upsample-2016",
        "sparse indirect light, 16x16 pixels and 100 samples, upsampled",
    ),
];

/// One exposure for all three, so that they differ in their light alone; it is what the automatic
/// exposure gives the last one.
const EXPOSURE: [&str; 4] = [
    "--set",
    "tonemap.exposure=Manual",
    "--set",
    "tonemap.ev=0.4",
];

/// Renders them into `out/demo/`, as PNG to look at and EXR to measure.
pub fn run(size: &str) -> Done {
    setup::run()?;
    for (name, about) in GRAPHS {
        println!("\n{name}: {about}");
        let [graph, png, exr] = [
            format!("graphs/{name}.ron"),
            format!("out/demo/{name}.png"),
            format!("out/demo/{name}.exr"),
        ];
        let render = [
            "render", &graph, "--scene", "atrium", "--size", size, "--stats",
        ];
        let output = ["--output", &png, "--output", &exr];
        run_command(scumble(&[&render[..], &EXPOSURE, &output].concat()))?;
    }
    println!("\nThe pictures, side by side in the paper's Figure 1:");
    for (name, about) in GRAPHS {
        println!("  out/demo/{name}.png  {about}");
    }
    Ok(())
}
