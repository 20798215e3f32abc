//! An order of the texels of a tile in which every beginning is spread evenly: void and cluster.
//! R. A. Ulichney, "Void-and-Cluster Method for Dither Array Generation", SPIE 1913, 1993.

/// Side of the tile.
pub(super) const SIDE: u32 = 16;
const COUNT: usize = (SIDE * SIDE) as usize;
/// Ulichney's choice for the width of the filter, in texels.
const SIGMA: f64 = 1.5;

/// The rank of each texel, row by row; every rank stands once.
pub(super) fn ranks() -> [u32; COUNT] {
    let energy = kernel();
    // An even tenth to begin with: clusters move to voids until none is closer than any void is empty.
    let mut on = [false; COUNT];
    (0..COUNT / 10).for_each(|i| on[i * 97 % COUNT] = true);
    loop {
        let cluster = extreme(&on, &energy, true);
        on[cluster] = false;
        let void = extreme(&on, &energy, false);
        on[void] = true;
        if void == cluster {
            break;
        }
    }
    let mut ranks = [0; COUNT];
    let first = on.iter().filter(|on| **on).count();
    let mut left = on;
    for rank in (0..first).rev() {
        let cluster = extreme(&left, &energy, true);
        left[cluster] = false;
        ranks[cluster] = rank as u32;
    }
    for rank in first..COUNT {
        let void = extreme(&on, &energy, false);
        on[void] = true;
        ranks[void] = rank as u32;
    }
    ranks
}

/// What a texel feels of one at each offset, the tile repeated.
fn kernel() -> [f64; COUNT] {
    std::array::from_fn(|i| {
        let [x, y] = [i as u32 % SIDE, i as u32 / SIDE].map(|d| f64::from(d.min(SIDE - d)));
        (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp()
    })
}

/// Among the texels that are on, the one with most others around it; among those that are off, the one with least. The first
/// of equals.
fn extreme(on: &[bool; COUNT], kernel: &[f64; COUNT], clustered: bool) -> usize {
    let side = SIDE as usize;
    let energy = |at: usize| -> f64 {
        let felt = |other: usize| {
            let dx = (at % side + side - other % side) % side;
            let dy = (at / side + side - other / side) % side;
            kernel[dy * side + dx]
        };
        (0..COUNT).filter(|&other| on[other]).map(felt).sum()
    };
    let mut best = (0, f64::NEG_INFINITY);
    for at in (0..COUNT).filter(|&at| on[at] == clustered) {
        let score = if clustered { energy(at) } else { -energy(at) };
        if score > best.1 + 1e-12 {
            best = (at, score);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_stands_once_and_beginnings_are_spread() {
        let ranks = ranks();
        let mut sorted = ranks;
        sorted.sort_unstable();
        assert!(
            sorted
                .iter()
                .enumerate()
                .all(|(i, &rank)| i == rank as usize)
        );
        let touching = |part: u32| {
            let first =
                |x: u32, y: u32| ranks[(y % SIDE * SIDE + x % SIDE) as usize] < COUNT as u32 / part;
            let sides =
                |(x, y): (u32, u32)| u32::from(first(x + 1, y)) + u32::from(first(x, y + 1));
            (0..COUNT as u32)
                .map(|i| (i % SIDE, i / SIDE))
                .filter(|&(x, y)| first(x, y))
                .map(sides)
                .sum::<u32>()
        };
        // Of n random places 2 n^2 / 256 pairs would stand side by side: 8 of the first eighth, 32 of the first quarter.
        assert_eq!(touching(8), 0);
        assert!(touching(4) <= 32 / 3, "{}", touching(4));
    }
}
