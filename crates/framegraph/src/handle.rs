//! Handles: what a graph gives out for a resource, and sub-ranges of textures.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Range;
use std::sync::Arc;

/// A name. Anything that needs a name takes `impl Into<Label>`: a literal, which costs nothing, or a
/// `String`, which is moved to shared memory; an engine that declares the same nodes each frame keeps
/// that label and passes `&label`, which costs a count.
#[derive(Clone)]
pub struct Label(Text);

#[derive(Clone)]
enum Text {
    Fixed(&'static str),
    Shared(Arc<str>),
}

impl Label {
    /// The text.
    pub fn as_str(&self) -> &str {
        match &self.0 {
            Text::Fixed(text) => text,
            Text::Shared(text) => text,
        }
    }
}

impl Default for Label {
    fn default() -> Self {
        Label(Text::Fixed(""))
    }
}

impl PartialEq for Label {
    fn eq(&self, other: &Self) -> bool {
        self.as_str() == other.as_str()
    }
}

impl Eq for Label {}

impl PartialOrd for Label {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Label {
    fn cmp(&self, other: &Self) -> Ordering {
        self.as_str().cmp(other.as_str())
    }
}

impl Hash for Label {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.as_str().hash(state);
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl std::ops::Deref for Label {
    type Target = str;
    fn deref(&self) -> &str {
        self.as_str()
    }
}

impl std::borrow::Borrow<str> for Label {
    fn borrow(&self) -> &str {
        self.as_str()
    }
}

impl From<&'static str> for Label {
    fn from(text: &'static str) -> Self {
        Label(Text::Fixed(text))
    }
}

impl From<String> for Label {
    fn from(text: String) -> Self {
        Label(Text::Shared(text.into()))
    }
}

impl From<&String> for Label {
    fn from(text: &String) -> Self {
        Label(Text::Shared(text.as_str().into()))
    }
}

impl From<Arc<str>> for Label {
    fn from(text: Arc<str>) -> Self {
        Label(Text::Shared(text))
    }
}

impl From<&Label> for Label {
    fn from(label: &Label) -> Self {
        label.clone()
    }
}

impl PartialEq<str> for Label {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for Label {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}

/// What both kinds of handle are: (graph, resource, version).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Raw {
    pub brand: u32,
    pub resource: u32,
    pub version: u32,
}

impl Raw {
    /// Stands for the result of a call that was an error already: its uses are not reported again.
    pub const POISON: Raw = Raw {
        brand: 0,
        resource: u32::MAX,
        version: 0,
    };
}

/// One version of a texture of one frame graph.
///
/// A write returns the next version; the older handle is stale from then on.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Texture(pub(crate) Raw);

/// One version of a buffer of one frame graph.
///
/// A write returns the next version; the older handle is stale from then on.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Buffer(pub(crate) Raw);

impl Texture {
    /// Only mip level `mip`.
    pub fn mip(self, mip: u32) -> View {
        View::from(self).mip(mip)
    }

    /// Only array layer `layer`.
    pub fn layer(self, layer: u32) -> View {
        View::from(self).layer(layer)
    }
}

/// A range of mip levels and array layers of a [`Texture`]; hazards are tracked per (mip, layer).
///
/// Made from a texture (all of it) and narrowed: `texture.mip(2).layer(0)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct View {
    pub(crate) texture: Texture,
    mips: Option<Range<u32>>,
    layers: Option<Range<u32>>,
}

impl From<Texture> for View {
    fn from(texture: Texture) -> Self {
        View {
            texture,
            mips: None,
            layers: None,
        }
    }
}

impl View {
    /// Only mip level `mip`.
    pub fn mip(self, mip: u32) -> Self {
        self.mips(mip..mip + 1)
    }

    /// Only the mip levels of the range.
    pub fn mips(mut self, mips: Range<u32>) -> Self {
        self.mips = Some(mips);
        self
    }

    /// Only array layer `layer`.
    pub fn layer(self, layer: u32) -> Self {
        self.layers(layer..layer + 1)
    }

    /// Only the array layers of the range.
    pub fn layers(mut self, layers: Range<u32>) -> Self {
        self.layers = Some(layers);
        self
    }

    /// Whether it is not narrowed.
    #[inline(always)]
    pub(crate) fn is_whole(&self) -> bool {
        self.mips.is_none() && self.layers.is_none()
    }

    /// The range in a texture of so many mips and layers; `None` when it lies outside or is empty.
    #[inline]
    pub(crate) fn resolve(&self, mips: u32, layers: u32) -> Option<Subresources> {
        let inside = |range: &Option<Range<u32>>, count: u32| match range {
            None => Some((0, count)),
            Some(r) if r.start < r.end && r.end <= count => Some((r.start, r.end - r.start)),
            Some(_) => None,
        };
        let (mip, mip_count) = inside(&self.mips, mips)?;
        let (layer, layer_count) = inside(&self.layers, layers)?;
        Some(Subresources {
            mip,
            mips: mip_count,
            layer,
            layers: layer_count,
        })
    }
}

/// A rectangle of (mip, layer) pairs. A buffer is the one pair (0, 0).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Subresources {
    /// First mip level.
    pub mip: u32,
    /// Number of mip levels.
    pub mips: u32,
    /// First array layer.
    pub layer: u32,
    /// Number of array layers.
    pub layers: u32,
}

impl Subresources {
    pub(crate) const ONE: Subresources = Subresources {
        mip: 0,
        mips: 1,
        layer: 0,
        layers: 1,
    };

    #[inline]
    pub(crate) fn overlaps(&self, other: &Subresources) -> bool {
        self.mip < other.mip + other.mips
            && other.mip < self.mip + self.mips
            && self.layer < other.layer + other.layers
            && other.layer < self.layer + self.layers
    }

    /// All of it in one word; no two ranges share one.
    pub(crate) fn bits(self) -> u64 {
        (self.mip as u64) << 48
            | (self.mips as u64) << 40
            | (self.layer as u64) << 20
            | self.layers as u64
    }
}
