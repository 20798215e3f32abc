//! `scumble compare` and `scumble adapters`, as a shell sees them.

mod program;

use program::{NO_ADAPTER, scumble, text, without_driver};
use scumble_metrics::{Image, read, write_exr, write_pfm, write_png};
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
fn every_metric_has_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_fn(161, 161, |x, _| [x as f32 / 160.0; 3]);
    let path = folder.path().join("a.pfm").display().to_string();
    write_pfm(&path, &image).unwrap();
    let run = scumble(&["compare", &path, &path, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let mut names: Vec<_> = report["metrics"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    let mut expected = [
        "mse", "rmse", "relmse", "psnr", "ssim", "ms_ssim", "flip", "hdr_flip", "smape", "mape",
        "energy",
    ];
    names.sort();
    expected.sort_unstable();
    assert_eq!(names, expected);
    assert_eq!(report["relmse_trimmed"], 0.0);
    assert_eq!(
        report["distributions"]["flip"]["weighted_quartiles"],
        serde_json::json!([0.0, 0.0, 0.0])
    );
    // What is too small or too dark for a metric is not asked for it.
    let black = folder.path().join("b.pfm").display().to_string();
    write_pfm(&black, &Image::from_fn(3, 2, |_, _| [0.0; 3])).unwrap();
    let run = scumble(&["compare", &black, &black, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    for name in ["ssim", "ms_ssim", "energy"] {
        assert_eq!(report["metrics"].get(name), None, "{name}");
    }
    assert_eq!(report["metrics"]["hdr_flip"], 0.0);
}

#[test]
fn a_map_shows_where() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let path = folder.path().join("map.png").display().to_string();
    let map = |rest: &[&str]| {
        let run = scumble(&[&["compare", &a, &b, "--map", &path][..], rest].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        (read(&path).unwrap().to_display(), run.err)
    };
    // Equal errors have equal colours; the largest has the last one, as 8 bits.
    let (viridis, note) = map(&["--metric", "mse", "--map-colors", "viridis"]);
    assert!(
        note.contains("the map's last colour is mse 0.0100 and more"),
        "{note}"
    );
    let (few, _) = map(&["--metric", "mse", "--map-max", "1"]);
    let (flip, note) = map(&[]);
    assert_eq!(text(&note), "");
    let yellow = [253.0, 231.0, 37.0].map(|v| v / 255.0);
    for (found, expected) in viridis.data[40].iter().zip(yellow) {
        // One step of 8 bits, for the 99th percentile is below the largest by a rounding of f32.
        assert!(
            (found - expected).abs() < 1.5 / 255.0,
            "{:?}",
            viridis.data[40]
        );
    }
    assert!(few.data[40].iter().all(|v| *v < 0.1), "{:?}", few.data[40]);
    assert!(flip.data[0] != flip.data[31]);
}

#[test]
fn a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let [images, references] = ["images", "references"].map(|name| folder.path().join(name));
    for path in [&images, &references] {
        std::fs::create_dir(path).unwrap();
    }
    // A still reference; errors of 0.1, 0.2 and 0.3.
    for t in 1..=3_u32 {
        let reference = Image::from_fn(16, 16, |x, _| [x as f32 / 32.0; 3]);
        let image = Image::from_fn(16, 16, |x, _| [x as f32 / 32.0 + 0.1 * t as f32; 3]);
        write_exr(images.join(format!("frame.{t:04}.exr")), &image).unwrap();
        write_png(images.join(format!("frame.{t:04}.png")), &image).unwrap();
        write_exr(references.join(format!("frame.{t:04}.exr")), &reference).unwrap();
    }
    let [a, b] = [&images, &references].map(|path| path.display().to_string());
    let maps = folder.path().join("maps");
    let run = scumble(&[
        "compare",
        &a,
        &b,
        "--metric",
        "rmse",
        "--map",
        &maps.display().to_string(),
    ]);
    // Values are f32 below 1, rounded by up to 6e-8, below the last digit.
    let lines: Vec<_> = run.out.lines().collect();
    assert_eq!(
        lines[..2],
        [
            "3 frames: mean, and worst",
            "rmse    0.2000000 0.3000000 (frame 3)"
        ]
    );
    assert!(
        lines[2].starts_with("flicker 0.") && lines[2].contains("reference 0.0000000"),
        "{}",
        lines[2]
    );
    for t in 1..=3 {
        assert!(maps.join(format!("map.{t:04}.png")).exists());
    }

    let pattern = images.join("frame.####.exr").display().to_string();
    let one = references.join("frame.0001.exr").display().to_string();
    let run = scumble(&["compare", &pattern, &one, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["frames"][1]["frame"], 2);
    assert!((report["frames"][1]["metrics"]["rmse"].as_f64().unwrap() - 0.2).abs() < 1e-7);
    assert_eq!(report["worst"]["psnr"]["frame"], 3);
    let flicker = &report["flicker"];
    assert_eq!(flicker["reference"]["difference"], 0.0);
    // The reference is still: all change of the image is beyond it.
    assert_eq!(
        flicker["image"]["difference"],
        flicker["beyond_reference"]["difference"]
    );

    let code =
        |limit: &str| scumble(&["compare", &a, &b, "--metric", "rmse", "--fail-above", limit]).code;
    assert_eq!((code("0.31"), code("0.29")), (0, 1));

    std::fs::remove_file(references.join("frame.0002.exr")).unwrap();
    let run = scumble(&["compare", &a, &b]);
    let expected =
        format!("error: there is no frame 2 in `{b}`; there are 3 images and 2 references");
    assert_eq!((run.code, text(&run.err)), (2, expected));
    let run = scumble(&["compare", &one, &a]);
    let expected = format!("error: `{one}` is one image, and the reference is several frames");
    assert_eq!((run.code, text(&run.err)), (2, expected));
    write_exr(
        images.join("frame.0002.exr"),
        &Image::from_fn(2, 2, |_, _| [0.0; 3]),
    )
    .unwrap();
    let run = scumble(&["compare", &a, &one]);
    let expected = "error: frame 2: the sizes differ: the image is 2x2, the reference 16x16";
    assert_eq!((run.code, text(&run.err)), (2, expected.into()));
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
    let note = format!(
        "note: `{png}` holds what is displayed (tone mapped, 8 bits), `{exr}` the light itself: unless \
         nothing was tone mapped, compare two .exr or two .png"
    );
    assert_eq!(text(&run.err), note);
    let run = scumble(&["compare", &exr, &png, "--metric", "rmse"]);
    assert_eq!((run.code, text(&run.err)), (0, note));
    let run = scumble(&["compare", &png, &png, "--metric", "rmse"]);
    assert_eq!((run.code, text(&run.err)), (0, String::new()));
}

#[test]
fn thresholds_decide_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = pair(folder.path());
    let code = |rest: &[&str]| scumble(&[&["compare", &a, &b][..], rest].concat()).code;
    assert_eq!(code(&["--metric", "mse", "--fail-above", "0.0101"]), 0);
    assert_eq!(code(&["--metric", "mse", "--fail-above", "0.0099"]), 1);
    // The energy is 1.2: 0.2 from the best.
    assert_eq!(code(&["--metric", "energy", "--fail-above", "0.21"]), 0);
    assert_eq!(code(&["--metric", "energy", "--fail-above", "0.19"]), 1);
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
    let gone = std::fs::read("missing.exr").unwrap_err();
    let gone = format!("cannot read `missing.exr`: {gone}");
    let cases: [(&[&str], &str); 10] = [
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
            &[&a, &b, "--map", "map.jpg"],
            "`map.jpg`: the map of an image is a .png",
        ),
        (
            &[&a, &b, "--map", "map.png", "--metric", "psnr"],
            "psnr is of a whole image and has no map; \
             there are maps of mse, rmse, relmse, ssim, flip, hdr_flip, smape, mape",
        ),
        (
            &[&a, "b.jpg"],
            "`b.jpg`: not an image file this program knows (known: .exr, .png, .hdr, .pfm)",
        ),
        (&["missing.exr", &b], &gone),
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
