//! Histories: resources kept across frames by key, with a rule for frames that do not exist.

use std::collections::BTreeMap;
use std::fmt;

use super::{FrameGraph, Kind, Word, Work, here};
use crate::desc::{First, FirstBuffer, HistoryBuffer, HistoryTexture, Previous, TextureDesc};
use crate::error::{Code, GraphError, Site};
use crate::handle::{Buffer, Label, Raw, Texture};

/// What a resource is, as far as memory is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shape {
    /// `depth` is 0 for two-dimensional textures.
    Texture {
        format: wgpu::TextureFormat,
        size: [u32; 2],
        depth: u32,
        mips: u32,
        layers: u32,
    },
    Buffer {
        bytes: u64,
    },
}

impl Shape {
    /// What is asked for in a frame of this size, be it possible or not.
    #[inline(always)]
    pub fn asked(desc: TextureDesc, frame: [u32; 2]) -> Shape {
        Shape::Texture {
            format: desc.format,
            size: desc.size.resolve(frame),
            depth: 0,
            mips: desc.mips,
            layers: desc.layers,
        }
    }

    /// Of a texture that exists.
    pub fn of(texture: &wgpu::Texture) -> Shape {
        let volume = texture.dimension() == wgpu::TextureDimension::D3;
        let slices = texture.depth_or_array_layers();
        Shape::Texture {
            format: texture.format(),
            size: [texture.width(), texture.height()],
            depth: if volume { slices } else { 0 },
            mips: texture.mip_level_count(),
            layers: if volume { 1 } else { slices },
        }
    }

    /// (mips, layers); a buffer is one of each.
    pub fn extent(&self) -> (u32, u32) {
        match self {
            Shape::Texture { mips, layers, .. } => (*mips, *layers),
            Shape::Buffer { .. } => (1, 1),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Texture {
                format,
                size: [w, h],
                mips,
                layers,
                ..
            } => {
                write!(f, "{w}x{h} {format:?}")?;
                match (mips, layers) {
                    (1, 1) => Ok(()),
                    _ => write!(f, " {mips} mips {layers} layers"),
                }
            }
            Shape::Buffer { bytes } => write!(f, "{bytes} bytes"),
        }
    }
}

/// Why a history has no older frames than it has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reset {
    /// It did not exist before.
    FirstFrame,
    /// Its size, format or number of frames changed.
    Resized {
        /// What it was.
        from: String,
        /// What it is.
        to: String,
    },
    /// [`Pool::reset_history`](crate::Pool::reset_history) or
    /// [`FrameGraph::reset_history`](crate::FrameGraph::reset_history) was called.
    Asked(String),
}

impl fmt::Display for Reset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reset::FirstFrame => f.write_str("first frame"),
            Reset::Resized { from, to } => write!(f, "resized: {from} to {to}"),
            Reset::Asked(reason) => write!(f, "asked: {reason}"),
        }
    }
}

/// What is known of a history between frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryInfo {
    /// How many past frames hold contents.
    pub frames: u32,
    /// Number of the first frame after the last reset.
    pub since: u64,
    /// Number of the last frame that wrote it.
    pub written: u64,
    /// Why it was last reset.
    pub reset: Reset,
    /// The numbers of the past frames that hold contents, youngest first: `previous[i]` is of frame
    /// `numbers[i]`. Where they are not consecutive, frames between did not write it.
    pub numbers: Vec<u64>,
    /// The last resets that a frame obeyed, oldest first, at most eight: the number of the frame, and why.
    pub resets: Vec<(u64, Reset)>,
}

impl HistoryInfo {
    const RESETS: usize = 8;

    /// Before any frame.
    pub(crate) fn new(frame: u64) -> Self {
        HistoryInfo {
            frames: 0,
            since: frame,
            written: frame,
            reset: Reset::FirstFrame,
            numbers: Vec::new(),
            resets: Vec::new(),
        }
    }

    /// A frame that found only so many past frames, because of a reset or not.
    pub(crate) fn begin(&mut self, frame: u64, kept: u32, reset: Option<Reset>) {
        self.frames = kept;
        self.numbers.truncate(kept as usize);
        if let Some(reset) = reset {
            self.since = frame;
            self.reset = reset.clone();
            if self.resets.len() == Self::RESETS {
                self.resets.remove(0);
            }
            self.resets.push((frame, reset));
        }
    }

    /// The frame wrote it; of the past, at most `most` frames are kept.
    pub(crate) fn write(&mut self, frame: u64, most: u32) {
        self.written = frame;
        self.numbers.insert(0, frame);
        self.numbers.truncate(most as usize);
        self.frames = self.numbers.len() as u32;
    }
}

#[derive(Clone, Debug)]
pub(crate) struct RingState {
    pub shape: Shape,
    pub frames: u32,
    pub info: HistoryInfo,
    /// The ring slot that the next frame writes.
    pub head: u32,
    /// A reset that the next frame must obey.
    pub pending: Option<Reset>,
    /// The names of the past frames, youngest first.
    pub ages: Vec<Label>,
}

/// The name of a past frame of a history.
pub(crate) fn age_label(key: &Label, age: u32) -> Label {
    Label::from(format!("{key}@-{age}"))
}

/// What a pool knows of its histories.
pub(crate) type HistoryStates = BTreeMap<Label, RingState>;

/// A history as one frame declares it.
pub(crate) struct HistoryUse {
    pub key: Label,
    pub shape: Shape,
    pub frames: u32,
    pub current: u32,
    /// How many past frames hold contents, and why not more if this frame resets it.
    pub kept: u32,
    pub reset: Option<Reset>,
    pub head: u32,
    /// Some previous frame is missing and its readers were skipped: nobody can yet tell that it is unread.
    pub skipped: bool,
    pub site: Site,
}

enum Fill {
    Clear([f64; 4]),
    Word(u32),
    Skip,
    Copy(Raw),
}

impl FrameGraph<'_> {
    /// A texture of which the last `frames` frames are kept under `key`. Write `current` wholly; read
    /// `previous`. `first` stands in for frames that do not exist: on the first frame, after a change of
    /// `desc`, size or `frames`, and after [`Pool::reset_history`](crate::Pool::reset_history).
    ///
    /// A frame that does not write `current` leaves the history as it is. What writes `current` is
    /// kept from culling when anything that is needed reads `previous`; where it is not kept, or only a
    /// part of it for other reasons, the frame counts as one that does not write.
    #[track_caller]
    pub fn history_texture(
        &mut self,
        key: impl Into<Label>,
        desc: TextureDesc,
        frames: u32,
        first: First,
    ) -> HistoryTexture {
        let (site, key) = (here(), key.into());
        let shape = self.shape(&key, desc, site);
        let fill = match first {
            First::Clear(value) => Fill::Clear(value),
            First::Skip => Fill::Skip,
            First::Copy(texture) => Fill::Copy(texture.0),
        };
        let usage = desc.extra_usage.bits();
        let (current, previous) = self.history(key, (shape, usage), frames, fill, Texture, site);
        HistoryTexture {
            current: Texture(current),
            previous,
        }
    }

    /// The same for a buffer of `bytes` bytes.
    #[track_caller]
    pub fn history_buffer(
        &mut self,
        key: impl Into<Label>,
        bytes: u64,
        frames: u32,
        first: FirstBuffer,
    ) -> HistoryBuffer {
        let (site, key) = (here(), key.into());
        let shape = self.buffer_shape(&key, bytes, site);
        let fill = match first {
            FirstBuffer::Fill(word) => Fill::Word(word),
            FirstBuffer::Skip => Fill::Skip,
            FirstBuffer::Copy(buffer) => Fill::Copy(buffer.0),
        };
        let (current, previous) = self.history(key, (shape, 0), frames, fill, Buffer, site);
        HistoryBuffer {
            current: Buffer(current),
            previous,
        }
    }

    /// Makes this frame find no past frames of a history that it declares afterwards, so that its rule for
    /// the first frame applies. The reason is kept. The next frame that declares it is meant when this one
    /// does not. Does nothing when there is no such history.
    #[track_caller]
    pub fn reset_history(&mut self, key: impl Into<Label>, reason: &str) {
        let (site, key) = (here(), key.into());
        if let Some(history) = self.histories.iter().find(|h| h.key == key) {
            let error = GraphError::new(
                Code::LateReset,
                format!("the history `{key}` is reset after it was declared"),
                site,
                "reset it first: its declaration decides which past frames there are",
            );
            let error = error.with("declared", history.site);
            self.errors.push(error);
            return;
        }
        self.resets.push((key, reason.to_owned()));
    }

    fn history<T>(
        &mut self,
        key: Label,
        (shape, usage): (Shape, u32),
        frames: u32,
        fill: Fill,
        handle: fn(Raw) -> T,
        site: Site,
    ) -> (Raw, Previous<T>) {
        if let Some(first) = self.histories.iter().find(|h| h.key == key) {
            let error = GraphError::new(
                Code::DuplicateKey,
                format!("the history `{key}` is declared twice"),
                site,
                "declare it once and pass the handles on",
            );
            let error = error.with("first declared", first.site);
            self.errors.push(error);
            let poison = (0..frames).map(|_| Some(handle(Raw::POISON)));
            return (Raw::POISON, poison.collect());
        }
        let (kept, head, reset) = match self.states.get(&key) {
            None => (0, 0, Some(Reset::FirstFrame)),
            Some(s) if s.shape != shape => (
                0,
                0,
                Some(Reset::Resized {
                    from: s.shape.to_string(),
                    to: shape.to_string(),
                }),
            ),
            Some(s) if s.frames != frames => {
                let text = |n: u32| format!("{n} frames");
                (
                    0,
                    0,
                    Some(Reset::Resized {
                        from: text(s.frames),
                        to: text(frames),
                    }),
                )
            }
            Some(RingState {
                pending: Some(reason),
                head,
                ..
            }) => (0, *head, Some(reason.clone())),
            Some(s) => match self.resets.iter().find(|(k, _)| *k == key) {
                Some((_, reason)) => (0, s.head, Some(Reset::Asked(reason.clone()))),
                None => (s.info.frames, s.head, None),
            },
        };
        let history = self.histories.len() as u32;
        let skipped = matches!(fill, Fill::Skip) && kept < frames;
        let how = u64::from(skipped) << 32 | u64::from(frames);
        self.note(Word::History, how, None);
        let current = self.add(key.clone(), Kind::Current(history), shape, usage, site);
        self.histories.push(HistoryUse {
            key: key.clone(),
            shape,
            frames,
            current: current.resource,
            kept,
            reset,
            head,
            skipped,
            site,
        });
        let states = self.states.clone();
        let previous = (1..=frames)
            .map(|age| {
                let has = age <= kept;
                if !has && matches!(fill, Fill::Skip) {
                    return None;
                }
                let label = match states.get(&key).and_then(|s| s.ages.get(age as usize - 1)) {
                    Some(label) => label.clone(),
                    None => age_label(&key, age),
                };
                let raw = self.add(
                    label.clone(),
                    Kind::Previous {
                        history,
                        age,
                        kept: has,
                    },
                    shape,
                    usage,
                    site,
                );
                Some(handle(match has {
                    true => raw,
                    false => self.fill_first(&label, raw, &fill, site),
                }))
            })
            .collect();
        (current, previous)
    }

    /// Declares the node that gives a missing frame its contents.
    fn fill_first(&mut self, label: &Label, raw: Raw, fill: &Fill, site: Site) -> Raw {
        let name = Label::from(format!("first {label}"));
        match *fill {
            Fill::Clear(value) => self.clear_at(name, Texture(raw), value, site).0,
            Fill::Word(word) => self.fill_at(name, Buffer(raw), word, site).0,
            Fill::Copy(from)
                if matches!(
                    self.resources[raw.resource as usize].shape,
                    Shape::Texture { .. }
                ) =>
            {
                self.copy_texture_at(name, Texture(from), Texture(raw), site)
                    .0
            }
            Fill::Copy(from) => self.copy_buffer_at(name, Buffer(from), Buffer(raw), site).0,
            Fill::Skip => raw,
        }
    }

    /// Whether a node was declared without its last call.
    pub(crate) fn check_finished(&mut self) {
        for i in 0..self.nodes.len() {
            if matches!(self.nodes[i].work, Work::None) {
                let (label, site) = (self.nodes[i].label.clone(), self.nodes[i].site);
                self.fail(
                    Code::Unfinished,
                    format!("`{label}` was declared and given no work"),
                    site,
                    "end it with dispatch, dispatch_texels, dispatch_indirect, draw or record",
                );
            }
        }
    }
}
