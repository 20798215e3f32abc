//! Every pixel has its turn once in 1 / rate frames, and turns are spread.

use crate::common::{Run, camera};
use scumble::FrameInput;

/// The masks of so many frames.
fn masks(with: &str, size: [u32; 2], frames: u32) -> Vec<Vec<u32>> {
    let mut session = Run::new("sample-mask", with, size).start(&["mask"]);
    (0..frames)
        .map(|frame| {
            session.render(&FrameInput {
                frame,
                ..FrameInput::still(camera())
            });
            session
                .read("mask")
                .iter()
                .map(|t| t[0].to_bits())
                .collect()
        })
        .collect()
}

#[test]
fn every_pixel_has_its_turn_once_in_a_round() {
    for order in ["Halton", "BlueNoise"] {
        for (rate, frames) in [(0.0625, 16), (0.25, 4), (0.5, 2), (1.0, 1)] {
            for size in [[1, 1], [33, 17], [64, 40]] {
                let with = format!("rate: {rate:?}, order: {order}");
                let masks = masks(&with, size, frames);
                for i in 0..masks[0].len() {
                    let turns: u32 = masks.iter().map(|mask| mask[i]).sum();
                    assert_eq!(turns, 1, "{with}, texel {i} of {size:?}");
                }
            }
        }
    }
}

/// The Halton points themselves: point i of 144 falls into the cell whose rank is i.
#[test]
fn halton_ranks_are_the_cells_of_the_sequence() {
    let radical = |mut i: u32, base: u32| {
        let (mut sum, mut scale) = (0.0, 1.0);
        while i > 0 {
            scale /= f64::from(base);
            sum += scale * f64::from(i % base);
            i /= base;
        }
        sum
    };
    let masks = masks("rate: 0.00694445", [16, 9], 144);
    for (i, mask) in masks.iter().enumerate() {
        let i = i as u32;
        // Halfway into the last digit, away from the borders of the cells.
        let cell = [
            (16.0 * radical(i % 16, 2) + 0.5) as usize,
            (9.0 * radical(i % 9, 3) + 0.5) as usize,
        ];
        let on: Vec<usize> = (0..144).filter(|&at| mask[at] == 1).collect();
        assert_eq!(on, [cell[1] * 16 + cell[0]], "point {i}");
    }
}
