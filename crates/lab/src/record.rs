//! What is kept of one run.

use crate::error::LabError;
use scumble_metrics::write_atomic;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Frames at the beginning of a run whose times are not counted: drivers compile in them. The last frame always counts.
pub(crate) const WARM_UP: usize = 2;

/// One run: a scene, a camera path, a variant and a seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The name of all that it depends on.
    pub key: String,
    /// The scene.
    pub scene: String,
    /// The camera path.
    pub camera: String,
    /// The variant.
    pub variant: String,
    /// The seed.
    pub seed: u32,
    /// What it was rendered on.
    pub adapter: String,
    /// And with which driver.
    pub driver: String,
    /// Radiance was multiplied by this before it was measured: 0.18 / geometric mean of the references.
    pub exposure: f64,
    /// The counts that equal rays or equal time asked of its tracers, as `pass.parameter`; empty where the plan's
    /// were right.
    pub counts: BTreeMap<String, i64>,
    /// The rates of sample masks that equal time asked for, as `pass.parameter`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rates: BTreeMap<String, f64>,
    /// Rays of each frame, as the tracers counted them.
    pub rays: Vec<f64>,
    /// Seconds from recording each frame to its end.
    pub seconds: Vec<f64>,
    /// GPU milliseconds of each pass, by frame; empty without timestamps.
    pub passes: BTreeMap<String, Vec<f64>>,
    /// Bytes of GPU memory for the frame, without the scene.
    pub memory: u64,
    /// The frames that have a reference.
    pub frames: Vec<FrameRecord>,
    /// Change along the motion over all frames, if it was asked for; see [`crate::Flickering`].
    pub flicker: Option<f64>,
}

/// One frame that has a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Its number, from 0.
    pub frame: u32,
    /// The name of all that its reference depends on.
    #[serde(default)]
    pub reference: String,
    /// Every metric by name. The PSNR of equal images is infinite, and `null` in JSON.
    #[serde(deserialize_with = "with_infinity")]
    pub metrics: BTreeMap<String, f64>,
}

impl Record {
    /// The value of a metric: the mean over the frames that have it, or the flicker of all.
    pub fn value(&self, metric: &str) -> Option<f64> {
        if metric == "flicker" {
            return self.flicker;
        }
        let values: Option<Vec<f64>> = self
            .frames
            .iter()
            .map(|frame| frame.metrics.get(metric).copied())
            .collect();
        let values = values.filter(|values| !values.is_empty())?;
        Some(values.iter().sum::<f64>() / values.len() as f64)
    }

    /// Writes it whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), LabError> {
        write_json(path, self)
    }

    /// Reads it; `None` where there is no such file, or what is there is no record.
    pub fn read(path: &Path) -> Option<Record> {
        read_json(path)
    }
}

fn with_infinity<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let values = BTreeMap::<String, Option<f64>>::deserialize(from)?.into_iter();
    Ok(values
        .map(|(name, value)| (name, value.unwrap_or(f64::INFINITY)))
        .collect())
}

/// Reads a value from JSON; `None` where there is no such file, or what is there is not such a value.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let text = std::fs::read_to_string(path).ok()?;
    serde_json::from_str(&text).ok()
}

/// Writes a value as JSON, whole or not at all.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), LabError> {
    let mut text = serde_json::to_string_pretty(value).map_err(|e| LabError::Json {
        path: path.to_owned(),
        message: e.to_string(),
    })?;
    text.push('\n');
    Ok(write_atomic(path, text.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn record() -> Record {
        let frame = |frame, relmse| FrameRecord {
            frame,
            reference: "r".into(),
            metrics: [("relmse".to_owned(), relmse)].into(),
        };
        Record {
            key: "k".into(),
            scene: "s".into(),
            camera: "c".into(),
            variant: "v".into(),
            seed: 1,
            adapter: "a".into(),
            driver: "d".into(),
            exposure: 0.1 + 0.2,
            counts: [("a.samples".to_owned(), 3)].into(),
            rates: BTreeMap::new(),
            rays: vec![1.0],
            seconds: vec![0.5],
            passes: BTreeMap::new(),
            memory: 7,
            frames: vec![frame(3, 0.1), frame(7, 0.3)],
            flicker: Some(0.01),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("k.json");
        assert_eq!(Record::read(&path), None);
        record().write(&path).unwrap();
        assert_eq!(Record::read(&path), Some(record()));
        std::fs::write(&path, "{\"key\": ").unwrap();
        assert_eq!(Record::read(&path), None, "half a file is none");
        let mut equal = record();
        let psnr = ("psnr".to_owned(), f64::INFINITY);
        equal.frames[0].metrics.extend([psnr]);
        equal.write(&path).unwrap();
        assert_eq!(Record::read(&path), Some(equal));
    }

    /// Of any magnitude, bit for bit.
    #[test]
    fn numbers_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("numbers.json");
        let number = |i: i32| f64::from(i).sqrt() * 10_f64.powi(i % 60 - 30);
        let numbers: Vec<f64> = (0..2000).map(number).collect();
        write_json(&path, &numbers).unwrap();
        assert_eq!(read_json::<Vec<f64>>(&path), Some(numbers));
    }

    #[test]
    fn a_value_is_the_mean_over_frames() {
        assert_eq!(record().value("relmse"), Some(0.2));
        assert_eq!(record().value("flicker"), Some(0.01));
        assert_eq!(record().value("ssim"), None);
    }
}
