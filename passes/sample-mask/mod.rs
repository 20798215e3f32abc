#![doc = include_str!("README.md")]

mod blue_noise;

use framegraph::ComputeKernel;
use scumble::{BuildContext, BuildError, Pass, PassFrame, Port, RecordError, signal};

scumble::choice! {
    /// In which order the pixels of a tile take their turns.
    pub enum Order {
        /// By the Halton sequence of bases 2 and 3, in tiles of 16 x 9.
        #[default]
        Halton,
        /// By void and cluster, in tiles of 16 x 16.
        BlueNoise,
    }
}

scumble::params! {
    /// What `sample-mask` can be told.
    pub struct SampleMaskParams {
        /// Part of the pixels that take a sample in a frame.
        #[budget]
        pub rate: f32 = 0.25, in 0.000001..=1.0, unit "spp";
        /// In which order the pixels take their turns.
        pub order: Order = Order::Halton;
    }
}

/// Pixels of a tile of the Halton order: 2^4 x 3^2.
const HALTON_TILE: [u32; 2] = [16, 9];

/// The pass; see the module.
pub struct SampleMask {
    kernel: ComputeKernel,
    blue_noise: Vec<u8>,
}

/// Ranks that are due before a frame. In f64: the product of a frame and a rate needs more digits than f32 has.
fn due(frame: u32, rate: f32, tile: u32) -> u64 {
    (f64::from(frame) * f64::from(rate) * f64::from(tile) + 1e-6).floor() as u64
}

impl Pass for SampleMask {
    type Params = SampleMaskParams;
    const NAME: &'static str = "sample-mask";
    const ABOUT: &'static str =
        "Which pixels take a sample in this frame, for less than one sample per pixel";
    const README: &'static str = include_str!("README.md");

    fn inputs() -> Vec<Port> {
        vec![]
    }

    fn outputs() -> Vec<Port> {
        vec![Port::new("mask", signal::MASK).about("1 where a sample is taken")]
    }

    fn build(ctx: &BuildContext<'_>, _p: &SampleMaskParams) -> Result<Self, BuildError> {
        Ok(Self {
            kernel: ctx.kernel(
                "sample-mask/sample_mask.wgsl",
                include_str!("sample_mask.wgsl"),
                "main",
            )?,
            blue_noise: blue_noise::ranks()
                .iter()
                .flat_map(|rank| rank.to_ne_bytes())
                .collect(),
        })
    }

    fn record(
        &mut self,
        p: &SampleMaskParams,
        frame: &mut PassFrame<'_, '_>,
    ) -> Result<(), RecordError> {
        let [width, height] = match p.order {
            Order::Halton => HALTON_TILE,
            Order::BlueNoise => [blue_noise::SIDE; 2],
        };
        let tile = width * height;
        let number = frame.input_frame().frame;
        let first = due(number, p.rate, tile);
        let count = due(number.saturating_add(1), p.rate, tile) - first;
        let size = frame.full_size();
        let label = frame.label("ranks");
        let ranks = frame
            .graph()
            .buffer(label.clone(), self.blue_noise.len() as u64);
        let ranks = frame
            .graph()
            .upload_buffer(label, ranks, self.blue_noise.clone());
        frame
            .dispatch("sample mask", &self.kernel)
            .buffer("blue_noise", ranks)
            .set("tile", [width, height])
            .set("first", (first % u64::from(tile)) as u32)
            .set("count", count as u32)
            .over(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_has_its_turn_once_in_a_round() {
        for (rate, frames) in [
            (1.0 / 16.0, 16),
            (0.25, 4),
            (0.5, 2),
            (1.0, 1),
            (1.0 / 3.0, 3),
        ] {
            let ranks = |frame: u32| due(frame + 1, rate, 144) - due(frame, rate, 144);
            assert_eq!((0..frames).map(ranks).sum::<u64>(), 144, "{rate}");
            // Late frames are as full as early ones.
            assert_eq!(
                (900_000..900_000 + frames).map(ranks).sum::<u64>(),
                144,
                "{rate}"
            );
        }
    }
}
