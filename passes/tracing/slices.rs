//! Spreads samples over dispatches of a capped number of rays.

/// What one dispatch traces: some samples of some rows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Slice {
    pub first_row: u32,
    pub rows: u32,
    pub first_sample: u32,
    pub samples: u32,
}

/// Most rays that one thread traces in one dispatch, unless a single path has more.
///
/// Mesa's software rasteriser leaves every loop once a thread has gone round 65535 times in all
/// (`LP_MAX_TGSI_LOOP_ITERATIONS`), and with it goes light; a ray goes round some hundred times. Other devices only gain
/// shorter dispatches.
const RAYS_PER_THREAD: u64 = 64;

/// Splits `samples` samples of `size` texels, `rays` rays each at most, into dispatches of at most `cap` rays: whole
/// frames of as many samples as fit, else rows of one sample. A single row is never split. `threads` share the samples
/// of a texel.
pub(crate) fn slices(
    size: [u32; 2],
    samples: u32,
    rays: u64,
    cap: u64,
    threads: u32,
) -> Vec<Slice> {
    let per_row = (u64::from(size[0]) * rays).max(1);
    let per_frame = (per_row * u64::from(size[1])).max(1);
    let per_thread = (RAYS_PER_THREAD / rays.max(1)).max(1) * u64::from(threads);
    let samples_each = u32::try_from((cap / per_frame).min(per_thread))
        .unwrap_or(u32::MAX)
        .clamp(1, samples.max(1));
    let rows_each = u32::try_from(cap / per_row)
        .unwrap_or(u32::MAX)
        .clamp(1, size[1].max(1));
    let mut all = Vec::new();
    for first_sample in (0..samples).step_by(samples_each as usize) {
        for first_row in (0..size[1]).step_by(rows_each as usize) {
            all.push(Slice {
                first_row,
                rows: rows_each.min(size[1] - first_row),
                first_sample,
                samples: samples_each.min(samples - first_sample),
            });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every (row, sample) exactly once, and no slice above the cap unless it is one row of one sample.
    #[test]
    fn slices_cover_all_samples_once_below_the_cap() {
        for (size, samples, rays, cap) in [
            ([64, 64], 100, 10, 4_000_000),
            ([64, 64], 100, 10, 400_000),
            ([33, 17], 7, 2, 100),
            ([33, 17], 7, 2, 10),
            ([1, 1], 1, 2, 1),
            ([1024, 1024], 3, 10, 4_000_000),
            ([8, 4], 5, 2, 130),
        ] {
            let all = slices(size, samples, rays, cap, 1);
            let mut seen = vec![0u32; (size[1] * samples) as usize];
            for s in &all {
                let traced = u64::from(size[0] * s.rows * s.samples) * rays;
                assert!(
                    traced <= cap || s.rows * s.samples == 1,
                    "{s:?} traces {traced} of {cap}"
                );
                for sample in s.first_sample..s.first_sample + s.samples {
                    for row in s.first_row..s.first_row + s.rows {
                        seen[(sample * size[1] + row) as usize] += 1;
                    }
                }
            }
            assert!(
                seen.iter().all(|&n| n == 1),
                "{size:?} {samples} {rays} {cap}: {all:?}"
            );
        }
    }

    #[test]
    fn what_fits_is_one_dispatch() {
        let one = Slice {
            first_row: 0,
            rows: 64,
            first_sample: 0,
            samples: 6,
        };
        assert_eq!(slices([64, 64], 6, 10, 4_000_000, 1), [one]);
        let shared = Slice { samples: 90, ..one };
        assert_eq!(slices([64, 64], 90, 10, 4_000_000, 64), [shared]);
    }

    #[test]
    fn a_thread_traces_few_rays() {
        for (rays, threads, most) in [(2, 1, 32), (10, 1, 6), (10, 64, 384), (130, 1, 1)] {
            let all = slices([4, 4], 1000, rays, u64::MAX, threads);
            assert!(
                all.iter().all(|s| s.samples <= most) && all[0].samples == most,
                "{rays} {threads}: {:?}",
                all[0]
            );
        }
    }
}
