//! What is written is read back, and bad files say what is wrong with them.

use proptest::prelude::*;
use scumble_metrics::{
    Image, Sequence, linear_from_srgb, mse, read, write_exr, write_exr_half, write_pfm, write_png,
};
use std::path::Path;

fn gradient(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        [x as f32 * 0.37, y as f32 * -1.5e-3, 7.0e4]
    })
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect()
}

fn message(path: &Path) -> String {
    let text = read(path).unwrap_err().to_string();
    text.replace(&path.display().to_string(), "FILE")
}

#[test]
fn exr_keeps_every_bit_and_leaves_nothing_beside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for size in [[1, 1], [33, 17], [64, 64]] {
        let image = gradient(size[0], size[1]);
        write_exr(&path, &image).unwrap();
        assert_eq!(read(&path).unwrap(), image);
    }
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[test]
fn half_exr_is_near_finite_and_small() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, half] = ["whole.exr", "half.exr"].map(|name| folder.path().join(name));
    let image = gradient(64, 64);
    write_exr(&whole, &image).unwrap();
    write_exr_half(&half, &image).unwrap();
    let read = read(&half).unwrap();
    for (found, wanted) in read.data.iter().flatten().zip(image.data.iter().flatten()) {
        // Half of the last of 11 digits, and the largest value there is for what is larger.
        let wanted = wanted.min(65504.0);
        assert!(
            (found - wanted).abs() <= wanted.abs() / 2048.0,
            "{found} {wanted}"
        );
    }
    let size = |path: &Path| std::fs::metadata(path).unwrap().len();
    assert!(size(&half) < size(&whole));
}

#[test]
fn exr_layers_and_channel_orders() {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image as Exr, Layer, LayerAttributes,
        WritableImage, f16,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let channel = |name: &str, v: f32| {
        let samples = match name {
            "G" => FlatSamples::F32(vec![v; 2]),
            _ => FlatSamples::F16(vec![f16::from_f32(v); 2]),
        };
        AnyChannel::new(name, samples)
    };
    let layer = |name: &str, channels: Vec<_>| {
        let attributes = LayerAttributes::named(name);
        let channels = AnyChannels::sort(channels.into_iter().collect());
        Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, channels)
    };
    let depth = layer("depth", vec![channel("Z", 9.0)]);
    let view = |p: &str| {
        vec![
            channel(&format!("{p}B"), 3.0),
            channel(&format!("{p}R"), 1.0),
        ]
    };
    let with_green = |p: &str| {
        let mut channels = view(p);
        channels.extend([
            channel(&format!("{p}G"), 2.0),
            channel(&format!("{p}A"), 0.5),
        ]);
        channels
    };
    for (layers, found) in [
        (vec![depth.clone(), layer("beauty", with_green(""))], true),
        (
            vec![depth.clone(), layer("all", with_green("beauty."))],
            true,
        ),
        (vec![depth, layer("all", view(""))], false),
    ] {
        let image = Exr::from_layers(exr::prelude::ImageAttributes::with_size((2, 1)), layers);
        image.write().to_file(&path).unwrap();
        if found {
            assert_eq!(read(&path).unwrap().data, [[1.0, 2.0, 3.0]; 2]);
        } else {
            assert_eq!(
                message(&path),
                "`FILE`: no channels R, G, B; it has Z, B, R"
            );
        }
    }
}

#[test]
fn png_takes_display_values_and_gives_linear_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let image = Image::from_fn(3, 2, |x, y| [x as f32 / 2.0, y as f32 / 2.0, 1.5]);
    write_png(&path, &image).unwrap();
    let back = read(&path).unwrap();
    for (linear, display) in back.data.iter().flatten().zip(image.data.iter().flatten()) {
        let rounded = (display.clamp(0.0, 1.0) * 255.0).round() / 255.0;
        // One ulp of f32 near 1: the reader divides by 255 in its own way.
        assert!((linear - linear_from_srgb(rounded)).abs() < 2e-7);
    }
    // Back to display values, nothing is lost but the rounding to 8 bits, at most half a step.
    let clamped = Image::from_fn(3, 2, |x, y| image.get(x, y).unwrap().map(|v| v.min(1.0)));
    assert!(mse(&back.to_display(), &clamped).unwrap().sqrt() < 0.5 / 255.0);
}

#[test]
fn hdr_is_read_as_linear() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    let pixels = [image::Rgb([0.5, 2.0, 64.0]); 12];
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, 4, 3)
        .unwrap();
    std::fs::write(&path, bytes).unwrap();
    let image = read(&path).unwrap();
    assert_eq!(image.size(), [4, 3]);
    for (value, expected) in image.data[5].iter().zip([0.5, 2.0, 64.0]) {
        // RGBE shares one exponent: 8 bits below the largest channel.
        assert!((value - expected).abs() <= 64.0 / 256.0);
    }
}

#[test]
fn pfm_keeps_every_bit_with_rows_from_the_bottom() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    for size in [[1, 1], [5, 3]] {
        let image = gradient(size[0], size[1]);
        write_pfm(&path, &image).unwrap();
        assert_eq!(read(&path).unwrap(), image);
    }
    assert_eq!(names(folder.path()), ["a.pfm"]);
    let floats = |values: &[f32], word: fn(f32) -> [u8; 4]| -> Vec<u8> {
        values.iter().flat_map(|v| word(*v)).collect()
    };
    let rows = [1.0, 2.0, 3.0, 4.0];
    for (header, word) in [
        ("Pf\n2 2\n-1.0\n", f32::to_le_bytes as fn(f32) -> [u8; 4]),
        ("Pf 2\t2 2.5\n", f32::to_be_bytes),
    ] {
        std::fs::write(&path, [header.as_bytes(), &floats(&rows, word)].concat()).unwrap();
        let grey = read(&path).unwrap();
        assert_eq!(grey.data, [[3.0; 3], [4.0; 3], [1.0; 3], [2.0; 3]]);
    }
}

#[test]
fn bad_pfm_files_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.pfm");
    for (content, why) in [
        ("", "the header of a portable float map has no kind"),
        (
            "P6\n1 1\n",
            "a portable float map starts with PF or Pf, not `P6`",
        ),
        ("PF\n0 1\n-1\n", "`0` is no width"),
        ("PF\n1 x\n-1\n", "`x` is no height"),
        ("PF\n1 1\n0\n", "`0` is no scale"),
        ("PF\n1 1", "the header of a portable float map has no scale"),
        (
            "PF\n1 1\n-1\nfour",
            "1x1 pixels take 12 bytes after the header, and there are 4",
        ),
    ] {
        std::fs::write(&path, content).unwrap();
        assert_eq!(message(&path), format!("`FILE`: {why}"));
    }
}

#[test]
fn sequences_by_folder_and_by_pattern() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let find = |path: &Path| -> Vec<(u32, String)> {
        let frames = Sequence::find(path).unwrap().unwrap().frames;
        let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
        frames
            .iter()
            .map(|(number, path)| (*number, name(path)))
            .collect()
    };
    let why = |path: &Path| {
        let text = Sequence::find(path).unwrap_err().to_string();
        text.replace(&folder.path().display().to_string(), "DIR")
    };
    assert_eq!(
        why(folder.path()),
        "`DIR`: no numbered images here, such as frame.0001.exr"
    );
    for name in [
        "frame.0002.exr",
        "frame.0010.exr",
        "frame.0002.png",
        "frame.0002.gbuffer.motion.exr",
        "frame.txt",
        "plot.0001.svg",
    ] {
        std::fs::write(at(name), "").unwrap();
    }
    let exr = [
        (2, "frame.0002.exr".to_owned()),
        (10, "frame.0010.exr".to_owned()),
    ];
    assert_eq!(find(folder.path()), exr);
    assert_eq!(find(&at("frame.####.exr")), exr);
    assert_eq!(find(&at("frame.#.png")), [(2, "frame.0002.png".to_owned())]);
    let dumps = find(&at("frame.####.gbuffer.motion.exr"));
    assert_eq!(dumps, [(2, "frame.0002.gbuffer.motion.exr".to_owned())]);
    assert_eq!(Sequence::find(at("frame.0002.exr")).unwrap(), None);
    assert_eq!(
        why(&at("frame.#####.exr")),
        "`DIR/frame.#####.exr`: no numbered images here, such as frame.0001.exr"
    );
    std::fs::write(at("other.0001.png"), "").unwrap();
    assert_eq!(
        why(folder.path()),
        "`DIR` has several sequences: give one of frame.####.exr, other.####.png"
    );
    assert!(why(&at("none/a.#.exr")).starts_with("cannot read `DIR/none`: "));
}

#[test]
fn bad_files_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    assert!(message(&at("missing.exr")).starts_with("cannot read `FILE`: "));
    assert_eq!(
        message(&at("a.jpg")),
        "`FILE`: not an image file this program knows (known: .exr, .png, .hdr, .pfm)"
    );
    write_exr(at("a.exr"), &gradient(40, 40)).unwrap();
    let whole = std::fs::read(at("a.exr")).unwrap();
    for length in [0, 3, 100, whole.len() / 2] {
        std::fs::write(at("cut.exr"), &whole[..length]).unwrap();
        assert!(
            message(&at("cut.exr")).starts_with("`FILE`: "),
            "{length} bytes"
        );
    }
    std::fs::write(at("text.png"), "not a picture").unwrap();
    assert!(message(&at("text.png")).starts_with("`FILE`: "));
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "old").unwrap();
    let nan = Image::from_fn(2, 2, |_, _| [f32::NAN; 3]);
    assert!(write_png(&path, &nan).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    let nowhere = folder.path().join("none").join("a.exr");
    let text = write_exr(&nowhere, &gradient(2, 2))
        .unwrap_err()
        .to_string();
    assert!(
        text.starts_with(&format!("cannot write `{}`: ", nowhere.display())),
        "{text}"
    );
    assert_eq!(names(folder.path()), ["a.png"]);
}

proptest! {
    #[test]
    fn any_finite_image_survives_exr(
        width in 1_u32..20,
        values in proptest::collection::vec(proptest::num::f32::NORMAL | proptest::num::f32::ZERO, 60),
    ) {
        let height = 20 / width;
        let pixel = |x: u32, y: u32| {
            let i = 3 * (y * width + x) as usize;
            [values[i], values[i + 1], values[i + 2]]
        };
        let image = Image::from_fn(width, height, pixel);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &image).unwrap();
        prop_assert_eq!(read(&path).unwrap(), image);
    }
}
