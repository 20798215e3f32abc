//! What the caller says about resources and the frame.

use std::array;
use std::iter::{Chain, Take};

use crate::handle::{Buffer, Texture};

/// What a frame is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameParams {
    /// Width and height in texels that [`Size::Frame`] stands for.
    pub size: [u32; 2],
    /// The frame's number; the graph only repeats it in [`HistoryInfo`](crate::HistoryInfo) and in the plan.
    pub frame: u64,
}

/// Width and height of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Size {
    /// In texels.
    Absolute([u32; 2]),
    /// As the frame.
    Frame,
    /// One texel for each n x n pixels of the frame: ceil(frame / n).
    PerTexels(u32),
}

impl Size {
    /// The size in texels for a frame of size `frame`.
    pub fn resolve(self, frame: [u32; 2]) -> [u32; 2] {
        match self {
            Size::Absolute(size) => size,
            Size::Frame => frame,
            Size::PerTexels(n) => frame.map(|x| if n == 0 { 0 } else { x.div_ceil(n) }),
        }
    }
}

/// A two-dimensional texture. Its usage is inferred from what the graph does with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureDesc {
    /// Texel format.
    pub format: wgpu::TextureFormat,
    /// Width and height.
    pub size: Size,
    /// Number of mip levels, at least 1.
    pub mips: u32,
    /// Number of array layers, at least 1.
    pub layers: u32,
    /// Usage beyond what is inferred.
    pub extra_usage: wgpu::TextureUsages,
}

impl TextureDesc {
    /// One mip, one layer.
    pub fn d2(format: wgpu::TextureFormat, size: Size) -> Self {
        TextureDesc {
            format,
            size,
            mips: 1,
            layers: 1,
            extra_usage: wgpu::TextureUsages::empty(),
        }
    }

    /// The same with `mips` mip levels.
    pub fn with_mips(self, mips: u32) -> Self {
        TextureDesc { mips, ..self }
    }

    /// The same with `layers` array layers.
    pub fn with_layers(self, layers: u32) -> Self {
        TextureDesc { layers, ..self }
    }

    /// The same with more usage than is inferred.
    pub fn with_usage(self, extra_usage: wgpu::TextureUsages) -> Self {
        TextureDesc {
            extra_usage,
            ..self
        }
    }
}

/// What stands for a frame of a texture's history that does not exist: on the first frame, after a resize, after a reset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum First {
    /// Every texel has this value.
    Clear([f64; 4]),
    /// There is none: `previous` is `None`, and the caller declares no reader.
    Skip,
    /// A copy of this texture of the same format and size.
    Copy(Texture),
}

/// What stands for a frame of a buffer's history that does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstBuffer {
    /// Every 32-bit word has this value.
    Fill(u32),
    /// There is none: `previous` is `None`, and the caller declares no reader.
    Skip,
    /// A copy of this buffer of the same size.
    Copy(Buffer),
}

/// A texture that is kept across frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryTexture {
    /// This frame's, not yet written.
    pub current: Texture,
    /// `previous[0]` is of one frame ago; `None` only with [`First::Skip`].
    pub previous: Previous<Texture>,
}

/// A buffer that is kept across frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryBuffer {
    /// This frame's, not yet written.
    pub current: Buffer,
    /// `previous[0]` is of one frame ago; `None` only with [`FirstBuffer::Skip`].
    pub previous: Previous<Buffer>,
}

/// How many past frames a [`Previous`] holds without memory of its own.
const FEW: usize = 4;

/// The handles of the past frames of a history, youngest first: a slice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Previous<T> {
    few: [Option<T>; FEW],
    count: usize,
    /// All of them, where they are more than a few.
    many: Vec<Option<T>>,
}

impl<T> FromIterator<Option<T>> for Previous<T> {
    fn from_iter<I: IntoIterator<Item = Option<T>>>(handles: I) -> Self {
        let mut previous = Previous {
            few: std::array::from_fn(|_| None),
            count: 0,
            many: Vec::new(),
        };
        for handle in handles {
            match previous.count {
                n if n < FEW => previous.few[n] = handle,
                n => {
                    if n == FEW {
                        previous
                            .many
                            .extend(previous.few.iter_mut().map(Option::take));
                    }
                    previous.many.push(handle);
                }
            }
            previous.count += 1;
        }
        previous
    }
}

impl<T> IntoIterator for Previous<T> {
    type Item = Option<T>;
    type IntoIter = Chain<Take<array::IntoIter<Option<T>, FEW>>, std::vec::IntoIter<Option<T>>>;

    fn into_iter(self) -> Self::IntoIter {
        let few = if self.count <= FEW { self.count } else { 0 };
        self.few.into_iter().take(few).chain(self.many)
    }
}

impl<T: PartialEq, const N: usize> PartialEq<[Option<T>; N]> for Previous<T> {
    fn eq(&self, other: &[Option<T>; N]) -> bool {
        **self == *other
    }
}

impl<T> std::ops::Deref for Previous<T> {
    type Target = [Option<T>];
    fn deref(&self) -> &[Option<T>] {
        match self.count {
            n if n <= FEW => &self.few[..n],
            _ => &self.many,
        }
    }
}

impl<T> std::ops::DerefMut for Previous<T> {
    fn deref_mut(&mut self) -> &mut [Option<T>] {
        match self.count {
            n if n <= FEW => &mut self.few[..n],
            _ => &mut self.many,
        }
    }
}

/// What an attachment holds when its raster node begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<T = wgpu::Color> {
    /// This value in every texel; what was there is not needed.
    Clear(T),
    /// What was there.
    Load,
}
