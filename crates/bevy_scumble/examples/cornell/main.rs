//! A box with a lamp, drawn by Bevy alone and with indirect light, without a window.
//!
//! `cargo run --ignore-rust-version --example cornell` writes `out/bevy/without.png`, `out/bevy/with.0001.png` and on, and says
//! what a frame takes. The first argument is the number of frames, the second the graph.

mod headless;

use bevy::diagnostic::DiagnosticsStore;
use bevy::prelude::*;
use bevy::render::diagnostic::RenderDiagnosticsPlugin;
use bevy_scumble::{IndirectLight, ScumblePlugin};
use headless::{EYE, Headless, TARGET};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const SIZE: UVec2 = UVec2::new(320, 240);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let frames: u32 = arguments.next().map_or(Ok(10), |n| n.parse())?;
    let graph = arguments.next().unwrap_or("indirect.ron".to_owned());
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let folder = Path::new("out/bevy");
    std::fs::create_dir_all(folder)?;

    let mut plain = Headless::new(SIZE, &assets);
    plain.app.add_plugins(RenderDiagnosticsPlugin);
    plain.start();
    let seconds = render(&mut plain, frames, None)?;
    save(&plain, &folder.join("without.png"))?;
    println!("Bevy alone: {:.1} ms per frame", 1000.0 * seconds);

    let mut lit = Headless::new(SIZE, &assets);
    lit.app
        .add_plugins((RenderDiagnosticsPlugin, ScumblePlugin::default()));
    lit.start();
    let graph = lit.app.world().resource::<AssetServer>().load(graph);
    while !lit.app.world().resource::<AssetServer>().is_loaded(&graph) {
        lit.app.update();
    }
    lit.app
        .world_mut()
        .entity_mut(lit.camera)
        .insert(IndirectLight::new(graph));
    let seconds = render(&mut lit, frames, Some(folder))?;
    println!(
        "with indirect light: {:.1} ms per frame, of which",
        1000.0 * seconds
    );
    let diagnostics = lit.app.world().resource::<DiagnosticsStore>();
    for diagnostic in diagnostics.iter() {
        let path = diagnostic.path().as_str();
        if path.contains("scumble") {
            println!("  {path}: {:.3} ms", median(diagnostic.values().copied()));
        }
    }
    Ok(())
}

/// Renders, the camera moving a little each frame; gives the median time of a frame in seconds.
fn render(
    headless: &mut Headless,
    frames: u32,
    folder: Option<&Path>,
) -> Result<f64, Box<dyn Error>> {
    let mut times = Vec::new();
    for frame in 1..=frames {
        let aside = 0.01 * frame as f32;
        let place = Transform::from_translation(EYE + aside * Vec3::X).looking_at(TARGET, Vec3::Y);
        headless
            .app
            .world_mut()
            .entity_mut(headless.camera)
            .insert(place);
        let start = Instant::now();
        headless.app.update();
        // Waits for the image.
        let pixels = headless.pixels();
        times.push(start.elapsed().as_secs_f64());
        pixels.ok_or("there is no image")?;
        if let Some(folder) = folder {
            save(headless, &folder.join(format!("with.{frame:04}.png")))?;
        }
    }
    Ok(median(times))
}

/// The first ones, in which pipelines are made, do not move it.
fn median(times: impl IntoIterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.into_iter().collect();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// Writes the image, sRGB-encoded.
fn save(headless: &Headless, path: &Path) -> Result<(), Box<dyn Error>> {
    let pixels = headless.pixels().ok_or("there is no image")?;
    let encode = |c: f32| match c.clamp(0.0, 1.0) {
        c if c <= 0.003_130_8 => 12.92 * c,
        c => 1.055 * c.powf(1.0 / 2.4) - 0.055,
    };
    let bytes = pixels
        .as_flattened()
        .iter()
        .map(|c| (255.0 * encode(*c) + 0.5) as u8);
    let image = ::image::RgbImage::from_raw(SIZE.x, SIZE.y, bytes.collect());
    image.ok_or("the image has another size")?.save(path)?;
    println!("{}", path.display());
    Ok(())
}
