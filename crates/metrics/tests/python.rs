//! Every metric beside an independent implementation: scikit-image, flip-evaluator, and NumPy where neither has it
//! (`python/metrics.py`), on random images of odd sizes.
//!
//! Needs a Python with `scikit-image` and `flip-evaluator`: that of SCUMBLE_PYTHON, else `python3`.

mod images;

use images::{map, noisy_pair};
use scumble_metrics::{Image, Metric, Space};
use std::path::Path;
use std::process::Command;

/// FLIP is computed in f32 there, with a Lab exponent that magnifies rounding near black; all else in f64 from
/// the same f32 values.
fn tolerance(metric: Metric) -> f64 {
    match metric {
        Metric::Flip | Metric::HdrFlip => 1e-4,
        _ => 1e-6,
    }
}

/// Odd, prime, one pixel wide, and as large as MS-SSIM needs.
const SIZES: [[u32; 2]; 6] = [[37, 29], [11, 11], [101, 63], [1, 7], [64, 1], [163, 171]];

fn python() -> String {
    std::env::var("SCUMBLE_PYTHON").unwrap_or_else(|_| "python3".into())
}

fn write(path: &Path, image: &Image) {
    let values = image.data.iter().flatten();
    let bytes: Vec<u8> = values.flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn other_implementations_agree() {
    let modules = Command::new(python())
        .args(["-c", "import skimage, flip_evaluator"])
        .output();
    if !modules.is_ok_and(|run| run.status.success()) {
        eprintln!(
            "SKIPPED: {} has no scikit-image and flip-evaluator: `pip install scikit-image flip-evaluator`, and name \
             that Python in SCUMBLE_PYTHON",
            python()
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/metrics.py");
    let mut compared = 0;
    for [width, height] in SIZES {
        let pair = noisy_pair(width, height);
        let files = ["image", "reference"].map(|name| folder.path().join(name));
        files
            .iter()
            .zip(&pair)
            .for_each(|(file, image)| write(file, image));
        let size = [width.to_string(), height.to_string()];
        let run = Command::new(python())
            .arg(script)
            .args(size)
            .args(files)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.success(), "{errors}");
        let bright = pair.clone().map(|image| map(&image, |v| v * v * 8.0));
        for line in String::from_utf8(run.stdout).unwrap().lines() {
            let (name, expected) = line.split_once(' ').unwrap();
            let metric: Metric = name.parse().unwrap();
            let expected: f64 = expected.parse().unwrap();
            let [image, reference] = match metric.space() {
                Space::Linear => &bright,
                Space::Display => &pair,
            };
            let found = metric.evaluate(image, reference).unwrap();
            let allowed = tolerance(metric) * expected.abs().max(1.0);
            assert!(
                (found - expected).abs() <= allowed,
                "{width}x{height}: {name} is {found}, and {expected} there"
            );
            compared += 1;
        }
    }
    // Nine metrics of every size, SSIM of four, MS-SSIM of one.
    assert_eq!(compared, 9 * 6 + 4 + 1);
}
