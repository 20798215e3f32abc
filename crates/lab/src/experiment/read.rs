//! From RON values to an [`Experiment`], every mistake collected.

use super::cameras::{camera, number};
use super::{Ablate, Budget, Experiment, Factor, GraphChoice, Measure, ReferenceChoice};
use scumble::diagnostics::{Diagnostic, Diagnostics, SourceFile, Span, Spanned, code};
use scumble::file::{Node, Shape};
use std::path::Path;

/// Fields of an experiment.
const FIELDS: &[&str] = &[
    "version",
    "about",
    "scenes",
    "material_override",
    "base",
    "compare",
    "ablate",
    "sweep",
    "camera",
    "seeds",
    "budget",
    "reference",
    "metrics",
    "size",
    "quick",
];

/// Those that must be there.
const NEEDED: [(&str, &str); 7] = [
    ("scenes", "`scenes: [\"cornell\"]`"),
    ("base", "`base: \"graphs/upsample-2016.ron\"`"),
    ("camera", "`camera: [(still: 0, frames: 8)]`"),
    ("seeds", "`seeds: 4`"),
    ("reference", "`reference: (samples: 256, every: 4)`"),
    ("metrics", "`metrics: [RelMse, Ssim, Flicker]`"),
    ("size", "`size: (240, 135)`"),
];

/// Most factors of a factorial design.
const MOST_FACTORS: usize = 6;

pub(super) fn file(path: &Path, quick: bool) -> Result<Experiment, Diagnostics> {
    let (node, _) = Node::read(path)?;
    experiment(path, &node, quick)
}

pub(super) fn text(name: &str, text: &str, quick: bool) -> Result<Experiment, Diagnostics> {
    let (node, _) = Node::of_file(&SourceFile::new(name, text))?;
    experiment(Path::new(name), &node, quick)
}

fn experiment(path: &Path, node: &Node, quick: bool) -> Result<Experiment, Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    let file = fields(path, node, quick, &mut diagnostics);
    match diagnostics.or(file)? {
        Some(file) => Ok(file),
        None => Err(Diagnostic::new(code::SYNTAX, "the file is empty").into()),
    }
}

fn fields(
    path: &Path,
    node: &Node,
    quick: bool,
    diagnostics: &mut Diagnostics,
) -> Option<Experiment> {
    node.check_version("an experiment", FIELDS, diagnostics)?;
    let fields = node.expect_fields("an experiment", FIELDS, diagnostics)?;
    for (needed, example) in NEEDED {
        if !fields.iter().any(|(name, _)| name.value == needed) {
            let message = format!("the experiment does not state `{needed}`");
            diagnostics.push(
                Diagnostic::new(code::MISSING_FIELD, message)
                    .at(&node.opening(), "")
                    .help(format!("for example {example}")),
            );
        }
    }
    let name = path.file_stem().and_then(|stem| stem.to_str());
    let mut experiment = Experiment {
        name: name.unwrap_or("experiment").to_owned(),
        directory: path.parent().unwrap_or(Path::new("")).to_owned(),
        quick,
        about: String::new(),
        scenes: Vec::new(),
        lambert: false,
        base: GraphChoice {
            path: Spanned::new(String::new(), node.opening()),
            name: String::new(),
            set: Vec::new(),
            bypass: Vec::new(),
        },
        compare: Vec::new(),
        ablate: Ablate::default(),
        sweep: Vec::new(),
        cameras: Vec::new(),
        seeds: Vec::new(),
        budget: Budget::None,
        reference: ReferenceChoice {
            samples: 1,
            every: 1,
            graph: None,
            files: None,
        },
        metrics: Vec::new(),
        size: [1, 1],
    };
    for (name, node) in fields.iter().filter(|(name, _)| name.value != "quick") {
        field(&mut experiment, &name.value, node, diagnostics);
    }
    let short = fields.iter().find(|(name, _)| name.value == "quick");
    match short {
        None if quick => diagnostics.push(
            Diagnostic::new(code::MISSING_FIELD, "the experiment has no `quick` form")
                .at(&node.opening(), "")
                .help("add one, such as `quick: (seeds: 2, size: (96, 54))`"),
        ),
        None => {}
        // Its mistakes are found in either case.
        Some((_, node)) => {
            let mut changed = experiment.clone();
            for (name, node) in
                node.expect_fields("a quick form", Experiment::QUICK, diagnostics)?
            {
                field(&mut changed, &name.value, &node, diagnostics);
            }
            check(&changed, node, diagnostics);
            if quick {
                find_references(&changed, diagnostics);
                return Some(changed);
            }
        }
    }
    check(&experiment, node, diagnostics);
    if !quick {
        find_references(&experiment, diagnostics);
    }
    Some(experiment)
}

/// Images that are to be references are there.
fn find_references(experiment: &Experiment, diagnostics: &mut Diagnostics) {
    let Some(files) = &experiment.reference.files else {
        return;
    };
    let mut missing = Vec::new();
    for scene in &experiment.scenes {
        for path in &experiment.cameras {
            for frame in experiment.reference_frames(path) {
                let name = ReferenceChoice::image(&files.value, &scene.value, &path.name, frame);
                if !missing.contains(&name) && !experiment.file(&name).is_file() {
                    missing.push(name);
                }
            }
        }
    }
    if let Some(first) = missing.first() {
        let message = match missing.len() {
            1 => format!("there is no reference `{first}`"),
            n => format!("{n} references are not there, such as `{first}`"),
        };
        diagnostics.push(
            Diagnostic::new(code::BAD_NAME, message)
                .at(&files.span, "")
                .help("`{scene}` becomes the scene, `{camera}` the camera path, `####` the frame's number, from 0"),
        );
    }
}

fn field(experiment: &mut Experiment, name: &str, node: &Node, diagnostics: &mut Diagnostics) {
    match name {
        "about" => {
            let about = node.expect_text("a sentence", diagnostics);
            experiment.about = about.map(|about| about.value).unwrap_or_default();
        }
        "scenes" => {
            experiment.scenes = some(node, "a scene or more", diagnostics)
                .iter()
                .filter_map(|n| n.expect_text("a scene", diagnostics))
                .collect();
        }
        "material_override" => match node.shape() {
            Shape::Word(word) if word == "Lambert" => experiment.lambert = true,
            _ => node.mismatch("`Lambert`", diagnostics),
        },
        "base" => {
            if let Some(base) = graph(node, diagnostics) {
                experiment.base = base;
            }
        }
        "compare" => {
            let nodes = node.expect_list("graphs", diagnostics);
            experiment.compare = nodes.iter().filter_map(|n| graph(n, diagnostics)).collect();
        }
        "ablate" => experiment.ablate = ablate(node, diagnostics),
        "sweep" => {
            experiment.sweep = node
                .expect_map("parameters", diagnostics)
                .into_iter()
                .map(|(name, values)| {
                    let values = some(&values, "a value or more", diagnostics);
                    (name, values.iter().map(|v| v.span().clone()).collect())
                })
                .collect();
        }
        "camera" => {
            let nodes = some(node, "a camera path or more", diagnostics);
            experiment.cameras = nodes
                .iter()
                .filter_map(|n| camera(n, diagnostics))
                .collect();
        }
        "seeds" => experiment.seeds = seeds(node, diagnostics),
        "budget" => experiment.budget = budget(node, diagnostics),
        "reference" => reference(&mut experiment.reference, node, diagnostics),
        "metrics" => {
            let nodes = some(node, "a metric or more", diagnostics);
            experiment.metrics = nodes
                .iter()
                .filter_map(|n| measure(n, diagnostics))
                .collect();
        }
        "size" => {
            let side = |n: &Node| match n.shape() {
                Shape::Int(n) => u32::try_from(n).ok().filter(|n| *n > 0),
                _ => None,
            };
            match node.shape() {
                Shape::Tuple(sides) if sides.len() == 2 => {
                    match (side(&sides[0]), side(&sides[1])) {
                        (Some(width), Some(height)) => experiment.size = [width, height],
                        _ => node.mismatch("whole numbers of pixels above 0", diagnostics),
                    }
                }
                _ => node.mismatch("width and height, such as `(240, 135)`", diagnostics),
            }
        }
        _ => {}
    }
}

/// The items of a list that has some.
fn some(node: &Node, what: &str, diagnostics: &mut Diagnostics) -> Vec<Node> {
    let items = node.expect_list(what, diagnostics);
    if matches!(node.shape(), Shape::List(items) if items.is_empty()) {
        let message = format!("expected {what}, and found an empty list");
        diagnostics.push(Diagnostic::new(code::SHAPE, message).at(node.span(), ""));
    }
    items
}

fn graph(node: &Node, diagnostics: &mut Diagnostics) -> Option<GraphChoice> {
    let stem = |path: &Spanned<String>| {
        let stem = Path::new(&path.value).file_stem()?.to_str()?;
        Some(stem.to_owned())
    };
    if let Shape::Text(path) = node.shape() {
        let path = Spanned::new(path, node.span().clone());
        return Some(GraphChoice {
            name: stem(&path).unwrap_or_default(),
            path,
            set: Vec::new(),
            bypass: Vec::new(),
        });
    }
    let fields = match node.shape() {
        Shape::Fields(_) => {
            node.expect_fields("a graph", &["graph", "name", "set", "bypass"], diagnostics)?
        }
        _ => {
            node.mismatch("the path of a graph, or `(graph: …)`", diagnostics);
            return None;
        }
    };
    let (mut path, mut name) = (None, None);
    let (mut set, mut bypass) = (Vec::new(), Vec::new());
    for (field, node) in fields {
        match field.value.as_str() {
            "graph" => path = node.expect_text("the path of a graph", diagnostics),
            "name" => name = node.expect_text("a name", diagnostics),
            "set" => {
                let entries = node.expect_map("parameters", diagnostics).into_iter();
                set = entries.map(|(k, v)| (k, v.span().clone())).collect();
            }
            _ => bypass = patterns(&node, diagnostics),
        }
    }
    if path.is_none() {
        let message = "the graph does not state its file";
        diagnostics.push(
            Diagnostic::new(code::MISSING_FIELD, message)
                .at(&node.opening(), "")
                .help("add `graph: \"a.ron\"`"),
        );
    }
    let path = path?;
    Some(GraphChoice {
        name: name.map(|n| n.value).or_else(|| stem(&path))?,
        path,
        set,
        bypass,
    })
}

fn patterns(node: &Node, diagnostics: &mut Diagnostics) -> Vec<Spanned<String>> {
    let nodes = node.expect_list("names of passes", diagnostics);
    nodes
        .iter()
        .filter_map(|n| n.expect_text("the name of a pass", diagnostics))
        .collect()
}

fn ablate(node: &Node, diagnostics: &mut Diagnostics) -> Ablate {
    let mut ablate = Ablate::default();
    let known = &["one_out", "one_in", "factorial"];
    let fields = node.expect_fields("an ablation", known, diagnostics);
    for (name, node) in fields.unwrap_or_default() {
        match name.value.as_str() {
            "one_out" => ablate.one_out = patterns(&node, diagnostics),
            "one_in" => ablate.one_in = patterns(&node, diagnostics),
            _ => {
                let nodes = node.expect_list("passes and `(set: …)`", diagnostics);
                if nodes.len() > MOST_FACTORS {
                    let found = nodes.len();
                    let message = format!("expected {MOST_FACTORS} factors at most, not {found}");
                    diagnostics.push(Diagnostic::new(code::SHAPE, message).at(node.span(), ""));
                }
                ablate.factorial = nodes
                    .iter()
                    .filter_map(|n| factor(n, diagnostics))
                    .collect();
            }
        }
    }
    ablate
}

fn factor(node: &Node, diagnostics: &mut Diagnostics) -> Option<Factor> {
    if let Shape::Text(pattern) = node.shape() {
        let pattern = Spanned::new(pattern, node.span().clone());
        return Some(Factor::Bypass(pattern));
    }
    let expected = "the name of a pass, or `(set: {\"pass.parameter\": value})`";
    let Shape::Fields(_) = node.shape() else {
        node.mismatch(expected, diagnostics);
        return None;
    };
    let fields = node.expect_fields("a factor", &["set"], diagnostics)?;
    let entries = fields.first()?.1.expect_map("one parameter", diagnostics);
    match entries.as_slice() {
        [(name, value)] => Some(Factor::Set(name.clone(), value.span().clone())),
        _ => {
            node.mismatch(expected, diagnostics);
            None
        }
    }
}

fn seeds(node: &Node, diagnostics: &mut Diagnostics) -> Vec<u32> {
    let expected = "how many seeds, 1 or more, or a list of different ones";
    match node.shape() {
        Shape::Int(n) if (1..=10_000).contains(&n) => (1..=n as u32).collect(),
        Shape::List(nodes) => {
            let seed = |n: &Node| match n.shape() {
                Shape::Int(n) => u32::try_from(n).ok(),
                _ => None,
            };
            let seeds: Option<Vec<u32>> = nodes.iter().map(seed).collect();
            let different = |s: &[u32]| s.iter().enumerate().all(|(i, x)| !s[..i].contains(x));
            match seeds {
                Some(seeds) if !seeds.is_empty() && different(&seeds) => seeds,
                _ => {
                    node.mismatch(expected, diagnostics);
                    vec![1]
                }
            }
        }
        _ => {
            node.mismatch(expected, diagnostics);
            vec![1]
        }
    }
}

fn budget(node: &Node, diagnostics: &mut Diagnostics) -> Budget {
    if matches!(node.shape(), Shape::Word(word) if word == "None") {
        return Budget::None;
    }
    let amount = |of: &str| {
        let amount = node.argument_of(of)?.parse::<f64>().ok()?;
        (amount > 0.0 && amount <= 65536.0).then_some(amount)
    };
    if let Some(paths) = amount("EqualRays") {
        return Budget::EqualRays(paths);
    }
    if let Some(milliseconds) = amount("EqualTime") {
        return Budget::EqualTime(milliseconds);
    }
    let expected = "`None`, `EqualRays(n)` with n paths per pixel above 0, or `EqualTime(ms)` with milliseconds above 0";
    node.mismatch(expected, diagnostics);
    Budget::None
}

fn reference(into: &mut ReferenceChoice, node: &Node, diagnostics: &mut Diagnostics) {
    let known = &["samples", "every", "graph", "files"];
    let fields = node
        .expect_fields("a reference", known, diagnostics)
        .unwrap_or_default();
    let at = |wanted: &str| fields.iter().find(|(name, _)| name.value == wanted);
    // A short form with samples has no use for the images of the long one.
    into.files = into.files.take().filter(|_| at("samples").is_none());
    if let (Some((files, _)), Some((other, _))) = (at("files"), at("samples").or(at("graph"))) {
        diagnostics.push(
            Diagnostic::new(
                code::SHAPE,
                "a reference is rendered or read from files, not both",
            )
            .at(&files.span, "files")
            .at(&other.span, "for rendering"),
        );
    }
    for (name, node) in fields {
        match name.value.as_str() {
            "samples" => into.samples = number(&node, "paths per pixel", diagnostics),
            "every" => into.every = number(&node, "frames", diagnostics),
            "graph" => into.graph = node.expect_text("the path of a graph", diagnostics),
            _ => {
                into.files =
                    node.expect_text("where images are, such as `{scene}.####.exr`", diagnostics)
            }
        }
    }
}

fn measure(node: &Node, diagnostics: &mut Diagnostics) -> Option<Measure> {
    let Shape::Word(word) = node.shape() else {
        node.mismatch("the name of a metric, such as `RelMse`", diagnostics);
        return None;
    };
    let found = Measure::all().find(|measure| measure.word() == word);
    if found.is_none() {
        let words: Vec<_> = Measure::all().map(Measure::word).collect();
        let diagnostic = Diagnostic::new(code::BAD_NAME, format!("there is no metric `{word}`"));
        diagnostics.push(
            diagnostic
                .at(node.span(), "")
                .suggest(&word, words, "metrics"),
        );
    }
    found
}

/// What no field alone shows.
fn check(experiment: &Experiment, node: &Node, diagnostics: &mut Diagnostics) {
    for path in &experiment.cameras {
        if experiment.reference.every > path.frames {
            let message = format!(
                "the camera path `{}` has {} frames, and a reference is at every {}",
                path.name, path.frames, experiment.reference.every
            );
            diagnostics.push(
                Diagnostic::new(code::SHAPE, message)
                    .at(&node.opening(), "")
                    .help("no frame of it could be judged: render more, or lower `every`"),
            );
        }
    }
    let twice = |names: Vec<(&str, &Span)>, what: &str, diagnostics: &mut Diagnostics| {
        for (i, (name, span)) in names.iter().enumerate() {
            if let Some((_, first)) = names[..i].iter().find(|(other, _)| other == name) {
                let message = format!("two {what} are called `{name}`");
                diagnostics.push(
                    Diagnostic::new(code::DUPLICATE, message)
                        .at(span, "the second")
                        .at(first, "the first"),
                );
            }
        }
    };
    let graphs = [&experiment.base].into_iter().chain(&experiment.compare);
    let graphs = graphs.map(|g| (g.name.as_str(), &g.path.span)).collect();
    twice(graphs, "graphs", diagnostics);
    let scenes = experiment.scenes.iter();
    let scenes = scenes.map(|s| (s.value.as_str(), &s.span)).collect();
    twice(scenes, "scenes", diagnostics);
    let opening = node.opening();
    let cameras = experiment.cameras.iter();
    let cameras = cameras.map(|c| (c.name.as_str(), &opening)).collect();
    twice(cameras, "camera paths", diagnostics);
}
