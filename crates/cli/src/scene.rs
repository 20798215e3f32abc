//! Scenes by name or file, and `scumble scene`.

use crate::args::{Override, SceneChanges, SceneExportArgs, SceneInfoArgs, SceneVerb};
use crate::failure::Failure;
use crate::{folder, report};
use glam::Vec3;
use scumble_scene::{Scene, Sky};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What `--sky` asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum SkyChoice {
    Constant(Vec3),
    File(PathBuf),
}

impl FromStr for SkyChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let radiance = match numbers.as_deref() {
            Err(_) => return Ok(Self::File(text.into())),
            Ok(&[grey]) => Vec3::splat(grey),
            Ok(&[r, g, b]) => Vec3::new(r, g, b),
            Ok(_) => return Err("give one radiance, or three".into()),
        };
        if !(radiance.is_finite() && radiance.min_element() >= 0.0) {
            return Err("a radiance is finite, and 0 or more".into());
        }
        Ok(Self::Constant(radiance))
    }
}

impl SkyChoice {
    fn load(&self) -> Result<Sky, Failure> {
        match self {
            Self::Constant(radiance) => Ok(Sky::Constant(*radiance)),
            Self::File(path) => {
                let image = scumble_metrics::read(path)?;
                let good = |v: &f32| v.is_finite() && *v >= 0.0;
                if !image.data.iter().flatten().all(good) {
                    return Err(Failure::BadSky { path: path.clone() });
                }
                Ok(Sky::Equirect {
                    width: image.width,
                    height: image.height,
                    rgb: image.data,
                    scale: 1.0,
                    rotation: 0.0,
                })
            }
        }
    }
}

/// The built-in scene of that name, or the file's; a name that is no file here may be one of the shared
/// test scenes.
pub fn load(name: &Path, changes: &SceneChanges) -> Result<Scene, Failure> {
    let sky = changes.sky.as_ref().map(SkyChoice::load).transpose()?;
    let lambert = matches!(changes.material_override, Some(Override::Lambert));
    Ok(scumble_lab::load_scene(name, lambert, sky)?)
}

pub fn run(verb: &SceneVerb) -> Result<(), Failure> {
    match verb {
        SceneVerb::Info(args) => info(args),
        SceneVerb::Export(args) => export(args),
    }
}

fn export(args: &SceneExportArgs) -> Result<(), Failure> {
    let scene = load(&args.scene, &args.changes)?;
    scene.warnings.iter().for_each(report::note);
    folder::prepare(&folder::of(&args.output))?;
    Ok(scumble_scene::export(&scene, &args.output)?)
}

fn info(args: &SceneInfoArgs) -> Result<(), Failure> {
    let scene = load(&args.scene, &args.changes)?;
    if args.json {
        report::json(&as_json(&scene));
    } else {
        report::line(as_text(&scene).trim_end());
    }
    Ok(())
}

fn sky(sky: &Sky) -> String {
    match sky {
        Sky::Constant(radiance) => format!("{} {} {}", radiance.x, radiance.y, radiance.z),
        Sky::Equirect { width, height, .. } => format!("an image of {width}x{height}"),
    }
}

fn sky_as_json(sky: &Sky) -> serde_json::Value {
    match sky {
        Sky::Constant(radiance) => json!({"kind": "constant", "radiance": radiance.to_array()}),
        Sky::Equirect { width, height, .. } => json!({"kind": "image", "size": [width, height]}),
    }
}

fn as_text(scene: &Scene) -> String {
    let (stats, bounds) = (scene.stats(), scene.bounds());
    let mut text = format!("{}\n", scene.name);
    let mut row = |name: &str, value: String| text += &format!("  {name:<12}{value}\n");
    row(
        "triangles",
        format!(
            "{} in {} instances of {} meshes",
            stats.triangles, stats.instances, stats.meshes
        ),
    );
    row(
        "stored",
        format!(
            "{} triangles, {} vertices",
            stats.mesh_triangles, stats.vertices
        ),
    );
    row("materials", stats.materials.to_string());
    row(
        "textures",
        format!(
            "{} ({:.1} MiB)",
            stats.textures,
            stats.texture_bytes as f64 / 1024.0 / 1024.0
        ),
    );
    row(
        "lights",
        format!(
            "{} punctual, {} emissive triangles",
            stats.lights, stats.emissive_triangles
        ),
    );
    row("sky", sky(&scene.sky));
    row(
        "bounds",
        format!("{:.3} to {:.3} m", bounds.min, bounds.max),
    );
    if stats.animation_seconds > 0.0 {
        row("animation", format!("{} s", stats.animation_seconds));
    }
    for (number, camera) in scene.cameras.iter().enumerate() {
        let eye = camera.world_from_view.translation;
        let fov = camera.y_fov.to_degrees();
        row(
            if number == 0 { "cameras" } else { "" },
            format!(
                "{number}: `{}` at {eye:.3}, {fov:.1} degrees high",
                camera.name
            ),
        );
    }
    for warning in &scene.warnings {
        text += &format!("  note: {warning}\n");
    }
    text
}

fn as_json(scene: &Scene) -> serde_json::Value {
    let (stats, bounds) = (scene.stats(), scene.bounds());
    let cameras = scene.cameras.iter().map(|camera| {
        let eye = camera.world_from_view.translation.to_array();
        json!({"name": camera.name, "eye": eye, "fov_degrees": camera.y_fov.to_degrees()})
    });
    json!({
        "name": scene.name,
        "triangles": stats.triangles,
        "mesh_triangles": stats.mesh_triangles,
        "vertices": stats.vertices,
        "meshes": stats.meshes,
        "instances": stats.instances,
        "materials": stats.materials,
        "textures": stats.textures,
        "texture_bytes": stats.texture_bytes,
        "lights": stats.lights,
        "emissive_triangles": stats.emissive_triangles,
        "sky": sky_as_json(&scene.sky),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "animation_seconds": stats.animation_seconds,
        "cameras": cameras.collect::<Vec<_>>(),
        "warnings": scene.warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skies() {
        assert_eq!("0".parse(), Ok(SkyChoice::Constant(Vec3::ZERO)));
        assert_eq!(
            "1, 2,3".parse(),
            Ok(SkyChoice::Constant(Vec3::new(1.0, 2.0, 3.0)))
        );
        assert_eq!("sky.hdr".parse(), Ok(SkyChoice::File("sky.hdr".into())));
        assert_eq!(
            "1,2".parse::<SkyChoice>().unwrap_err(),
            "give one radiance, or three"
        );
        for text in ["-1", "nan", "1,inf,1"] {
            let message = text.parse::<SkyChoice>().unwrap_err();
            assert_eq!(message, "a radiance is finite, and 0 or more");
        }
    }
}
