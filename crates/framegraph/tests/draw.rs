//! Plans as pictures and as data. Pictures are looked at by people; here it is tested that they can be
//! read (no text over another), that they name everything, and that the data is right.

mod common;
use std::collections::BTreeSet;

use common::*;
use framegraph::*;

/// Every kind of node and of resource, and two compute passes.
/// ```text
/// target (imported) -> raster (loads it) -> target.1
/// words: upload -> words.1 -> copy -> copied
/// h@-1 -> sum -> h -> foreign (reads) ; h => export      pyramid: two mips, one write each => export
/// produce -> dead
/// ```
fn everything(pool: &Pool, device: &wgpu::Device, k: &Kernels) -> Snapshot {
    let raster = RasterKernel::new(
        device,
        &RasterKernelDesc {
            label: "fill",
            wgsl: "@group(0) @binding(0) var shade: texture_2d<f32>;
                   @vertex fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                       return vec4f(f32(i), 0.0, 0.0, 1.0);
                   }
                   @fragment fn fs() -> @location(0) vec4f { return textureLoad(shade, vec2u(0), 0); }",
            vertex: "vs",
            fragment: "fs",
            external_groups: &[],
            targets: &[wgpu::TextureFormat::R32Float],
            depth: Some(wgpu::TextureFormat::Depth32Float),
            depth_compare: wgpu::CompareFunction::Greater,
            cull: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
        },
    )
    .unwrap();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 64,
            height: 64,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let mut fg = pool.frame(FrameParams { frame: 7, ..FRAME });
    let target = fg.import_texture("target", &target);
    let pyramid = fg.texture("scene/pyramid", R32.with_mips(2));
    let pyramid = produce(&mut fg, k, "scene/mip 0", pyramid.mip(0));
    let pyramid = increment(&mut fg, k, "scene/mip 1", pyramid.mip(0), pyramid.mip(1));
    let h = fg.history_texture("h", R32, 1, First::Clear([0.0; 4]));
    let mut node = fg.compute("sum <a & \"b\">", &k.sum);
    node.read("a", h.previous[0].unwrap());
    node.read("b", pyramid.mip(1));
    let h = node.overwrite("out_value", h.current);
    node.dispatch_texels([64, 64]);
    let mut node = fg.foreign("egui");
    node.read(h, wgpu::TextureUsages::TEXTURE_BINDING);
    node.side_effect("draws to the window");
    node.record(|_, _| {});
    let depth = fg.texture(
        "depth",
        TextureDesc::d2(wgpu::TextureFormat::Depth32Float, Size::Frame),
    );
    let mut node = fg.raster("raster", &raster);
    node.read("shade", pyramid.mip(0));
    node.color(0, target, Load::Load);
    node.depth(depth, Load::Clear(0.0));
    node.draw(|_| {});
    let copied = fg.texture("copied", R32);
    let copied = fg.copy_texture("copy", h, copied);
    let copied = bump(&mut fg, k, "bump", copied);
    let (words, dead) = (fg.buffer("words", 8), fg.texture("dead", R32));
    let words = fg.upload_buffer("upload", words, vec![0; 8]);
    produce(&mut fg, k, "produce", dead);
    fg.export_texture("pyramid", pyramid);
    fg.export_texture("h", h);
    fg.export_texture("copied", copied);
    fg.export_buffer("words", words);
    fg.compile().unwrap().snapshot()
}

fn snapshot() -> Snapshot {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    everything(&pool, &device, &k)
}

#[test]
fn a_snapshot_says_who_wrote_what_is_read() {
    let s = snapshot();
    let resource = |u: &UseInfo| s.resources[u.resource as usize].name.to_string();
    let from = |node: &str| -> Vec<String> {
        let node = s.nodes.iter().find(|n| n.name == *node).unwrap();
        let own = &s.uses[node.uses.start as usize..node.uses.end as usize];
        let read = |u: &UseInfo| {
            let by = |&from: &u32| {
                s.nodes[s.uses[from as usize].node as usize]
                    .name
                    .to_string()
            };
            let mut writers: Vec<String> = u.from.iter().map(by).collect();
            writers.extend(u.from_before.then(|| "before".to_string()));
            format!("{}: {} from {}", u.port, resource(u), writers.join(", "))
        };
        own.iter()
            .filter(|u| u.mode != Mode::Overwrite)
            .map(read)
            .collect()
    };
    assert_eq!(
        from("scene/mip 1"),
        ["input: scene/pyramid from scene/mip 0"]
    );
    assert_eq!(
        from("sum <a & \"b\">"),
        [
            "a: h@-1 from first h@-1",
            "b: scene/pyramid from scene/mip 1"
        ]
    );
    assert_eq!(
        from("raster"),
        [
            "shade: scene/pyramid from scene/mip 0",
            "color 0: target from before"
        ]
    );
    assert_eq!(from("copy"), ["from: h from sum <a & \"b\">"]);
    assert_eq!(from("bump"), ["value: copied from copy"]);
    let pyramid = &s.resources[1];
    let last: Vec<&str> = pyramid
        .last
        .iter()
        .map(|&u| s.uses[u as usize].part.as_str())
        .collect();
    assert_eq!(last, ["mip 0", "mip 1"]);
    let apart: Vec<bool> = s.passes.iter().map(|p| p.apart.is_some()).collect();
    assert!(s.passes.len() > 1);
    assert_eq!(apart.iter().position(|apart| *apart), Some(1));
    assert!(s.text.contains("dispatch bump"));
}

/// The members that `docs/plan-json.md` documents are those that are there, each at its place.
#[test]
fn json_is_what_its_page_says() {
    let s = snapshot();
    let json: serde_json::Value = serde_json::from_str(&s.json()).unwrap();
    assert_eq!(json["nodes"].as_array().unwrap().len(), s.nodes.len());
    let sum = json["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|n| n["name"] == "sum <a & \"b\">");
    assert_eq!(sum.unwrap()["uses"][0]["port"], "a");
    let page = include_str!("../docs/plan-json.md");
    let rows = page.lines().filter_map(|l| l.strip_prefix("| `"));
    let known: BTreeSet<String> = rows
        .filter_map(|row| Some(row.split_once('`')?.0.replace("[]", "")))
        .collect();
    let mut found = BTreeSet::new();
    collect(&json, "", &mut found);
    let batches = serde_json::from_str(&with_a_batch().json()).unwrap();
    collect(&batches, "", &mut found);
    assert_eq!(found, known);
}

/// Two copies of what a compute pass has written, and one barrier for both.
fn with_a_batch() -> Snapshot {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| fg.texture(name, R32));
    let [a, b] = [a, b].map(|t| produce(&mut fg, &k, "produce", t));
    for (key, from, to) in [("c", a, c), ("d", b, d)] {
        let copied = fg.copy_texture("copy", from, to);
        fg.export_texture(key, copied);
    }
    fg.compile().unwrap().snapshot()
}

fn collect(value: &serde_json::Value, at: &str, into: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(members) => {
            for (key, value) in members {
                let name = if at.is_empty() {
                    key.clone()
                } else {
                    format!("{at}.{key}")
                };
                collect(value, &name, into);
                into.insert(name);
            }
        }
        serde_json::Value::Array(items) => items.iter().for_each(|item| collect(item, at, into)),
        _ => {}
    }
}

/// ```text
/// produce -> a.1 -> copy -> b => export
///              \--> bump -> a.2 => export
/// ```
#[test]
fn dot_is_exact() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let (a, b) = (fg.texture("a", R32), fg.texture("b", R32));
    let a = produce(&mut fg, &k, "produce", a);
    let b = fg.copy_texture("copy", a, b);
    let a = bump(&mut fg, &k, "bump", a);
    fg.export_texture("before", b);
    fg.export_texture("after \"x\"", a);
    let dot = fg.compile().unwrap().dot();
    let lines: Vec<&str> = dot
        .lines()
        .map(str::trim)
        .filter(|l| !l.contains("<table"))
        .collect();
    assert_eq!(
        lines[4..],
        [
            "subgraph cluster_0 {",
            "label=\"compute pass 1\"; labeljust=l; color=\"#555555\"; style=rounded; fontname=\"monospace\"; fontsize=10;",
            "}",
            "subgraph cluster_1 {",
            "label=\"compute pass 2\\lapart: `bump` waits for copy `copy`, which waits for `produce`\\l\"; labeljust=l; color=\"#555555\"; style=rounded; fontname=\"monospace\"; fontsize=10;",
            "}",
            "n0:o0 -> n1:i1;",
            "n0:o0 -> n2:i3;",
            "n1 -> n2 [style=dotted, color=\"#777777\", label=\"write after read\"];",
            "x0 [shape=box, style=\"rounded,bold\", label=\"export before\"];",
            "n1:o2 -> x0;",
            "x1 [shape=box, style=\"rounded,bold\", label=\"export after \\\"x\\\"\"];",
            "n2:o3 -> x1;",
            "}",
        ]
    );
    assert_eq!(dot.lines().filter(|l| l.contains("<table")).count(), 3);
}

/// A line of text in a picture, and the rectangle that it fills at most.
struct Words {
    text: String,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// The unrotated texts of a picture; wide fonts have 0.605 of the size per character.
fn words(svg: &str) -> Vec<Words> {
    let attribute = |line: &str, name: &str| {
        let from = line.split_once(&format!(" {name}=\""))?.1;
        Some(from.split_once('"')?.0.to_owned())
    };
    let number = |line: &str, name: &str| attribute(line, name)?.parse::<f64>().ok();
    let mut all = Vec::new();
    for line in svg.lines().filter(|l| l.starts_with("<text x=")) {
        let (x, y) = (number(line, "x").unwrap(), number(line, "y").unwrap());
        let size = match attribute(line, "class").unwrap().as_str() {
            "h" => 13.0,
            "n" => 11.0,
            "t" => 10.0,
            _ => 9.0,
        };
        let inside = line
            .split_once('>')
            .unwrap()
            .1
            .strip_suffix("</text>")
            .unwrap();
        let text = inside
            .replace("&quot;", "\"")
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&amp;", "&");
        let width = text.chars().count() as f64 * 0.605 * size;
        let left = match attribute(line, "text-anchor").as_deref() {
            Some("middle") => x - width / 2.0,
            Some("end") => x - width,
            _ => x,
        };
        all.push(Words {
            text,
            left,
            right: left + width,
            top: y - 0.75 * size,
            bottom: y + 0.2 * size,
        });
    }
    all
}

#[test]
fn no_text_of_a_picture_covers_another() {
    let s = snapshot();
    let svg = s.svg();
    let all = words(&svg);
    for name in [
        "raster",
        "bump",
        "sum <a & \"b\">",
        "compute pass 2",
        "target",
        "Lifetimes",
        "shade",
    ] {
        assert!(all.iter().any(|w| w.text == name), "{name} is missing");
    }
    let size = |name: &str| -> f64 {
        let from = svg.split_once(&format!("{name}=\"")).unwrap().1;
        from.split_once('"').unwrap().0.parse().unwrap()
    };
    let (width, height) = (size("width"), size("height"));
    for (i, a) in all.iter().enumerate() {
        assert!(
            a.left >= 0.0 && a.right <= width && a.top >= 0.0 && a.bottom <= height,
            "`{}` leaves the picture",
            a.text
        );
        for b in &all[..i] {
            let apart =
                a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
            assert!(apart, "`{}` covers `{}`", a.text, b.text);
        }
    }
}

/// A node that is switched off keeps its place, and the drawings say that it is off.
/// ```text
/// produce -> a.1 -> bump (off) -> a.2 => export
/// ```
#[test]
fn what_is_off_is_drawn_as_off() {
    let (device, queue) = noop();
    let (k, pool) = (Kernels::new(&device), Pool::new(&device, &queue));
    let mut fg = pool.frame(FRAME);
    let a = fg.texture("a", R32);
    let a = produce(&mut fg, &k, "produce", a);
    let mut node = fg.compute("bump", &k.bump);
    node.enabled_if(false);
    let a = node.modify("value", a);
    node.dispatch([8, 8, 1]);
    fg.export_texture("a", a);
    let plan = fg.compile().unwrap();
    assert!(
        words(&plan.svg())
            .iter()
            .any(|w| w.text == "dispatch 8x8x1, off")
    );
    assert!(plan.dot().contains("<b>bump</b> dispatch 8x8x1, off"));
    let json: serde_json::Value = serde_json::from_str(&plan.json()).unwrap();
    let off = |n: usize| json["nodes"][n]["off"].as_bool().unwrap();
    assert_eq!([off(0), off(1)], [false, true]);
}

/// Nothing to draw is drawn too.
#[test]
fn an_empty_plan_has_a_picture() {
    let (device, queue) = noop();
    let pool = Pool::new(&device, &queue);
    let plan = pool.frame(FRAME).compile().unwrap();
    assert!(plan.svg().ends_with("</svg>\n"));
    assert!(plan.dot().ends_with("}\n"));
    let json: serde_json::Value = serde_json::from_str(&plan.json()).unwrap();
    assert_eq!(json["order"], serde_json::json!([]));
}
