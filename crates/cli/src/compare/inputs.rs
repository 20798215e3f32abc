//! What is compared with what.

use crate::failure::Failure;
use scumble_metrics::Sequence;
use std::path::{Path, PathBuf};

pub enum Inputs {
    /// The two files as they were named.
    One,
    Series(Vec<Frame>),
}

pub struct Frame {
    pub number: u32,
    pub image: PathBuf,
    pub reference: PathBuf,
}

impl Inputs {
    /// What to know when one side is tone mapped and the other is not, which linear values do not
    /// show; the first frames stand for all.
    pub fn mixed(&self, image: &Path, reference: &Path) -> Option<String> {
        let (image, reference) = match self {
            Inputs::Series(frames) => {
                let first = frames.first()?;
                (first.image.as_path(), first.reference.as_path())
            }
            Inputs::One => (image, reference),
        };
        let is_display = |path: &Path| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        };
        let (display, linear) = match (is_display(image), is_display(reference)) {
            (true, false) => (image, reference),
            (false, true) => (reference, image),
            _ => return None,
        };
        Some(format!(
            "`{}` holds what is displayed (tone mapped, 8 bits), `{}` the light itself: unless nothing \
             was tone mapped, compare two .exr or two .png",
            display.display(),
            linear.display()
        ))
    }

    pub fn find(image: &Path, reference: &Path) -> Result<Inputs, Failure> {
        let Some(images) = Sequence::find(image)? else {
            return match Sequence::find(reference)? {
                None => Ok(Inputs::One),
                Some(_) => Err(Failure::SeriesForOne {
                    image: image.to_owned(),
                }),
            };
        };
        let Some(references) = Sequence::find(reference)? else {
            let frame = |(number, image)| Frame {
                number,
                image,
                reference: reference.to_owned(),
            };
            return Ok(Inputs::Series(
                images.frames.into_iter().map(frame).collect(),
            ));
        };
        let numbers = |s: &Sequence| s.frames.iter().map(|(n, _)| *n).collect::<Vec<_>>();
        let (of_images, of_references) = (numbers(&images), numbers(&references));
        if of_images != of_references {
            let only = |a: &[u32], b: &[u32]| a.iter().copied().find(|n| !b.contains(n));
            let (folder, number) = match only(&of_images, &of_references) {
                Some(number) => (reference, number),
                None => (image, only(&of_references, &of_images).unwrap_or_default()),
            };
            return Err(Failure::MissingFrame {
                folder: folder.to_owned(),
                number,
                images: of_images.len(),
                references: of_references.len(),
            });
        }
        let pairs = images.frames.into_iter().zip(references.frames);
        let frame = |((number, image), (_, reference))| Frame {
            number,
            image,
            reference,
        };
        Ok(Inputs::Series(pairs.map(frame).collect()))
    }
}
