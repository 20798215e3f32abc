//! A second graph and the drawn graph in the window, with a real mouse.

use super::desk::{Desk, is_asked_for};
use super::{COUNT, GRAPH, LOOK};
use scumble_metrics::Image;

/// Whether a pixel has this colour of 8 bits.
fn is(pixel: [f32; 3], colour: [u8; 3]) -> bool {
    let linear = colour.map(|v| scumble_metrics::linear_from_srgb(f32::from(v) / 255.0));
    // Half a step of 8 bits.
    (0..3).all(|c| (pixel[c] - linear[c]).abs() < 0.003)
}

/// How many pixels of each column have a colour.
fn columns(screen: &Image, colour: [u8; 3]) -> Vec<usize> {
    let count = |x| {
        let column = (0..screen.height).filter_map(|y| screen.get(x, y));
        column.filter(|pixel| is(*pixel, colour)).count()
    };
    (0..screen.width).map(count).collect()
}

/// Where the line between the two pictures is.
fn line(screen: &Image) -> Option<u32> {
    let columns = columns(screen, [255, 190, 60]);
    let found = columns.iter().position(|count| *count > 100)?;
    Some(found as u32)
}

/// A pixel at the upper left of the first box in each column of the drawn graph whose passes run.
fn heads(screen: &Image) -> Vec<[u32; 2]> {
    const HEAD: [u8; 3] = [45, 66, 96];
    let columns = columns(screen, HEAD);
    let starts = (1..columns.len()).filter(|&x| columns[x] > 3 && columns[x - 1] <= 3);
    // Letters part a box's head into several runs of columns; boxes are further apart.
    let mut heads: Vec<[u32; 2]> = Vec::new();
    for x in starts {
        let x = x as u32 + 3;
        let top = (0..screen.height).find(|&y| screen.get(x, y).is_some_and(|p| is(p, HEAD)));
        let Some(y) = top else { continue };
        let known = heads
            .last()
            .is_some_and(|last| (last[0]..x).all(|between| columns[between as usize] > 0));
        if !known {
            heads.push([x, y + 2]);
        }
    }
    heads
}

#[test]
fn the_divider_is_dragged_and_the_drawn_graph_bypasses() {
    if !is_asked_for() {
        return;
    }
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("graph.ron", GRAPH);
    write(
        "other.ron",
        &GRAPH.replace("look.wgsl\"", "look.wgsl\", with: (gain: 0.0)"),
    );
    write("count.wgsl", COUNT);
    write("look.wgsl", LOOK);
    let args = [
        "graph.ron",
        "--compare",
        "other.ron",
        "--scene",
        "cornell",
        "--size",
        "960x660",
        "--scale",
        "8",
    ];
    let mut desk = Desk::new(folder, &args);
    let at = desk.until("two pictures", || line(&desk.screen("two-graphs")));
    desk.drag([at, 200], [at - 120, 200]);
    desk.until("the line where it was dragged to", || {
        let now = line(&desk.screen("divider"))?;
        // It is two pixels wide, and four under the mouse.
        (now.abs_diff(at - 120) <= 4).then_some(())
    });

    desk.key("g");
    let drawn = |name: &str, count: usize| {
        desk.until(name, || {
            let heads = heads(&desk.screen(name));
            (heads.len() == count).then_some(heads)
        })
    };
    // The count and the depth stand in the first column; what reads both can be bypassed.
    let found = drawn("drawn", 3);
    desk.press(found[1], 3);
    drawn("drawn-bypassed", 2);
    desk.press(found[1], 3);
    drawn("drawn-again", 3);
    assert!(desk.runs());
}
