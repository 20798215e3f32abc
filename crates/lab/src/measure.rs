//! What is measured of a run: exposed and tone mapped the same way whatever the pipeline.

use crate::error::LabError;
use crate::experiment::Measure;
use scumble_metrics::{
    ErrorMap, Image, Mask, Metric, MetricsError, MotionFlickerMeter, MovingFrame, Space, error_map,
    luminance,
};
use std::collections::BTreeMap;

/// What the geometric mean of the reference's luminance becomes.
const KEY: f64 = 0.18;
/// Pixels that are darker say nothing about exposure; the bound of the pass `tonemap`.
const BLACK: f64 = 1e-6;

/// The exposure of all runs that have these references: 0.18 over the geometric mean of their luminance.
///
/// # Errors
/// [`LabError::BlackReference`].
pub fn exposure<'a>(references: impl Iterator<Item = &'a Image>) -> Result<f64, LabError> {
    let (mut sum, mut count) = (0.0, 0_u64);
    for pixel in references.flat_map(|image| &image.data) {
        let l = luminance(*pixel);
        if l.is_finite() && l > BLACK {
            sum += l.ln();
            count += 1;
        }
    }
    if count == 0 {
        return Err(LabError::BlackReference);
    }
    Ok(KEY / (sum / count as f64).exp())
}

/// An image in the values that metrics take.
pub struct Exposed {
    /// Radiance times exposure.
    pub linear: Image,
    /// c / (1 + luminance) of that (Reinhard et al. 2002, equation 3), sRGB-encoded.
    pub display: Image,
}

impl Exposed {
    /// Exposes and tone maps.
    pub fn new(radiance: &Image, exposure: f64) -> Exposed {
        let exposed = |p: &[f32; 3]| p.map(|v| (f64::from(v) * exposure) as f32);
        let linear = Image {
            data: radiance.data.iter().map(exposed).collect(),
            ..*radiance
        };
        let curve = |p: &[f32; 3]| {
            let below_white = 1.0 / (1.0 + luminance(*p).max(0.0));
            p.map(|v| (f64::from(v) * below_white) as f32)
        };
        let mapped = Image {
            data: linear.data.iter().map(curve).collect(),
            ..linear
        };
        Exposed {
            display: mapped.to_display(),
            linear,
        }
    }

    /// Every metric of one frame.
    ///
    /// # Errors
    /// Values that are not finite; images that a metric cannot take.
    pub fn metrics(
        &self,
        reference: &Exposed,
        measures: &[Measure],
    ) -> Result<BTreeMap<String, f64>, MetricsError> {
        let mut values = BTreeMap::new();
        let metrics = measures.iter().filter_map(|measure| match measure {
            Measure::Frame(metric) => Some(*metric),
            Measure::Flicker => None,
        });
        for metric in metrics {
            values.insert(metric.name().to_owned(), self.metric(reference, metric)?);
        }
        Ok(values)
    }

    /// The error of each pixel by a metric.
    ///
    /// # Errors
    /// Those of [`error_map`].
    pub fn map(&self, reference: &Exposed, metric: Metric) -> Result<ErrorMap, MetricsError> {
        match metric.space() {
            Space::Linear => error_map(metric, &self.linear, &reference.linear),
            Space::Display => error_map(metric, &self.display, &reference.display),
        }
    }

    fn metric(&self, reference: &Exposed, metric: Metric) -> Result<f64, MetricsError> {
        match metric.space() {
            Space::Linear => metric.evaluate(&self.linear, &reference.linear),
            Space::Display => metric.evaluate(&self.display, &reference.display),
        }
    }
}

/// Where each pixel's surface was in the frame before.
pub struct Guide {
    /// uv_now - uv_previous in channels 0 and 1.
    pub motion: Image,
    /// The pixels whose surface was visible in the frame before.
    pub valid: Mask,
}

impl Guide {
    /// From the G-buffer without jitter. A surface was visible if what was seen at its place, in the nearest
    /// pixel, is as far away as it was then, within 5 %: what covers a surface in a frame is nearer by more.
    pub fn new(motion: Image, past_view_z: &Image, previous_view_z: &Image) -> Guide {
        let [width, height] = motion.size();
        let seen = |i: usize| {
            let (x, y) = (i % width as usize, i / width as usize);
            let [u, v, _] = motion.data[i];
            let at = |p: usize, m: f32, n: u32| p as f32 + 0.5 - m * n as f32;
            let (x, y) = (at(x, u, width), at(y, v, height));
            let inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
            let then = inside.then(|| previous_view_z.get(x as u32, y as u32));
            let past = past_view_z.data[i][0];
            then.flatten()
                .is_some_and(|[z, ..]| past > 0.0 && (z - past).abs() <= 0.05 * past)
        };
        let valid = Mask {
            width,
            height,
            data: (0..motion.data.len()).map(seen).collect(),
        };
        Guide { motion, valid }
    }
}

/// Measures how much a sequence changes along its motion: the mean over pixels and frames of
/// |L_t(p) - L_(t-1)(p - motion)| in display luminance, over pixels whose surface was visible in both frames.
/// With a still camera and scene it is the mean change from frame to frame, all of which is error. Otherwise it
/// also has what the true image changes along its motion, such as highlights that stay behind, and what
/// bilinear reading of the frame before blurs: both are the same for all pipelines, but a blurred image
/// has less of the latter.
#[derive(Default)]
pub struct Flickering {
    meter: MotionFlickerMeter,
    black: Option<Image>,
}

impl Flickering {
    /// Takes the next frame, in display values.
    ///
    /// # Errors
    /// As [`MotionFlickerMeter::push`].
    pub fn push(&mut self, display: &Image, guide: Option<&Guide>) -> Result<(), MetricsError> {
        let [width, height] = display.size();
        let black = || Image::from_fn(width, height, |_, _| [0.0; 3]);
        self.meter.push(MovingFrame {
            image: display,
            reference: self.black.get_or_insert_with(black),
            motion: guide.map(|guide| &guide.motion),
            valid: guide.map(|guide| &guide.valid),
        })
    }

    /// The flicker of all frames.
    ///
    /// # Errors
    /// Fewer than two frames, or no pixel that was visible in two.
    pub fn finish(&self) -> Result<f64, MetricsError> {
        Ok(self.meter.finish()?.difference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_takes_the_geometric_mean_to_the_key() {
        let images = [[0.02f32; 3], [2.0; 3], [0.0; 3]].map(|v| Image::from_fn(4, 4, |_, _| v));
        // sqrt(0.02 * 2) = 0.2; black does not count.
        let exposure = exposure(images.iter()).unwrap();
        assert!((exposure - 0.9).abs() < 1e-6);
        let exposed = Exposed::new(&Image::from_fn(1, 1, |_, _| [0.2; 3]), exposure);
        assert!((exposed.linear.data[0][0] - 0.18).abs() < 1e-6);
        // sRGB of 0.18 / 1.18.
        let encoded = 1.055 * (0.18f64 / 1.18).powf(1.0 / 2.4) - 0.055;
        assert!((f64::from(exposed.display.data[0][1]) - encoded).abs() < 1e-6);
        assert!(matches!(
            super::exposure(images[2..].iter()),
            Err(LabError::BlackReference)
        ));
    }

    #[test]
    fn flicker_of_a_still_camera_is_the_mean_change() {
        let mut flicker = Flickering::default();
        for t in 0..5 {
            let value = 0.5 + 0.25 * (t % 2) as f32;
            let frame = Image::from_fn(8, 4, |_, _| [value; 3]);
            flicker.push(&frame, None).unwrap();
        }
        assert!((flicker.finish().unwrap() - 0.25).abs() < 1e-9);
    }

    /// A step in depth that moves one pixel to the right: what it uncovers was not visible, what it covers is gone.
    #[test]
    fn what_was_hidden_does_not_count() {
        let depth = |edge: u32| move |x: u32, _| [if x < edge { 1.0 } else { 5.0 }; 3];
        let before = Image::from_fn(8, 2, depth(3));
        let moved = Image::from_fn(8, 2, |x, _| [if x < 4 { 1.0 / 8.0 } else { 0.0 }, 0.0, 0.0]);
        let past = Image::from_fn(8, 2, depth(4));
        let guide = Guide::new(moved, &past, &before);
        // The first column comes from outside; all others were seen.
        let expected: Vec<bool> = (0..16).map(|i| i % 8 != 0).collect();
        assert_eq!(guide.valid.data, expected);
        // The same backwards uncovers column 3.
        let moved = Image::from_fn(8, 2, |x, _| {
            [if x < 3 { -1.0 / 8.0 } else { 0.0 }, 0.0, 0.0]
        });
        let guide = Guide::new(moved, &Image::from_fn(8, 2, depth(3)), &past);
        let expected: Vec<bool> = (0..16).map(|i| i % 8 != 3).collect();
        assert_eq!(guide.valid.data, expected);
    }
}
