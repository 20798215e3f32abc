//! `scumble denoise` on what Mitsuba 3 renders with a few samples, against what it renders with many.
//!
//! `tests/mitsuba/render.py` renders; `SCUMBLE_PYTHON` names a Python that has `mitsuba`, without it `python3` is asked. Where there is
//! none, the test says that it is skipped. `SCUMBLE_FULL=1` renders larger images with better references; `SCUMBLE_SEEN=FOLDER` keeps
//! the images.

mod program;

use program::scumble;
use scumble_metrics::{Image, Metric, TRIMMED_FRACTION, read, relmse_trimmed};
use std::path::{Path, PathBuf};
use std::process::Command;

const FRAMES: usize = 8;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

fn has_mitsuba(python: &str) -> bool {
    let asked = Command::new(python).args(["-c", "import mitsuba"]).output();
    asked.is_ok_and(|output| output.status.success())
}

fn ssim(image: &Image, reference: &Image) -> f64 {
    let (image, reference) = (image.to_display(), reference.to_display());
    Metric::Ssim.evaluate(&image, &reference).unwrap()
}

#[test]
fn a_sequence_of_mitsuba_comes_near_its_own_converged_frames() {
    let python = std::env::var("SCUMBLE_PYTHON").unwrap_or("python3".into());
    if !has_mitsuba(&python) {
        eprintln!(
            "SKIPPED: `{python}` has no mitsuba; pip install mitsuba, and name that Python in SCUMBLE_PYTHON"
        );
        return;
    }
    let full = std::env::var_os("SCUMBLE_FULL").is_some_and(|v| v == "1");
    let (size, samples) = if full {
        ("192x144", "1024")
    } else {
        ("48x48", "256")
    };
    let place = tempfile::tempdir().unwrap();
    let kept = std::env::var_os("SCUMBLE_SEEN").map(PathBuf::from);
    let folder = kept.as_deref().unwrap_or(place.path());
    let rendered = Command::new(&python)
        .arg(repository("tests/mitsuba/render.py"))
        .arg(folder)
        .args(["--size", size, "--reference-spp", samples])
        .args(["--frames", &FRAMES.to_string()])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&rendered.stderr);
    assert!(rendered.status.success(), "{said}");

    let at = |name: &str| folder.join(name).display().to_string();
    let graph = repository("graphs/denoise-svgf.ron").display().to_string();
    let run = scumble(&[
        "denoise",
        &graph,
        "--input",
        &at("noisy"),
        "--cameras",
        &at("noisy/cameras.json"),
        "--output",
        &at("denoised"),
    ]);
    assert_eq!(run.code, 0, "{}", run.err);

    let (mut before, mut after) = (0.0, 0.0);
    for number in 1..=FRAMES {
        let image = |name: &str| read(folder.join(format!("{name}.{number:04}.exr"))).unwrap();
        let reference = image("reference/frame");
        let (noisy, denoised) = (image("noisy/box"), image("denoised/frame"));
        let error = |image: &Image| relmse_trimmed(image, &reference, TRIMMED_FRACTION).unwrap();
        let (was, is) = (error(&noisy), error(&denoised));
        let (like, liker) = (ssim(&noisy, &reference), ssim(&denoised, &reference));
        println!("frame {number}: relMSE {was:.5} -> {is:.5}, SSIM {like:.4} -> {liker:.4}");
        assert!(liker > like, "frame {number}: SSIM {like} became {liker}");
        before += was;
        after += is;
    }
    println!("relMSE falls {:.2} times", before / after);
    // What the filter is for; the first frames, which have no history, are among them.
    assert!(before > 5.0 * after, "relMSE {before} became {after}");
}
