//! `scumble compare` and `scumble adapters`, as a shell sees them.

mod program;

use program::{NO_ADAPTER, scumble, text, without_driver};
use scumble_metrics::{Image, write_exr, write_png};
use std::path::Path;

fn pair(folder: &Path) -> [String; 2] {
    let image = Image::from_fn(32, 32, |x, _| [x as f32 / 31.0 + 0.1; 3]);
    let reference = Image::from_fn(32, 32, |x, _| [x as f32 / 31.0; 3]);
    [("a.exr", image), ("b.exr", reference)].map(|(name, image)| {
        write_exr(folder.join(name), &image).unwrap();
        folder.join(name).display().to_string()
    })
}

#[test]
fn one_metric() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let run = scumble(&["compare", &a, &b, "--metric", "rmse"]);
    // The values are f32: 0.1 is rounded by up to 6e-8 where they reach 1, below the last digit.
    assert_eq!((run.code, text(&run.out)), (0, "rmse    0.1000000".into()));
}

#[test]
fn all_metrics_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let run = scumble(&["compare", &a, &b, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["size"], serde_json::json!([32, 32]));
    // The values are f32: 0.1 is rounded by up to 6e-8 where they reach 1.
    assert!((report["metrics"]["mse"].as_f64().unwrap() - 0.01).abs() < 2e-8);
    assert!((report["blocks"]["mean"].as_f64().unwrap() - 0.2).abs() < 2e-7);
    let ssim = report["metrics"]["ssim"].as_f64().unwrap();
    assert!(ssim > 0.5 && ssim < 1.0, "{ssim}");
    let same = scumble(&["compare", &a, &a, "--json"]);
    let same: serde_json::Value = serde_json::from_str(&same.out).unwrap();
    assert_eq!(same["metrics"]["psnr"], serde_json::Value::Null);
    assert_eq!(same["metrics"]["relmse"], 0.0);
}

#[test]
fn a_png_is_decoded_to_linear() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_fn(16, 16, |_, _| [0.2, 0.5, 0.8]);
    let [png, exr] = ["a.png", "a.exr"].map(|n| folder.path().join(n).display().to_string());
    write_exr(&exr, &image).unwrap();
    write_png(&png, &image.to_display()).unwrap();
    // Half a step of 8 bits, where the curve is steepest: 0.5 / 255 * 2.4 / 1.055 < 0.0045.
    let run = scumble(&[
        "compare",
        &png,
        &exr,
        "--metric",
        "rmse",
        "--fail-above",
        "0.0045",
    ]);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
}

#[test]
fn thresholds_decide_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let code = |rest: &[&str]| scumble(&[&["compare", &a, &b][..], rest].concat()).code;
    assert_eq!(code(&["--metric", "mse", "--fail-above", "0.0101"]), 0);
    assert_eq!(code(&["--metric", "mse", "--fail-above", "0.0099"]), 1);
    assert_eq!(code(&["--metric", "psnr", "--fail-below", "10"]), 0);
    assert_eq!(code(&["--metric", "psnr", "--fail-below", "40"]), 1);
}

#[test]
fn bad_comparisons_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let small = folder.path().join("c.exr").display().to_string();
    write_exr(&small, &Image::from_fn(3, 2, |_, _| [1.0; 3])).unwrap();
    let nan = folder.path().join("nan.exr").display().to_string();
    write_exr(&nan, &Image::from_fn(32, 32, |_, _| [f32::NAN; 3])).unwrap();
    let cases: [(&[&str], &str); 8] = [
        (
            &[&a, &small],
            "the sizes differ: the image is 32x32, the reference 3x2",
        ),
        (
            &[&nan, &b, "--metric", "psnr"],
            "the image has NaN in channel 0 at x 0, y 0, and 3072 such values in all",
        ),
        (
            &[&small, &small, "--metric", "ssim"],
            "SSIM needs an image of at least 11x11; this one is 3x2",
        ),
        (
            &[&a, &b, "--fail-above", "1"],
            "--fail-above takes one --metric to judge by, not 0",
        ),
        (
            &[&a, &b, "--metric", "ssim", "--fail-above", "1"],
            "--fail-above is for errors; of ssim a larger value is better: use --fail-below",
        ),
        (
            &[&a, &b, "--metric", "mse", "--fail-below", "1"],
            "--fail-below is for similarities; of mse a smaller value is better: use --fail-above",
        ),
        (
            &[&a, "b.jpg"],
            "`b.jpg`: not an image file this program knows (known: .exr, .png, .hdr, .pfm)",
        ),
        (
            &["missing.exr", &b],
            "cannot read `missing.exr`: No such file or directory (os error 2)",
        ),
    ];
    for (rest, message) in cases {
        let run = scumble(&[&["compare"], rest].concat());
        assert_eq!(
            (run.code, text(&run.err)),
            (2, format!("error: {message}")),
            "{rest:?}"
        );
    }
    let run = scumble(&["compare", &a, &b, "--metric", "lpips"]);
    assert_eq!(run.code, 2);
    let expected = "error: invalid value 'lpips' for '--metric <METRIC>': \
                    there is no metric `lpips`; there are mse, rmse, relmse, psnr, ssim, ms_ssim, \
                    flip, hdr_flip, smape, mape, energy";
    assert_eq!(run.err.lines().next(), Some(expected));
}

#[test]
fn adapters_are_listed() {
    let run = scumble(&["adapters", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert!(!report[0]["name"].as_str().unwrap().is_empty());
    assert!(report[0]["limits"]["image_side"].as_u64().unwrap() >= 2048);
}

#[cfg(target_os = "linux")]
#[test]
fn no_adapter() {
    let run = without_driver(&["adapters"]);
    assert_eq!((run.code, text(&run.err)), (2, NO_ADAPTER.into()));
}
