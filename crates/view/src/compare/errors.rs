//! How far two images on the screen are apart, measured beside the frames.

use crate::background::Job;
use scumble::{Readback, ReadbackError, Texels};
use scumble_metrics::{FLIP_PIXELS_PER_DEGREE, Image, flip_map, relmse};
use std::time::{Duration, Instant};

/// Between two measurements at least, and of the time at most so much for them: the processor that measures may be the
/// one that renders.
const EVERY: Duration = Duration::from_millis(500);
const SHARE: f64 = 0.25;

/// What is on the screen of two graphs, the second the reference: as light, and as it is shown.
#[derive(Clone, Copy)]
pub struct Pictures<'a> {
    /// Linear values, where there are any.
    pub light: Option<[&'a wgpu::Texture; 2]>,
    /// What is shown, display-encoded.
    pub shown: [&'a wgpu::Texture; 2],
}

/// How far an image is from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// relMSE of the linear values, or why there is none.
    pub relmse: Result<f64, String>,
    /// Mean FLIP of the pictures as they are shown, or why there is none.
    pub flip: Result<f64, String>,
}

impl Errors {
    /// Of an image and its reference: what is shown, and the linear values of it.
    pub fn of(shown: [&Image; 2], light: Option<[&Image; 2]>) -> Errors {
        let flip = flip_map(shown[0], shown[1], FLIP_PIXELS_PER_DEGREE);
        let relmse = match light {
            Some([image, reference]) => relmse(image, reference).map_err(|e| e.to_string()),
            None => Err("there are no linear values".to_owned()),
        };
        Errors {
            relmse,
            flip: flip.map(|map| map.mean()).map_err(|e| e.to_string()),
        }
    }
}

impl Errors {
    /// Of nothing.
    fn none() -> Errors {
        let nothing = || Err("nothing is shown".to_owned());
        Errors {
            relmse: nothing(),
            flip: nothing(),
        }
    }
}

/// Measures [`Errors`] now and then. Images come back while frames go on, and one thread of its own computes.
#[derive(Default)]
pub struct Comparer {
    /// What is shown of both, and the linear values of both.
    pending: Vec<Readback>,
    job: Job<(Errors, Duration)>,
    next: Option<Instant>,
    latest: Option<Errors>,
}

impl Comparer {
    /// Records copies of the images of a frame, when it is time.
    ///
    /// # Errors
    /// A texture that cannot be read.
    pub fn look(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        pictures: Pictures<'_>,
    ) -> Result<(), ReadbackError> {
        let early = self.next.is_some_and(|next| Instant::now() < next);
        if early || !self.pending.is_empty() || self.job.is_running() {
            return Ok(());
        }
        let mut copy = |texture: &wgpu::Texture| {
            let whole = [texture.width(), texture.height()];
            Readback::record(device, encoder, texture, [0, 0], whole)
        };
        let light = pictures.light.iter().flatten();
        let copies = pictures
            .shown
            .iter()
            .chain(light)
            .map(|texture| copy(texture));
        self.pending = copies.collect::<Result<_, _>>()?;
        self.next = Some(Instant::now() + EVERY);
        Ok(())
    }

    /// Call it after the frame was submitted.
    pub fn submitted(&mut self) {
        self.pending.iter_mut().for_each(Readback::submitted);
    }

    /// What was found last; call it after the device was polled.
    ///
    /// # Errors
    /// A device that is gone.
    pub fn latest(&mut self) -> Result<Option<&Errors>, ReadbackError> {
        if !self.pending.is_empty() && self.pending.iter_mut().all(Readback::is_there) {
            let copies = std::mem::take(&mut self.pending);
            let came = copies.into_iter().filter_map(|mut copy| copy.take());
            let texels: Vec<Texels> = came.collect::<Result<_, _>>()?;
            self.job.start(move || measure(&texels));
        }
        if let Some((errors, took)) = self.job.take() {
            let rest = took.mul_f64(1.0 / SHARE - 1.0);
            self.next = self.next.max(Some(Instant::now() + rest));
            self.latest = Some(errors);
        }
        Ok(self.latest.as_ref())
    }

    /// Something else is shown: what was found is of what was shown before.
    pub fn forget(&mut self) {
        *self = Comparer::default();
    }
}

fn measure(texels: &[Texels]) -> (Errors, Duration) {
    let start = Instant::now();
    let errors = || {
        let images: Vec<Image> = texels.iter().map(image).collect();
        match &images[..] {
            [a, b, c, d] => Errors::of([a, b], Some([c, d])),
            [a, b, ..] => Errors::of([a, b], None),
            _ => Errors::none(),
        }
    };
    // The metrics would take every core of the machine.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let errors = match one {
        Ok(one) => one.install(errors),
        Err(_) => errors(),
    };
    (errors, start.elapsed())
}

fn image(texels: &Texels) -> Image {
    let [width, height] = texels.size();
    let data = texels.decode().into_iter().map(|[r, g, b, _]| [r, g, b]);
    Image {
        width,
        height,
        data: data.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_images_are_not_apart() {
        let image = Image::from_fn(16, 16, |x, y| [x as f32 / 16.0, y as f32 / 16.0, 0.5]);
        let errors = Errors::of([&image, &image], Some([&image, &image]));
        assert_eq!(errors.relmse, Ok(0.0));
        // FLIP filters both alike, and so finds nothing.
        assert_eq!(errors.flip, Ok(0.0));
    }

    #[test]
    fn the_second_is_the_reference() {
        let dark = Image::from_fn(16, 16, |_, _| [0.1; 3]);
        let light = Image::from_fn(16, 16, |_, _| [0.9; 3]);
        let of = |a, b| Errors::of([a, b], Some([a, b])).relmse.unwrap();
        // The difference counts more beside a dark reference: 0.64 / (0.01 + 0.01) and 0.64 / (0.81 + 0.01), in f32.
        assert!((of(&light, &dark) - 32.0).abs() < 1e-4);
        assert!((of(&dark, &light) - 0.64 / 0.82).abs() < 1e-5);
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let small = Image::from_fn(4, 4, |_, _| [0.5; 3]);
        let large = Image::from_fn(8, 8, |_, _| [0.5; 3]);
        let errors = Errors::of([&small, &large], Some([&small, &large]));
        assert!(errors.relmse.is_err() && errors.flip.is_err(), "{errors:?}");
        let broken = Image::from_fn(4, 4, |x, _| [x as f32 / 0.0, 0.0, 0.0]);
        let errors = Errors::of([&small, &small], Some([&broken, &small]));
        assert!(errors.relmse.is_err() && errors.flip.is_ok(), "{errors:?}");
        assert!(Errors::of([&small, &small], None).relmse.is_err());
    }
}
