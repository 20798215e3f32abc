//! The image viewer's elements; what it does is in `viewer.js`.

use super::embed::Embedded;
use maud::{Markup, PreEscaped, html};

/// Keys and what they do.
const KEYS: [(&str, &str); 16] = [
    ("1 … 9", "Show that method as A"),
    ("Shift 1 … 9", "Show that method as B"),
    ("r", "Show the reference as A"),
    ("← →", "The method before, the method after"),
    ("x", "Swap A and B"),
    ("v", "One image, split, side by side"),
    ("e", "Error map on and off"),
    ("m", "The next metric of the error map"),
    ("[ ]", "Darker, brighter by half a stop"),
    ("\\", "The exposure of the metrics again"),
    ("+ −", "Zoom in, out; the wheel does so at the cursor"),
    ("f", "The whole image"),
    ("Shift ← → ↑ ↓", "Move the view; dragging does so, too"),
    (", .", "The frame before, the frame after"),
    ("?", "These keys"),
    ("Esc", "Close this"),
];

pub(super) fn viewer(embedded: &Embedded) -> Markup {
    let [shown, all] = embedded.frames;
    html! {
        section id="viewer" {
            h2 { "Images" }
            @if shown == 0 {
                p { "There are no images of these runs." }
            } @else {
                p.note {
                    "Of the first seed. Values are radiance as half floats; they are shown exposed and tone mapped as for the metrics. "
                    @if shown < all { strong { (shown) " of " (all) " frames are in this file;" } " all are in the folder images beside it. " }
                    "Press " kbd { "?" } " for the keys."
                }
                div id="viewer-body" {
                    (controls(embedded))
                    div id="v-panes" {
                        @for i in 0..3 {
                            div.pane hidden[i > 0] {
                                canvas id=(format!("v-pane-{i}")) role="img" aria-label="Image; the values below are those under the cursor" {}
                                span.left {} span.right hidden {}
                            }
                        }
                    }
                    (readout())
                }
                (help())
                script type="application/json" id="viewer-data" { (PreEscaped(script_safe(&embedded.data.to_string()))) }
                @for (name, text) in &embedded.images {
                    script type="text/plain" id=(name) { (PreEscaped(text)) }
                }
                script { (PreEscaped(concat!(
                    "(() => {\n\"use strict\";\n", include_str!("images.js"), include_str!("viewer.js"), "})();\n"
                ))) }
            }
        }
    }
}

/// JSON that no parser of HTML takes for the end of its element.
fn script_safe(json: &str) -> String {
    json.replace('<', "\\u003c")
}

fn controls(embedded: &Embedded) -> Markup {
    let list = |name: &str| embedded.data[name].as_array().cloned().unwrap_or_default();
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let range = |name: &str, [min, max, step]: [&str; 3], value: &str| {
        html! { input id=(format!("v-{name}")) type="range" min=(min) max=(max) step=(step) value=(value); }
    };
    html! {
        div.controls role="group" aria-label="Viewer" {
            label { span { "Scene" } select id="v-cell" {
                @for (i, cell) in list("cells").iter().enumerate() {
                    option value=(i) { (text(&cell["scene"])) ", " (text(&cell["camera"])) }
                }
            } }
            label { span { "Frame" } select id="v-frame" {} }
            label { span { "A" } select id="v-a" {} }
            button type="button" id="v-swap" title="Swap A and B" { "⇄" }
            label { span { "B" } select id="v-b" {} }
            span role="radiogroup" aria-label="View" {
                @for (value, name) in [("one", "One"), ("split", "Split"), ("side", "Side by side")] {
                    label { input type="radio" name="v-mode" value=(value); (name) }
                }
            }
            label { span { "Divider" } (range("split", ["0", "1", "0.005"], "0.5")) }
            label { span { "Exposure" } (range("stops", ["-10", "10", "0.25"], "0")) output id="v-stops-value" {} }
            span {
                button type="button" id="v-out" title="Zoom out" { "−" }
                output id="v-zoom-value" {}
                button type="button" id="v-in" title="Zoom in" { "+" }
                button type="button" id="v-fit" { "Fit" }
                button type="button" id="v-actual" { "1 : 1" }
            }
            label { input type="checkbox" id="v-error"; "Error map" }
            label { span { "Metric" } select id="v-metric" {
                @for (i, metric) in list("metrics").iter().enumerate() {
                    option value=(i) { (text(&metric["name"])) }
                }
            } }
            label { span { "Opacity" } (range("opacity", ["0", "1", "0.05"], "1")) }
            label { span { "Range" } (range("scale", ["-8", "4", "0.5"], "0")) output id="v-scale-value" {} }
            button type="button" id="v-keys" { "Keys ?" }
        }
    }
}

fn readout() -> Markup {
    html! {
        div.readout {
            table {
                caption id="v-where" {}
                thead { tr {
                    th scope="col" { "radiance" }
                    @for channel in ["red", "green", "blue", "luminance"] { th scope="col" { (channel) } }
                    th scope="col" id="v-error-name" {}
                } }
                tbody id="v-values" {}
            }
            div.bar { "no error" canvas id="v-bar" width="256" height="1" {} "the end of the range and more" }
        }
    }
}

fn help() -> Markup {
    html! {
        dialog id="v-help" aria-label="Keys of the viewer" {
            form method="dialog" {
                table { tbody {
                    @for (key, what) in KEYS { tr { th scope="row" { kbd { (key) } } td { (what) } } }
                } }
                button { "Close" }
            }
        }
    }
}
