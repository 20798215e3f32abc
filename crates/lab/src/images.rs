//! Images of an experiment as files: what the report shows, and what figures are made of.
//!
//! Below `images/SCENE/CAMERA/` of the folder of results lie, for each variant's run with the first seed and each
//! reference, `WHAT.KEY.exr` (radiance, half floats) and `.png` (exposed and tone mapped), of a run also the error map of
//! each metric that has one and its graph. KEY is the beginning of the name of all that they depend on.

use crate::error::LabError;
use crate::measure::Exposed;
use crate::record::Record;
use scumble_metrics::{ColorMap, Image, Metric, write_atomic, write_exr_half, write_png};
use std::path::{Path, PathBuf};

/// As much of a key as tells images of one name apart.
const KEY_DIGITS: usize = 10;

/// The error of a pixel that has the last colour of a map: what the metric is at most, or an error of 50 %.
///
/// ```
/// use scumble_lab::full_error;
/// use scumble_metrics::Metric;
/// assert_eq!(full_error(Metric::Flip), 1.0);
/// assert_eq!(full_error(Metric::RelMse), 0.5 * 0.5);
/// ```
pub fn full_error(metric: Metric) -> f64 {
    match metric {
        Metric::Mse | Metric::RelMse => 0.25,
        Metric::Rmse | Metric::Mape | Metric::Smape => 0.5,
        _ => 1.0,
    }
}

/// The images of the experiment whose results are in a folder.
#[derive(Clone, Debug)]
pub struct Images {
    folder: PathBuf,
}

impl Images {
    /// Of the results in this folder.
    pub fn new(results: &Path) -> Images {
        Images {
            folder: results.join("images"),
        }
    }

    /// The file of a reference, with this ending.
    pub fn reference(&self, scene: &str, camera: &str, key: &str, ending: &str) -> PathBuf {
        self.file([scene, camera], "reference", key, ending)
    }

    /// The file of a frame of a run, with this ending: `exr`, `png`, or `relmse.png` and so on.
    pub fn run(&self, record: &Record, frame: u32, ending: &str) -> PathBuf {
        let what = format!("{}.{frame:04}", record.variant);
        self.file([&record.scene, &record.camera], &what, &record.key, ending)
    }

    /// The drawing of the graph of a run.
    pub fn graph(&self, record: &Record) -> PathBuf {
        let place = [record.scene.as_str(), &record.camera];
        self.file(place, &record.variant, &record.key, "svg")
    }

    fn file(&self, place: [&str; 2], what: &str, key: &str, ending: &str) -> PathBuf {
        let [scene, camera] = place.map(plain);
        let key = key.get(..KEY_DIGITS).unwrap_or(key);
        let name = format!("{}.{key}.{ending}", plain(what));
        self.folder.join(scene).join(camera).join(name)
    }

    /// Writes a reference.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_reference(
        &self,
        scene: &str,
        camera: &str,
        key: &str,
        reference: &Exposed,
        radiance: &Image,
    ) -> Result<(), LabError> {
        let file = |ending| self.reference(scene, camera, key, ending);
        prepare(&file("exr"))?;
        write_exr_half(file("exr"), radiance)?;
        Ok(write_png(file("png"), &reference.display)?)
    }

    /// Writes a frame of a run, and where it differs from its reference.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_run(
        &self,
        record: &Record,
        frame: u32,
        [image, reference]: [&Exposed; 2],
        radiance: &Image,
    ) -> Result<(), LabError> {
        let file = |ending: &str| self.run(record, frame, ending);
        prepare(&file("exr"))?;
        write_exr_half(file("exr"), radiance)?;
        write_png(file("png"), &image.display)?;
        for metric in mapped(record, frame) {
            let map = image.map(reference, metric)?;
            let picture = map.to_image(ColorMap::Magma, full_error(metric));
            write_png(file(&format!("{metric}.png")), &picture)?;
        }
        Ok(())
    }

    /// Writes the drawing of a run's graph.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_graph(&self, record: &Record, svg: &str) -> Result<(), LabError> {
        let path = self.graph(record);
        prepare(&path)?;
        Ok(write_atomic(&path, svg.as_bytes())?)
    }

    /// Whether all files of a run are there.
    pub fn are_there(&self, record: &Record) -> bool {
        self.files(record).iter().all(|path| path.is_file())
    }

    /// Takes what there is of a run from elsewhere.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn copy(&self, from: &Images, record: &Record) -> Result<(), LabError> {
        for (source, target) in from.files(record).iter().zip(self.files(record)) {
            if let Ok(bytes) = std::fs::read(source) {
                prepare(&target)?;
                write_atomic(&target, &bytes)?;
            }
        }
        Ok(())
    }

    fn files(&self, record: &Record) -> Vec<PathBuf> {
        let mut files = vec![self.graph(record)];
        for frame in &record.frames {
            for ending in ["exr", "png"] {
                files.push(self.run(record, frame.frame, ending));
                let (scene, camera) = (&record.scene, &record.camera);
                files.push(self.reference(scene, camera, &frame.reference, ending));
            }
            for metric in mapped(record, frame.frame) {
                files.push(self.run(record, frame.frame, &format!("{metric}.png")));
            }
        }
        files
    }
}

/// The metrics of a frame that have a map.
fn mapped(record: &Record, frame: u32) -> impl Iterator<Item = Metric> {
    let frames = record.frames.iter().filter(move |f| f.frame == frame);
    let names = frames.flat_map(|frame| frame.metrics.keys());
    let metrics = names.filter_map(|name| name.parse::<Metric>().ok());
    metrics.filter(|metric| metric.has_map())
}

/// Characters of a name in a path: file systems take 255 bytes with all that follows.
const LENGTH: usize = 150;

/// A name as part of a path, on any system.
fn plain(name: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || "-_.=".contains(c);
    let kept = name.chars().map(|c| if keep(c) { c } else { '-' });
    let name: String = kept.take(LENGTH).collect();
    // No folder above.
    name.replace("..", "--")
}

fn prepare(path: &Path) -> Result<(), LabError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(|source| LabError::Folder {
        path: folder.to_owned(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_no_path() {
        assert_eq!(plain("../a b/*c"), "---a-b--c");
        let images = Images::new(Path::new("r"));
        let file = images.reference("kitchen.glb", "still 0", "0123456789abcdef", "png");
        let wanted = "r/images/kitchen.glb/still-0/reference.0123456789.png";
        assert_eq!(file, Path::new(wanted));
    }
}
