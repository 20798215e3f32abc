//! The images that a report carries within it, for its viewer.

use crate::images::{Images, full_error};
use crate::measure::Exposed;
use crate::record::Record;
use crate::results::Results;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;
use scumble_metrics::{ColorMap, ErrorMap, Image, Metric, read};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::Write;

/// Most bytes of text that the images of a report take: browsers open such a file without delay.
const MOST: usize = 24 << 20;

/// What the viewer is given.
pub(super) struct Embedded {
    /// What it shows, which names the images.
    pub data: Value,
    /// Images by name: deflated, in base64.
    pub images: Vec<(String, String)>,
    /// Frames that are embedded, of all that have images.
    pub frames: [usize; 2],
}

/// A frame of a scene and camera path: all methods and the reference.
struct Group<'r> {
    cell: usize,
    frame: u32,
    /// By method.
    records: Vec<(usize, &'r Record)>,
}

/// Takes the last frame of each scene and path, then those before, until there are too many.
pub(super) fn embed(results: &Results, images: &Images) -> Embedded {
    let (cells, mut groups) = all_groups(results);
    let all = groups.len();
    // The last frames come first; a stable sort keeps the order of scenes.
    groups.sort_by_key(|(nth, _)| *nth);
    let mut store = Store::default();
    let mut kept: Vec<(usize, u32, Value)> = Vec::new();
    for (_, group) in groups {
        let before = store.clone();
        let Some(value) = store.group(&group, images) else {
            store = before;
            continue;
        };
        if store.bytes > MOST && !kept.is_empty() {
            store = before;
            break;
        }
        kept.push((group.cell, group.frame, value));
    }
    kept.sort_by_key(|(cell, frame, _)| (*cell, *frame));
    let shown: Vec<Value> = kept.into_iter().map(|(.., value)| value).collect();
    let metrics = results.design.metrics.iter();
    let metrics = metrics.filter_map(|name| name.parse::<Metric>().ok());
    let metrics = metrics.filter(|metric| metric.has_map());
    let methods = results.design.variants.iter().map(|v| v.name.as_str());
    Embedded {
        frames: [shown.len(), all],
        data: json!({
            "size": results.design.size,
            "methods": methods.collect::<Vec<_>>(),
            "metrics": metrics.map(|m| json!({"name": m.name(), "full": full_error(m)})).collect::<Vec<_>>(),
            "cells": cells,
            "groups": shown,
            "magma": magma(),
        }),
        images: store.images,
    }
}

/// The scenes and camera paths, and every frame with how many come after it on its path.
fn all_groups(results: &Results) -> (Vec<Value>, Vec<(usize, Group<'_>)>) {
    let design = &results.design;
    let (mut cells, mut groups) = (Vec::new(), Vec::new());
    let places = design.scenes.iter();
    let places = places.flat_map(|scene| design.cameras.iter().map(move |c| (scene, &c.name)));
    for (scene, camera) in places {
        let shown = |r: &&Record| {
            r.scene == *scene && r.camera == *camera && design.seeds.first() == Some(&r.seed)
        };
        let runs = results.runs.iter().filter(shown);
        let place = |r: &Record| design.variants.iter().position(|v| v.name == r.variant);
        let records: Vec<(usize, &Record)> = runs.filter_map(|r| Some((place(r)?, r))).collect();
        let Some((_, first)) = records.first() else {
            continue;
        };
        for (nth, frame) in first.frames.iter().rev().enumerate() {
            let records = records.clone();
            let (cell, frame) = (cells.len(), frame.frame);
            groups.push((
                nth,
                Group {
                    cell,
                    frame,
                    records,
                },
            ));
        }
        cells.push(json!({"scene": scene, "camera": camera, "exposure": first.exposure}));
    }
    (cells, groups)
}

/// Images under their names.
#[derive(Clone, Default)]
struct Store {
    images: Vec<(String, String)>,
    bytes: usize,
    /// References by key: one may serve several frames.
    references: BTreeMap<String, String>,
}

impl Store {
    /// Adds a frame; `None` without its reference or any image.
    fn group(&mut self, group: &Group<'_>, images: &Images) -> Option<Value> {
        let (_, first) = group.records.first()?;
        let of_frame = first.frames.iter().find(|f| f.frame == group.frame)?;
        let key = &of_frame.reference;
        let truth = read(images.reference(&first.scene, &first.camera, key, "exr")).ok()?;
        let reference = match self.references.get(key) {
            Some(name) => name.clone(),
            None => {
                let name = self.add(&radiance(&truth));
                self.references.insert(key.clone(), name.clone());
                name
            }
        };
        let exposed_truth = Exposed::new(&truth, first.exposure);
        let (mut shown, mut maps) = (Map::new(), Map::new());
        for (method, record) in &group.records {
            let Ok(image) = read(images.run(record, group.frame, "exr")) else {
                continue;
            };
            if image.size() != truth.size() {
                continue;
            }
            shown.insert(method.to_string(), self.add(&radiance(&image)).into());
            let exposed = Exposed::new(&image, record.exposure);
            let mine = self.maps(record, &exposed, &exposed_truth);
            maps.insert(method.to_string(), mine.into());
        }
        let value = json!({
            "cell": group.cell,
            "frame": group.frame,
            "reference": reference,
            "images": &shown,
            "maps": maps,
        });
        (!shown.is_empty()).then_some(value)
    }

    /// The error maps that the viewer does not compute.
    fn maps(
        &mut self,
        record: &Record,
        image: &Exposed,
        reference: &Exposed,
    ) -> Map<String, Value> {
        let names = record.frames.first().into_iter();
        let names = names.flat_map(|frame| frame.metrics.keys());
        let metrics = names.filter_map(|name| name.parse::<Metric>().ok());
        let whole = |m: &Metric| matches!(m, Metric::Ssim | Metric::Flip | Metric::HdrFlip);
        let mut maps = Map::new();
        for metric in metrics.filter(whole) {
            if let Ok(map) = image.map(reference, metric) {
                let name = self.add(&steps(&map, full_error(metric)));
                maps.insert(metric.to_string(), name.into());
            }
        }
        maps
    }

    fn add(&mut self, bytes: &[u8]) -> String {
        let name = format!("image-{}", self.images.len());
        let text = BASE64_STANDARD.encode(deflated(bytes));
        self.bytes += text.len();
        self.images.push((name.clone(), text));
        name
    }
}

/// The high bytes of all half floats, then the low ones: like beside like deflates better.
fn radiance(image: &Image) -> Vec<u8> {
    let values = image.data.iter().flatten();
    let halves: Vec<[u8; 2]> = values.map(|v| f16::from_f32(*v).to_be_bytes()).collect();
    let bytes = [0, 1].map(|i| halves.iter().map(move |half| half[i]));
    bytes.into_iter().flatten().collect()
}

/// Errors in 255 steps.
fn steps(map: &ErrorMap, full: f64) -> Vec<u8> {
    let step = |error: &f64| (255.0 * (error / full).clamp(0.0, 1.0)).round() as u8;
    map.data.iter().map(step).collect()
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Memory takes what is written.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// The colours of error maps from 0 to the full error, as 256 times six hexadecimal digits.
fn magma() -> String {
    let ramp = ErrorMap {
        width: 256,
        height: 1,
        data: (0..256).map(|i| f64::from(i) / 255.0).collect(),
    };
    let colors = ramp.to_image(ColorMap::Magma, 1.0);
    let bytes = colors
        .data
        .iter()
        .flatten()
        .map(|v| (v * 255.0).round() as u8);
    bytes.map(|byte| format!("{byte:02x}")).collect()
}
