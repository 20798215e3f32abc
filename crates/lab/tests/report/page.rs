//! The report as text.

use super::sample::{ODD, results};
use scumble_lab::Results;
use std::collections::BTreeSet;

fn report() -> (Results, String, serde_json::Value) {
    let folder = tempfile::tempdir().unwrap();
    let results = results(folder.path());
    results.write(folder.path()).unwrap();
    let found = BTreeSet::from([results.runs[0].key.clone()]);
    let path = results.write_report(folder.path(), Some(&found)).unwrap();
    let html = std::fs::read_to_string(path).unwrap();
    let json = std::fs::read_to_string(folder.path().join("results.json")).unwrap();
    (results, html, serde_json::from_str(&json).unwrap())
}

/// A start tag with its attributes.
struct Tag<'h> {
    name: &'h str,
    attributes: &'h str,
}

impl<'h> Tag<'h> {
    fn attribute(&self, name: &str) -> Option<&'h str> {
        let (_, rest) = self.attributes.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0)
    }
}

const VOID: [&str; 4] = ["meta", "input", "br", "link"];

/// Every start tag, where all are closed in order: stricter than HTML is.
fn tags(html: &str) -> Vec<Tag<'_>> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    let mut rest = html.strip_prefix("<!DOCTYPE html>").unwrap();
    while let Some((before, after)) = rest.split_once('<') {
        assert!(!before.contains('>'), "a stray `>` in {before}");
        let (tag, mut next) = after.split_once('>').unwrap();
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else {
            let tag = tag.trim_end();
            let closed = tag.ends_with('/');
            let tag = tag.trim_end_matches('/');
            let name = tag.split_whitespace().next().unwrap();
            found.push(Tag {
                name,
                attributes: &tag[name.len()..],
            });
            if name == "script" || name == "style" {
                let (_, end) = next.split_once(&format!("</{name}>")).unwrap();
                next = end;
            } else if !closed && !VOID.contains(&name) {
                open.push(name);
            }
        }
        rest = next;
    }
    assert!(open.is_empty(), "{open:?} stay open");
    found
}

#[test]
fn it_is_well_formed_and_needs_nothing_else() {
    let (_, html, _) = report();
    let tags = tags(&html);
    let mut ids = BTreeSet::new();
    for tag in &tags {
        if let Some(id) = tag.attribute("id") {
            assert!(ids.insert(id), "two elements are `{id}`");
        }
        for name in ["src", "srcset", "data", "action", "poster", "xlink:href"] {
            assert_eq!(tag.attribute(name), None, "<{}>", tag.name);
        }
        assert_ne!(tag.name, "link");
    }
    let targets: Vec<&str> = tags.iter().filter_map(|t| t.attribute("href")).collect();
    assert!(!targets.is_empty());
    for target in targets {
        let id = target.strip_prefix('#').unwrap();
        assert!(ids.contains(id), "nothing is `{id}`");
    }
    for word in [
        "url(",
        "@import",
        "fetch(",
        "XMLHttpRequest",
        "import(",
        "https://",
    ] {
        assert!(!html.contains(word), "{word}");
    }
    // Of the two drawings' namespace alone.
    let addresses = html.matches("http://").count();
    assert_eq!(
        addresses,
        html.matches("http://www.w3.org/2000/svg").count()
    );
    for id in [
        "summary",
        "pareto",
        "curves",
        "sweep",
        "effects",
        "stages",
        "viewer-body",
        "graphs",
        "origin",
        "failures",
    ] {
        assert!(ids.contains(id), "no `{id}`");
    }
}

#[test]
fn names_are_text() {
    let (_, html, _) = report();
    assert!(!html.contains(ODD));
    assert!(
        html.contains("a &quot;quoted&quot; &lt;b&gt;&amp;amp;&lt;/b&gt; 'name'&lt;/script&gt;")
    );
    assert!(!html.contains("nowhere <i>") && !html.contains("adapter <1>"));
    let (_, data) = html.split_once("id=\"viewer-data\">").unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["methods"][1], ODD);
    // 2 scenes with 2 frames; each method and reference of these is there.
    assert_eq!(data["groups"].as_array().unwrap().len(), 4);
    let names = data["groups"].as_array().unwrap().iter();
    for name in names.flat_map(|g| g["images"].as_object().unwrap().values()) {
        assert!(html.contains(&format!("id=\"{}\"", name.as_str().unwrap())));
    }
}

/// The numbers of a piece of HTML.
fn numbers(html: &str) -> Vec<f64> {
    let parts = html.split("<data value=\"").skip(1);
    parts
        .map(|part| part.split_once('"').unwrap().0.parse().unwrap())
        .collect()
}

/// The same but for the last binary digit, which serde_json does not read for sure.
fn assert_same(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    for (f, w) in found.iter().zip(wanted) {
        assert!((f - w).abs() <= f64::EPSILON * w.abs(), "{f} {w}");
    }
}

#[test]
fn numbers_are_those_of_the_results() {
    let (_, html, json) = report();
    let (_, summary) = html.split_once("<section id=\"summary\">").unwrap();
    let (summary, _) = summary.split_once("</section>").unwrap();
    let rows: Vec<Vec<f64>> = summary
        .split("<tr>")
        .map(numbers)
        .filter(|n| !n.is_empty())
        .collect();
    let summaries = json["summaries"].as_array().unwrap();
    assert_eq!((rows.len(), summaries.len()), (8, 8));
    for (row, summary) in rows.iter().zip(summaries) {
        let mut wanted = vec![
            &summary["rays_per_pixel"],
            &summary["frame_ms"][1],
            &summary["memory"],
        ];
        for metric in json["design"]["metrics"].as_array().unwrap() {
            let metric = &summary["metrics"][metric.as_str().unwrap()];
            wanted.extend([&metric["estimate"]["mean"], &metric["estimate"]["half"]]);
            if let Some(difference) = metric["against"].get("base") {
                wanted.extend([&difference["mean"], &difference["half"]]);
            }
        }
        let wanted: Vec<f64> = wanted.into_iter().map(|v| v.as_f64().unwrap()).collect();
        assert_same(row, &wanted);
    }
    // The least relMSE and the highest SSIM are the base's.
    let best: Vec<bool> = summary
        .split("<tr>")
        .skip(2)
        .map(|r| r.contains("class=\"best\""))
        .collect();
    assert_eq!(best[..4], [true, false, false, false]);
    assert!(summary.contains("worse") && !summary.contains(" better</span>"));

    let (_, effects) = html.split_once("id=\"effects\"").unwrap();
    let (effects, _) = effects.split_once("</section>").unwrap();
    let wanted = json["effects"].as_array().unwrap().iter();
    let wanted = wanted.flat_map(|of| of["effects"].as_array().unwrap());
    let wanted = wanted.flat_map(|e| [&e["estimate"]["mean"], &e["estimate"]["half"]]);
    let wanted: Vec<f64> = wanted.map(|v| v.as_f64().unwrap()).collect();
    assert_same(&numbers(effects), &wanted);
}

#[test]
fn what_was_there_is_told_and_commands_are_for_a_shell() {
    let (results, html, _) = report();
    assert!(html.contains("23 runs were rendered, 1 were there already."));
    let wanted = "scumble render g.ron --set a.b=1 --set a.samples=3 --scene cornell --size 32x24 --frames 8 --seed 1";
    assert!(html.contains(wanted));
    for run in &results.runs {
        // `a & b` is escaped.
        assert!(html.contains(&run.key.replace('&', "&amp;")));
    }
    let folder = tempfile::tempdir().unwrap();
    let images = scumble_lab::Images::new(folder.path());
    let bare = results.report(&images, None).unwrap();
    assert!(
        bare.contains("There are no images of these runs.")
            && bare.contains("There is no drawing of it.")
    );
    assert!(bare.contains("Made again from the records of 24 runs."));
    tags(&bare);
}

#[test]
fn the_budget_and_the_references_are_told_as_they_are() {
    let facts = |change: fn(&mut Results)| {
        let folder = tempfile::tempdir().unwrap();
        let mut results = results(folder.path());
        change(&mut results);
        let path = results.write_report(folder.path(), None).unwrap();
        std::fs::read_to_string(path).unwrap()
    };
    let rays = facts(|_| {});
    assert!(rays.contains("equal rays, 1 path per pixel and frame"));
    assert!(rays.contains("<dd>64 paths per pixel</dd>"));
    let time = facts(|results| {
        results.design.equal_rays = None;
        results.design.equal_time = Some(20.0);
        results.design.reference_files = Some("refs/{scene}.exr".into());
    });
    assert!(time.contains("equal time, 20 ms per frame"));
    assert!(time.contains("<dd>refs/{scene}.exr</dd>") && !time.contains("64 paths per pixel"));
}
