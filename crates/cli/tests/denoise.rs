//! `scumble denoise`, as a shell sees it: image sequences of other programs, whole and broken.

mod program;
mod wall;

use program::{DIRECT, Place, Run, names, scumble, text};
use scumble_metrics::{Channel, Image, read, relmse, write_exr, write_pfm};
use std::path::Path;

const FRAMES: u32 = 5;

fn graph(name: &str) -> String {
    format!("{}/../../graphs/{name}.ron", env!("CARGO_MANIFEST_DIR"))
}

/// Runs the temporal graph on a folder, into a folder beside it.
fn denoise(folder: &Path, more: &[&str]) -> Run {
    denoise_with("denoise-svgf", folder, more)
}

fn denoise_with(name: &str, folder: &Path, more: &[&str]) -> Run {
    let (input, output) = (folder.display().to_string(), out(folder));
    let graph = graph(name);
    let args = ["denoise", &graph, "--input", &input, "--output", &output];
    scumble(&[&args[..], more].concat())
}

fn out(folder: &Path) -> String {
    format!("{}-out", folder.display())
}

fn result(folder: &Path, number: u32) -> Image {
    read(Path::new(&out(folder)).join(format!("frame.{number:04}.exr"))).unwrap()
}

fn cameras(folder: &Path) -> String {
    folder.join("cameras.json").display().to_string()
}

fn error(image: &Image, number: u32) -> f64 {
    relmse(image, &wall::truth(number)).unwrap()
}

/// A folder inside a temporary one, so that what is written beside it goes with it.
fn folder() -> (tempfile::TempDir, std::path::PathBuf) {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("in");
    std::fs::create_dir(&folder).unwrap();
    (place, folder)
}

fn succeeds(run: &Run) {
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
}

fn message(run: Run) -> String {
    assert_eq!(run.code, 2, "{}{}", run.out, run.err);
    let said = text(&run.err);
    let error = said.strip_prefix("error: ").unwrap_or(&said);
    assert!(!error.contains("error: "), "one message: {error}");
    error.to_owned()
}

/// Every convention leads to the same picture, and the picture is better than what it was made of.
#[test]
fn conventions_are_turned_into_ours() {
    let (_place, mitsuba) = folder();
    wall::mitsuba(&mitsuba, FRAMES);
    let run = denoise(&mitsuba, &["--cameras", &cameras(&mitsuba), "--json"]);
    succeeds(&run);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["size"], serde_json::json!(wall::SIZE));
    let fed = |i: usize| {
        let input = &report["inputs"][i];
        [&input["input"], &input["from"], &input["convention"]]
            .map(|v| v.as_str().unwrap_or("").to_owned())
    };
    assert_eq!(fed(0), ["radiance", "wall.####.exr", ""]);
    assert_eq!(
        fed(4),
        [
            "view_z",
            "wall.####.exr:dd",
            "distance, turned to depth along the view axis"
        ]
    );
    assert_eq!(fed(5), ["motion", "cameras", ""]);
    assert_eq!(names(Path::new(&out(&mitsuba))).len(), 2 * FRAMES as usize);

    let noisy = wall::frame(FRAMES).iter().map(|p| p.noisy).collect();
    let noisy = Image::new(wall::SIZE[0], wall::SIZE[1], noisy).unwrap();
    let (before, after) = (
        error(&noisy, FRAMES),
        error(&result(&mitsuba, FRAMES), FRAMES),
    );
    // Exponential noise has a deviation of 1; five frames and a filter of many texels leave a tenth of its square at most.
    assert!(after * 10.0 < before, "{before} became {after}");

    let (_place, blender) = folder();
    wall::blender(&blender, FRAMES);
    succeeds(&denoise(&blender, &[]));
    let (_place, loose) = folder();
    wall::loose(&loose, FRAMES);
    let map = "radiance=light_###.pfm,albedo=kd_###.pfm,normal=facing_###.pfm,view_z=far_###.pfm,motion=flow_###.pfm";
    let flags = [
        "--normals",
        "camera",
        "--motion-y",
        "up",
        "--cameras",
        &cameras(&mitsuba),
    ];
    succeeds(&denoise(&loose, &[&["--map", map][..], &flags].concat()));
    for (folder, what, most) in [
        // Without cameras the filter does not know how far surfaces were a frame before, and takes that for how far they are.
        (&blender, "Blender's", 1e-3),
        // Rounding: vectors that were divided and multiplied, normals that were turned twice.
        (&loose, "loose", 1e-5),
    ] {
        for number in 1..=FRAMES {
            let difference = relmse(&result(folder, number), &result(&mitsuba, number)).unwrap();
            assert!(difference < most, "{what} frame {number}: {difference}");
        }
    }
}

/// What is broken is left out, and the frames after it are as good as without it.
#[test]
fn a_broken_frame_does_not_spoil_those_after_it() {
    let (_place, whole) = folder();
    wall::mitsuba(&whole, 6);
    succeeds(&denoise(
        &whole,
        &["--cameras", &cameras(&whole), "--quiet"],
    ));
    for (what, light, note) in [
        (
            "not a number",
            f32::NAN,
            "note: frame 4: 1200 of 1200 pixels have no finite light: they go on with their history",
        ),
        (
            "black",
            0.0,
            "note: frame 4: it is black all over: it goes on with its history (--keep-black takes it as it is)",
        ),
        (
            "infinite",
            f32::INFINITY,
            "note: frame 4: 1200 of 1200 pixels have no finite light: they go on with their history",
        ),
    ] {
        let (_place, broken) = folder();
        wall::mitsuba(&broken, 6);
        let file = broken.join("wall.0004.exr");
        let mut channels = scumble_metrics::read_channels(&file).unwrap();
        for channel in &mut channels.list {
            if ["R", "G", "B"].contains(&channel.name.as_str()) {
                channel.values.fill(light);
            }
        }
        wall::write(&file, channels.list);
        let run = denoise(&broken, &["--cameras", &cameras(&broken)]);
        succeeds(&run);
        assert_eq!(text(&run.err), note, "{what}");
        for number in 4..=6 {
            let (with, without) = (
                error(&result(&broken, number), number),
                error(&result(&whole, number), number),
            );
            // One sample of four to six is missing: its variance is a third more at most, and the filter wider.
            assert!(
                with < 1.5 * without,
                "{what}: frame {number}: {with} instead of {without}"
            );
        }
        // A history that began anew would have one or two samples in the frames after.
        let fresh = error(&result(&whole, 1), 1);
        assert!(error(&result(&broken, 5), 5) < fresh, "{what}");
    }
}

/// Guides that are broken begin a history anew; nothing that is not finite is ever written.
#[test]
fn broken_guides_make_holes() {
    let (_place, broken) = folder();
    wall::mitsuba(&broken, 4);
    let file = broken.join("wall.0002.exr");
    let mut channels = scumble_metrics::read_channels(&file).unwrap();
    for channel in &mut channels.list {
        if channel.name == "nn.Y" {
            channel.values[..40].fill(f32::NAN);
        }
    }
    wall::write(&file, channels.list);
    let run = denoise(&broken, &["--cameras", &cameras(&broken)]);
    succeeds(&run);
    let note = "note: frame 2: 40 of 1200 pixels have no finite guides: their history begins anew";
    assert_eq!(text(&run.err), note);
    for number in 1..=4 {
        let image = result(&broken, number);
        assert!(
            image.data.iter().flatten().all(|v| v.is_finite()),
            "frame {number}"
        );
    }
}

/// Vectors tell of one step; over a gap they would lead astray.
#[test]
fn a_gap_in_a_sequence_begins_histories_anew() {
    let (_place, whole) = folder();
    wall::blender(&whole, 4);
    std::fs::remove_file(whole.join("0003.exr")).unwrap();
    let run = denoise(&whole, &[]);
    succeeds(&run);
    assert_eq!(
        text(&run.err),
        "note: frame 4: motion vectors do not lead over the gap after frame 2: all histories begin anew"
    );
    let (_place, alone) = folder();
    wall::blender(&alone, 4);
    for number in 1..=3 {
        std::fs::remove_file(alone.join(format!("{number:04}.exr"))).unwrap();
    }
    succeeds(&denoise(&alone, &[]));
    // Nothing is left of what was before the gap.
    assert_eq!(result(&whole, 4), result(&alone, 4));
}

#[test]
fn single_images_need_no_motion() {
    let (_place, folder) = folder();
    wall::blender(&folder, 1);
    std::fs::rename(folder.join("0001.exr"), folder.join("still.exr")).unwrap();
    succeeds(&denoise_with("denoise-spatial", &folder, &[]));
    let noisy = read_noisy(1);
    // One image has no past: the neighbourhood alone takes four fifths of the error.
    let (before, after) = (error(&noisy, 1), error(&result(&folder, 1), 1));
    assert!(after * 5.0 < before, "{before} became {after}");
}

fn read_noisy(number: u32) -> Image {
    let data = wall::frame(number).iter().map(|p| p.noisy).collect();
    Image::new(wall::SIZE[0], wall::SIZE[1], data).unwrap()
}

/// Light of one pixel in 4 x 4, guides of all of them.
#[test]
fn sparse_light_is_upsampled_by_guides() {
    let (_place, folder) = folder();
    wall::loose(&folder, 1);
    let pixels = wall::frame(1);
    let [width, height] = wall::SIZE.map(|side| side.div_ceil(4));
    let middle = |cell: u32, side: u32| (4 * cell + 2).min(side - 1);
    let sparse = Image::from_fn(width, height, |x, y| {
        let (x, y) = (middle(x, wall::SIZE[0]), middle(y, wall::SIZE[1]));
        pixels[(y * wall::SIZE[0] + x) as usize].truth
    });
    write_pfm(folder.join("sparse_001.pfm"), &sparse).unwrap();
    let map = "radiance=sparse_###.pfm,albedo=kd_###.pfm,normal=facing_###.pfm,view_z=far_###.pfm";
    let run = denoise_with("upsample-external", &folder, &["--map", map]);
    succeeds(&run);
    assert!(
        run.out
            .contains("grid_albedo <- albedo at the middle of each cell"),
        "{}",
        run.out
    );
    // Each pixel as the one that was traced in its cell.
    let nearest = Image::from_fn(wall::SIZE[0], wall::SIZE[1], |x, y| {
        sparse.get(x / 4, y / 4).unwrap()
    });
    let (before, after) = (error(&nearest, 1), error(&result(&folder, 1), 1));
    // The checks come from the guide; what is left is smooth light, blurred over five cells, of which there are ten.
    assert!(after * 10.0 < before, "{before} became {after}");
}

#[test]
fn what_is_missing_or_wrong_gets_one_message() {
    let (_place, folder) = folder();
    wall::mitsuba(&folder, 3);
    let shown = folder.display();
    let fails = |more: &[&str]| message(denoise(&folder, more));
    let at = cameras(&folder);

    let missing = fails(&[]);
    assert!(
        missing.starts_with("graph input `motion`: no layer is called motion, vector. There are `wall.####.exr` with BGR, albedo (BGR), dd (T), img (BGR), nn (XYZ), pos (XYZ). Name one with --map motion=FILE:LAYER, give --cameras FILE where only the camera moves, or --still"),
        "{missing}"
    );
    assert_eq!(
        fails(&["--still"]),
        "frame 1: graph input `view_z`: distance becomes depth along the view axis by the field of view; \
         give --cameras FILE or --fov DEGREES, or --depth z where it is that already"
    );
    assert_eq!(
        fails(&["--map", "nromal=wall.####.exr:nn"]),
        "--map nromal=…: the graph has no such input; did you mean `normal`?"
    );
    assert_eq!(
        fails(&["--map", "normal=nn.####.exr"]),
        format!(
            "--map normal=nn.####.exr: there is no such file in `{shown}`; there are wall.####.exr"
        )
    );
    assert_eq!(
        fails(&["--map", "normal=wall.####.exr:mm"]),
        "--map normal=wall.####.exr:mm: the file has no layer `mm`; it has BGR, albedo (BGR), dd (T), img (BGR), nn (XYZ), pos (XYZ)"
    );
    assert_eq!(
        fails(&["--map", "normal=wall.####.exr:dd", "--cameras", &at]),
        "frame 1: graph input `normal` takes 3 channels, and `wall.####.exr:dd` has dd (T)"
    );
    assert_eq!(
        fails(&["--map", "view_z=wall.####.exr:nn", "--cameras", &at]),
        "frame 1: graph input `view_z` takes 1 channel, and `wall.####.exr:nn` has nn (XYZ)"
    );
    let wrong = fails(&["--map", "normal=wall.####.exr:pos", "--cameras", &at]);
    assert!(
        wrong.starts_with(
            "frame 1: graph input `normal`: `wall.####.exr:pos` holds no unit vectors: one is "
        ),
        "{wrong}"
    );
    std::fs::write(folder.join("kd.jpg"), "").unwrap();
    let format = fails(&["--map", "albedo=kd.jpg", "--cameras", &at]);
    assert!(
        format.contains("kd.jpg") && format.contains(".exr, .png, .hdr, .pfm"),
        "{format}"
    );
}

#[test]
fn sequences_that_do_not_fit_together_get_one_message() {
    let (_place, folder) = folder();
    wall::loose(&folder, 4);
    let map = "radiance=light_###.pfm,normal=facing_###.pfm,view_z=far_###.pfm";
    let fails = || message(denoise(&folder, &["--map", map, "--still"]));
    let keep = |name: &str| {
        let path = folder.join(name);
        (std::fs::read(&path).unwrap(), path)
    };
    let (normal, normal_path) = keep("facing_003.pfm");
    std::fs::remove_file(&normal_path).unwrap();
    assert_eq!(
        fails(),
        "graph input `normal`: frame 3 of `facing_###.pfm` is missing; `light_###.pfm` has 4 frames, `facing_###.pfm` 3"
    );
    std::fs::write(folder.join("facing_003.pfm"), &normal).unwrap();
    std::fs::write(folder.join("facing_005.pfm"), &normal).unwrap();
    assert_eq!(
        fails(),
        "graph input `normal`: `facing_###.pfm` has a frame 5, and `light_###.pfm` has none; it has 4 frames, `facing_###.pfm` 5"
    );
    std::fs::remove_file(folder.join("facing_005.pfm")).unwrap();

    let small = Image::from_fn(8, 6, |_, _| [0.0, 0.0, 1.0]);
    write_pfm(&normal_path, &small).unwrap();
    assert_eq!(
        fails(),
        format!(
            "frame 3: graph input `normal`: `{}` is 8x6, and must be 40x30 as the other images are",
            normal_path.display()
        )
    );
    std::fs::write(&normal_path, &normal[..normal.len() / 2]).unwrap();
    let short = fails();
    assert!(
        short.starts_with("frame 3: ")
            && short.contains("facing_003.pfm")
            && short.contains("bytes"),
        "{short}"
    );
}

#[test]
fn files_that_cannot_be_read_get_one_message() {
    let (_place, folder) = folder();
    wall::mitsuba(&folder, 2);
    let at = cameras(&folder);
    let whole = std::fs::read(folder.join("wall.0002.exr")).unwrap();
    std::fs::write(folder.join("wall.0002.exr"), &whole[..whole.len() / 3]).unwrap();
    let short = message(denoise(&folder, &["--cameras", &at]));
    assert!(
        short.starts_with("frame 2: ") && short.contains("wall.0002.exr"),
        "{short}"
    );
    std::fs::write(folder.join("wall.0001.exr"), "no image").unwrap();
    let none = message(denoise(&folder, &["--cameras", &at]));
    assert!(none.contains("wall.0001.exr"), "{none}");

    wall::mitsuba(&folder, 2);
    let layers = wall::layer("", ["R", "G", "B"], &wall::frame(2), |p| p.noisy);
    wall::write(&folder.join("wall.0002.exr"), layers);
    let gone = message(denoise(&folder, &["--cameras", &at]));
    assert!(
        gone.ends_with("has no layer `albedo`, and the first frame has"),
        "{gone}"
    );

    wall::mitsuba(&folder, 2);
    let few = std::fs::read_to_string(&at)
        .unwrap()
        .replace("\"frame\":2", "\"frame\":9");
    std::fs::write(&at, few).unwrap();
    let absent = message(denoise(&folder, &["--cameras", &at]));
    assert_eq!(absent, format!("`{at}`: there is no camera for frame 2"));
}

#[test]
fn what_is_no_pipeline_for_images_is_told() {
    let place = Place::new(DIRECT);
    let (_place, folder) = folder();
    let (input, output) = (folder.display().to_string(), out(&folder));
    let run = |graph: &str, output: &str| {
        message(scumble(&[
            "denoise", graph, "--input", &input, "--output", output,
        ]))
    };
    assert_eq!(
        run(&place.graph, &output),
        format!(
            "`{}` has no `inputs`: nothing can be fed to it; `scumble render` renders a scene with it",
            place.graph
        )
    );
    let graph = graph("denoise-spatial");
    assert_eq!(
        run(&graph, &output),
        format!(
            "there are no images in `{input}`: .exr, .pfm, .hdr or .png, as in beauty.0001.exr"
        )
    );
    assert_eq!(
        run(&graph, &input),
        format!(
            "`{input}` is both input and output: frames that are written would be read; give another --output"
        )
    );
    let part = format!("{}/../../graphs/svgf-chain.ron", env!("CARGO_MANIFEST_DIR"));
    assert!(run(&part, &output).contains("neither an output `linear` nor an output `display`"));
}

/// Files that name themselves need no --map, and two that may be one thing are not guessed at.
#[test]
fn files_are_known_by_their_names() {
    let (_place, folder) = folder();
    let image = |value: [f32; 3]| Image::from_fn(16, 12, |_, _| value);
    write_exr(folder.join("beauty.0001.exr"), &image([1.0; 3])).unwrap();
    write_exr(folder.join("normal.0001.exr"), &image([0.0, 0.0, 1.0])).unwrap();
    write_pfm(folder.join("depth.0001.pfm"), &image([2.0; 3])).unwrap();
    let run = denoise_with("denoise-spatial", &folder, &["--json"]);
    succeeds(&run);
    let report: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let from: Vec<_> = (0..5)
        .map(|i| report["inputs"][i]["from"].as_str().unwrap())
        .collect();
    assert_eq!(
        from,
        [
            "beauty.####.exr",
            "nothing",
            "nothing",
            "normal.####.exr",
            "depth.####.pfm"
        ]
    );
    // Even light is what it was.
    let kept = result(&folder, 1);
    assert!(kept.data.iter().flatten().all(|v| (v - 1.0).abs() < 1e-3));

    let z = vec![Channel {
        name: "a.Depth.Z".into(),
        values: vec![2.0; 1200],
    }];
    let more = vec![Channel {
        name: "b.Depth.Z".into(),
        values: vec![2.0; 1200],
    }];
    std::fs::remove_file(folder.join("depth.0001.pfm")).unwrap();
    wall::write(&folder.join("one.0001.exr"), [z, more].concat());
    assert_eq!(
        message(denoise_with("denoise-spatial", &folder, &[])),
        "graph input `view_z`: several layers may be it: `one.####.exr:a.Depth`, `one.####.exr:b.Depth`; say which with --map view_z=FILE:LAYER"
    );
}
