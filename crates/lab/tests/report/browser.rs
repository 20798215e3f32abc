//! The viewer in Chromium: every control and key is used.

use super::sample::{EXPOSURE, ODD, SIZE, radiance, results};
use super::webdriver::{Browser, DOWN, LEFT, RIGHT, UP};
use scumble_lab::Exposed;
use scumble_metrics::Image;
use serde_json::{Value, json};
use std::path::Path;

struct Viewer {
    browser: Browser,
}

impl Viewer {
    /// The viewer's state, once it is drawn.
    fn state(&self) -> Value {
        let body = "document.getElementById('viewer-body').dataset";
        self.browser
            .wait(&format!("{body}.drawn && {body}.drawn === {body}.state"));
        let text = self.browser.run(&format!("return {body}.state"));
        serde_json::from_str(text.as_str().unwrap()).unwrap()
    }

    /// Presses a key; gives one field of the state then.
    fn press(&self, key: &str, field: &str) -> Value {
        self.browser.press(key, false);
        self.state()[field].take()
    }

    fn click(&self, selector: &str, field: &str) -> Value {
        self.browser.click(selector);
        self.state()[field].take()
    }

    fn send(&self, selector: &str, keys: &str, field: &str) -> Value {
        self.browser.send(selector, keys);
        self.state()[field].take()
    }

    /// Colour in the middle of a pane, a little right and below, where no two pixels of the image meet.
    fn color(&self, pane: usize) -> [i64; 3] {
        self.state();
        let script = format!(
            "const c = document.getElementById('v-pane-{pane}'), copy = new OffscreenCanvas(1, 1);
             const context = copy.getContext('2d', {{ willReadFrequently: true }});
             context.drawImage(c, Math.floor(c.width / 2) + 3, Math.floor(c.height / 2) + 3, 1, 1, 0, 0, 1, 1);
             return [...context.getImageData(0, 0, 1, 1).data]"
        );
        let data = self.browser.run(&script);
        [0, 1, 2].map(|i| data[i].as_i64().unwrap())
    }

    fn readout(&self) -> Vec<Vec<String>> {
        self.state();
        let rows = self.browser.run(
            "return [...document.querySelectorAll('#v-values tr')].map(r => [...r.children].map(c => c.textContent))",
        );
        serde_json::from_value(rows).unwrap()
    }
}

/// What the middle of an image looks like, in bytes.
fn display(method: Option<usize>, frame: u32, exposure: f64) -> [i64; 3] {
    let image = Image::from_fn(1, 1, |_, _| {
        radiance(method, frame, SIZE[0] / 2, SIZE[1] / 2)
    });
    let shown = Exposed::new(&image, exposure).display.data[0];
    shown.map(|v| (v * 255.0).round() as i64)
}

/// Half floats, the steps of the encoding and rounding are within 2 of 255.
fn assert_near(found: [i64; 3], wanted: [i64; 3]) {
    let far = found.iter().zip(wanted).any(|(f, w)| (f - w).abs() > 2);
    assert!(!far, "{found:?} is not {wanted:?}");
}

#[test]
fn every_control_of_the_viewer() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let page = results(folder.path())
        .write_report(folder.path(), None)
        .unwrap();
    browser.open(&page);
    let pictures = Path::new(env!("CARGO_TARGET_TMPDIR"));
    browser.screenshot(&pictures.join("report-top.png"));
    browser.run("document.getElementById('viewer').scrollIntoView()");
    let viewer = Viewer { browser };
    viewer.state();
    keys(&viewer);
    pixels(&viewer);
    controls(&viewer);
    pointer(&viewer);
    rest_of_the_page(&viewer.browser);

    viewer
        .browser
        .run("document.getElementById('viewer').scrollIntoView()");
    viewer.press("e", "error");
    viewer
        .browser
        .screenshot(&pictures.join("report-viewer.png"));
    let dark = json!({"features": [{"name": "prefers-color-scheme", "value": "dark"}]});
    let paper = || {
        viewer
            .browser
            .run("return getComputedStyle(document.body).backgroundColor")
    };
    let light = paper();
    viewer.browser.devtools("Emulation.setEmulatedMedia", dark);
    assert_ne!(paper(), light);
    viewer.browser.screenshot(&pictures.join("report-dark.png"));
    assert_eq!(viewer.browser.console(), json!([]));
    let loaded = "return performance.getEntriesByType('resource').map(e => e.name)";
    assert_eq!(viewer.browser.run(loaded), json!([]));
}

fn keys(viewer: &Viewer) {
    assert_eq!(viewer.state()["a"], "0");
    assert_eq!(viewer.press("3", "a"), "2");
    assert_eq!(viewer.press("9", "a"), "2", "there is no ninth");
    viewer.browser.press("2", true);
    assert_eq!(viewer.state()["b"], "1");
    assert_eq!(viewer.press("x", "a"), "1");
    assert_eq!(viewer.press(RIGHT, "a"), "2");
    assert_eq!(viewer.press(LEFT, "a"), "1");
    assert_eq!(viewer.press("r", "a"), "reference");
    assert_eq!(viewer.press(RIGHT, "a"), "0");
    assert_eq!(viewer.press("v", "mode"), "split");
    assert_eq!(viewer.press("v", "mode"), "side");
    assert_eq!(viewer.press("v", "mode"), "one");
    assert_eq!(viewer.press("e", "error"), true);
    assert_eq!(viewer.press("m", "metric"), 1);
    assert_eq!(viewer.press("e", "error"), false);
    assert_eq!(viewer.press("]", "stops"), 0.5);
    assert_eq!(viewer.press("[", "stops"), 0);
    viewer.press("[", "stops");
    assert_eq!(viewer.press("\\", "stops"), 0);
    assert_eq!(viewer.press("+", "zoom"), 1.5);
    viewer.browser.press(RIGHT, true);
    viewer.browser.press(DOWN, true);
    let state = viewer.state();
    // From the middle, a tenth of what is seen of the width.
    assert!((state["x"].as_f64().unwrap() - (16.0 + 3.2 / 1.5)).abs() < 1e-9);
    assert!((state["y"].as_f64().unwrap() - (12.0 + 3.2 / 1.5)).abs() < 1e-9);
    viewer.browser.press(LEFT, true);
    viewer.browser.press(UP, true);
    assert_eq!(viewer.press("-", "zoom"), 1);
    viewer.press("+", "zoom");
    assert_eq!(viewer.press("f", "zoom"), 1);
    assert_eq!(viewer.press(".", "group"), 1);
    assert_eq!(
        viewer.press(".", "group"),
        0,
        "after the last frame comes the first"
    );
    assert_eq!(viewer.press(",", "group"), 1);
    assert_eq!(viewer.press(",", "group"), 0);
    viewer.press("?", "a");
    assert_eq!(
        viewer
            .browser
            .run("return document.getElementById('v-help').open"),
        true
    );
    assert_eq!(
        viewer.press("3", "a"),
        "0",
        "keys rest while their list is open"
    );
    viewer.browser.click("#v-help button");
    assert_eq!(
        viewer
            .browser
            .run("return document.getElementById('v-help').open"),
        false
    );
    viewer.press("1", "a");
    viewer.press("m", "metric");
    assert_eq!(
        viewer.press("m", "metric"),
        0,
        "three of the metrics have a map, then the first again"
    );
}

fn pixels(viewer: &Viewer) {
    let frame = 3;
    // Away from the image: the values are those in its middle.
    viewer.browser.hover("#viewer h2", [0, 0]);
    viewer
        .browser
        .wait("document.getElementById('v-where').textContent.includes('middle')");
    assert_near(viewer.color(0), display(Some(0), frame, EXPOSURE));
    viewer.press("]", "stops");
    viewer.press("]", "stops");
    assert_near(viewer.color(0), display(Some(0), frame, 2.0 * EXPOSURE));
    viewer.press("\\", "stops");
    viewer.press("r", "a");
    assert_near(viewer.color(0), display(None, 0, EXPOSURE));
    // Split: left of the divider A, right of it B, of the same place; the middle column is the divider.
    viewer.press("1", "a");
    viewer.browser.press("4", true);
    viewer.press("v", "mode");
    let script = "document.getElementById('v-split').value = 0.52; document.getElementById('v-split').dispatchEvent(new Event('input'))";
    viewer.browser.run(script);
    assert_near(viewer.color(0), display(Some(0), frame, EXPOSURE));
    viewer.browser.run(&script.replace("0.52", "0.48"));
    assert_near(viewer.color(0), display(Some(3), frame, EXPOSURE));
    // Side by side: A, B and the reference.
    viewer.press("v", "mode");
    assert_near(viewer.color(0), display(Some(0), frame, EXPOSURE));
    assert_near(viewer.color(1), display(Some(3), frame, EXPOSURE));
    assert_near(viewer.color(2), display(None, 0, EXPOSURE));
    viewer.press("v", "mode");
    // The error map: magma at relMSE / 0.25, which the readout tells too.
    viewer.press("e", "error");
    let color = viewer.color(0);
    let rows = viewer.readout();
    let error: f64 = rows[0][5].parse().unwrap();
    let [x, r] =
        [Some(0), None].map(|m| radiance(m, frame, 16, 12).map(|v| f64::from(v) * EXPOSURE));
    let terms = x
        .iter()
        .zip(r)
        .map(|(x, r)| (x - r).powi(2) / (r * r + 0.01));
    let relmse = terms.sum::<f64>() / 3.0;
    // Four digits are told, and half floats have eleven binary ones.
    assert!((error / relmse - 1.0).abs() < 0.01, "{error} {relmse}");
    let map = scumble_metrics::ErrorMap {
        width: 1,
        height: 1,
        data: vec![relmse],
    };
    let wanted = map.to_image(scumble_metrics::ColorMap::Magma, 0.25).data[0];
    let far = color
        .iter()
        .zip(wanted)
        .map(|(c, w)| (*c as f64 - 255.0 * f64::from(w)).abs());
    // A step of the map changes a channel by at most 4.
    assert!(far.fold(0.0, f64::max) <= 5.0, "{color:?} {wanted:?}");
    viewer.press("e", "error");
}

fn controls(viewer: &Viewer) {
    assert_eq!(viewer.send("#v-a", "3", "a"), "2");
    assert_eq!(viewer.send("#v-b", "R", "b"), "reference");
    assert_eq!(viewer.send("#v-frame", "7", "group"), 1);
    assert_eq!(viewer.send("#v-cell", DOWN, "group"), 2);
    assert_eq!(viewer.send("#v-cell", UP, "group"), 0);
    assert_eq!(viewer.click("#v-swap", "a"), "reference");
    assert_eq!(viewer.click("[name=v-mode][value=side]", "mode"), "side");
    assert_eq!(viewer.click("[name=v-mode][value=one]", "mode"), "one");
    assert_eq!(viewer.click("[name=v-mode][value=split]", "mode"), "split");
    let split = viewer.state()["split"].as_f64().unwrap();
    let stepped = viewer.send("#v-split", RIGHT, "split").as_f64().unwrap();
    assert!((stepped - split - 0.005).abs() < 1e-9, "{split} {stepped}");
    assert_eq!(viewer.send("#v-stops", RIGHT, "stops"), 0.25);
    assert_eq!(viewer.send("#v-stops", LEFT, "stops"), 0);
    assert_eq!(viewer.click("#v-in", "zoom"), 1.5);
    assert_eq!(viewer.click("#v-out", "zoom"), 1);
    viewer.click("#v-actual", "zoom");
    let scale = "return document.getElementById('v-zoom-value').textContent";
    assert_ne!(viewer.browser.run(scale), "100 %");
    assert_eq!(viewer.click("#v-fit", "zoom"), 1);
    assert_eq!(viewer.click("#v-error", "error"), true);
    assert_eq!(viewer.send("#v-metric", "flip", "metric"), 2);
    assert_eq!(viewer.send("#v-opacity", LEFT, "opacity"), 0.95);
    assert_eq!(viewer.send("#v-scale", LEFT, "scale"), -0.5);
    assert_eq!(viewer.send("#v-scale", RIGHT, "scale"), 0);
    assert_eq!(viewer.click("#v-error", "error"), false);
    viewer.send("#v-metric", "relmse", "metric");
    viewer.click("#v-error", "error");
    viewer.click("#v-keys", "a");
    assert_eq!(
        viewer
            .browser
            .run("return document.getElementById('v-help').open"),
        true
    );
    viewer.browser.click("#v-help button");
    let names = viewer
        .browser
        .run("return [...document.querySelectorAll('#v-a option')].map(o => o.textContent)");
    assert_eq!(
        names,
        json!([
            "1 base",
            format!("2 {ODD}"),
            "3 without x",
            "4 both",
            "Reference"
        ])
    );
}

fn pointer(viewer: &Viewer) {
    viewer.click("[name=v-mode][value=one]", "mode");
    viewer.send("#v-a", "2", "a");
    viewer.click("#v-fit", "zoom");
    // WebDriver counts from the middle of what is seen of an element: all of it is to be.
    viewer
        .browser
        .run("document.getElementById('v-panes').scrollIntoView({block: 'center'})");
    // 5.5 pixels of the image right of the middle: the one at 21, 12.
    let scale = "const b = document.getElementById('v-pane-0').getBoundingClientRect(); return Math.min(b.width / 32, b.height / 24)";
    let scale = viewer.browser.run(scale).as_f64().unwrap();
    let at = |pixels: f64| (pixels * scale) as i32;
    viewer.browser.hover("#v-pane-0", [at(5.5), at(0.5)]);
    viewer
        .browser
        .wait("document.getElementById('v-where').textContent === 'Pixel 21, 12'");
    viewer
        .browser
        .wait("document.querySelector('#v-values td').textContent !== ''");
    let rows = viewer.readout();
    let wanted = radiance(Some(1), 3, 21, 12);
    for (told, wanted) in rows[0][1..4].iter().zip(wanted) {
        let told: f64 = told.parse().unwrap();
        // As above.
        assert!((told / f64::from(wanted) - 1.0).abs() < 1e-3, "{rows:?}");
    }
    assert_eq!(rows.last().unwrap()[0], "Reference");
    // The wheel zooms, and the pixel under the cursor stays.
    viewer.browser.wheel("#v-pane-0", [at(5.5), at(0.5)], -400);
    let zoomed = viewer.state();
    assert!(zoomed["zoom"].as_f64().unwrap() > 1.5);
    assert_eq!(
        viewer
            .browser
            .run("return document.getElementById('v-where').textContent"),
        "Pixel 21, 12"
    );
    viewer.browser.drag("#v-pane-0", &[[0, 0], [at(1.0), 0]]);
    let moved = zoomed["x"].as_f64().unwrap() - viewer.state()["x"].as_f64().unwrap();
    // Places of the pointer are whole pixels of the screen.
    assert!(
        (moved * zoomed["zoom"].as_f64().unwrap() - 1.0).abs() < 2.0 / scale,
        "{moved}"
    );
    // All panes have the same place and zoom, as they have one state.
    viewer.click("[name=v-mode][value=split]", "mode");
    let width = "return document.getElementById('v-pane-0').getBoundingClientRect().width";
    let width = viewer.browser.run(width).as_f64().unwrap();
    let split = viewer.state()["split"].as_f64().unwrap();
    let divider = ((split - 0.5) * width).round() as i32;
    viewer
        .browser
        .drag("#v-pane-0", &[[divider, 0], [divider + 100, 0]]);
    let after = viewer.state()["split"].as_f64().unwrap();
    assert!(
        (after - split - 100.0 / width).abs() < 2.0 / width,
        "{split} {after}"
    );
    viewer
        .browser
        .run("document.getElementById('v-pane-0').dispatchEvent(new MouseEvent('dblclick'))");
    assert_eq!(viewer.state()["zoom"], 1);
}

fn rest_of_the_page(browser: &Browser) {
    // 2 scenes, of each 3 kinds of plots and 2 of effects.
    let shown = "return [...document.querySelectorAll('[data-metric]')].filter(f => !f.hidden).map(f => f.dataset.metric)";
    let of =
        |metric: &str, count: usize| assert_eq!(browser.run(shown), json!(vec![metric; count]));
    of("relmse", 8);
    browser.send("#plot-metric", "flip");
    of("flip", 8);
    browser.click("#graphs details:nth-of-type(2) summary");
    let text = "return document.querySelector('#graphs details[open] .graph').shadowRoot.querySelector('text').textContent";
    assert_eq!(browser.run(text), "a graph");
    // Its style stays within it.
    let color = "return getComputedStyle(document.querySelector('#pareto ~ .figures text')).fill";
    assert_ne!(browser.run(color), "rgb(18, 52, 86)");
    browser.click("nav a[href='#origin']");
    browser.click("#origin details summary");
    assert_eq!(
        browser.run("return document.querySelectorAll('#origin tbody tr').length"),
        24
    );
}
