//! Random programs: what proptest makes and shrinks. Every value is legal; `resolve` gives it a meaning.

use proptest::prelude::*;

/// Where a resource comes from.
#[derive(Clone, Copy, Debug)]
pub enum Origin {
    Transient,
    Import,
    /// Frames back, the rule for frames that do not exist, and the value or seed that it takes.
    History {
        frames: u32,
        first: Rule,
        value: u32,
    },
}

/// [`framegraph::First`] and [`framegraph::FirstBuffer`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    Clear,
    Skip,
    Copy,
}

/// A texture of `R32Uint`.
#[derive(Clone, Copy, Debug)]
pub struct TextureSpec {
    pub origin: Origin,
    /// Absolute, or relative to the frame; an import is always absolute.
    pub size: SizeSpec,
    pub mips: u32,
    pub layers: u32,
}

#[derive(Clone, Copy, Debug)]
pub enum SizeSpec {
    Absolute([u32; 2]),
    Frame,
    Half,
}

#[derive(Clone, Copy, Debug)]
pub struct BufferSpec {
    pub origin: Origin,
    pub words: u32,
}

/// What a node does; `picks` chooses resources, ranges and values among those that are legal then.
#[derive(Clone, Copy, Debug)]
pub struct Op {
    pub what: What,
    pub picks: [u16; 6],
    /// Which switch of the program it hangs on, and what chooses what stands in while that is off.
    pub switch: Option<(u8, u16)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A kernel of the table that writes.
    Kernel,
    /// A kernel that only reads, with a side effect.
    Look,
    /// A dispatch whose size comes from a buffer.
    Indirect,
    /// Arguments for one.
    Arguments,
    Raster,
    Clear,
    CopyTexture,
    CopyBuffer,
    Fill,
    Upload,
    Foreign,
}

/// What one frame declares; frames that run the same script can share a plan.
#[derive(Clone, Debug)]
pub struct Script {
    pub ops: Vec<Op>,
    /// Bit i: resource i is exported where it is whole.
    pub exports: u32,
    /// Bit i: history i is not written unless an op does.
    pub unwritten: u32,
    /// How many transients an op can reach, with later ones in reach of later ops, so that lives are short;
    /// 0 is all.
    pub window: usize,
}

/// One frame: its size, its script, whether a history is reset before it, and which switches are on.
#[derive(Clone, Copy, Debug)]
pub struct FrameSpec {
    pub size: [u32; 2],
    pub script: usize,
    pub reset: Option<usize>,
    /// Bit i: switch i is on.
    pub on: u8,
}

#[derive(Clone, Debug)]
pub struct Program {
    pub textures: Vec<TextureSpec>,
    pub buffers: Vec<BufferSpec>,
    pub scripts: Vec<Script>,
    pub frames: Vec<FrameSpec>,
}

fn rule() -> impl Strategy<Value = Rule> {
    prop_oneof![Just(Rule::Clear), Just(Rule::Skip), Just(Rule::Copy)]
}

fn origin() -> impl Strategy<Value = Origin> {
    prop_oneof![
        5 => Just(Origin::Transient),
        2 => Just(Origin::Import),
        2 => (1..=3u32, rule(), any::<u32>())
            .prop_map(|(frames, first, value)| Origin::History { frames, first, value }),
    ]
}

fn size() -> impl Strategy<Value = SizeSpec> {
    prop_oneof![
        6 => Just(SizeSpec::Frame),
        1 => Just(SizeSpec::Half),
        2 => [1..=5u32, 1..=5u32].prop_map(SizeSpec::Absolute),
    ]
}

fn texture() -> impl Strategy<Value = TextureSpec> {
    let count = || prop_oneof![4 => Just(1u32), 1 => 2..=3u32];
    (origin(), size(), count(), count()).prop_map(|(origin, size, mips, layers)| TextureSpec {
        origin,
        size,
        mips,
        layers,
    })
}

fn buffer() -> impl Strategy<Value = BufferSpec> {
    let words = prop_oneof![Just(4u32), Just(7), Just(16)];
    (origin(), words).prop_map(|(origin, words)| BufferSpec { origin, words })
}

fn op() -> impl Strategy<Value = Op> {
    let what = prop_oneof![
        12 => Just(What::Kernel),
        2 => Just(What::Look),
        1 => Just(What::Indirect),
        1 => Just(What::Arguments),
        2 => Just(What::Raster),
        2 => Just(What::Clear),
        2 => Just(What::CopyTexture),
        2 => Just(What::CopyBuffer),
        1 => Just(What::Fill),
        1 => Just(What::Upload),
        2 => Just(What::Foreign),
    ];
    let switch = prop_oneof![5 => Just(None), 1 => (0..3u8, any::<u16>()).prop_map(Some)];
    (what, any::<[u16; 6]>(), switch).prop_map(|(what, picks, switch)| Op {
        what,
        picks,
        switch,
    })
}

fn script() -> impl Strategy<Value = Script> {
    // Mostly short, because a short failure is the one to read; some of 200.
    let length = prop_oneof![12 => 1..24usize, 5 => 24..80usize, 1 => 80..=200usize];
    let ops = length.prop_flat_map(|n| prop::collection::vec(op(), 1..=n));
    let window = prop_oneof![Just(0usize), 2..5usize];
    (ops, any::<[u32; 2]>(), any::<u32>(), window).prop_map(|(ops, exports, unwritten, window)| {
        Script {
            ops,
            // One in four.
            exports: exports[0] & exports[1],
            unwritten,
            window,
        }
    })
}

/// Programs of one to five frames of at most 200 nodes that were asked for.
pub fn program() -> impl Strategy<Value = Program> {
    let frame = (
        prop_oneof![3 => Just([4, 4]), 1 => [1..=6u32, 1..=6u32]],
        0..2usize,
        prop_oneof![6 => Just(None), 1 => (0..4usize).prop_map(Some)],
        0..8u8,
    );
    let frame = frame.prop_map(|(size, script, reset, on)| FrameSpec {
        size,
        script,
        reset,
        on,
    });
    (
        prop::collection::vec(texture(), 1..12),
        prop::collection::vec(buffer(), 1..8),
        prop::collection::vec(script(), 1..=2),
        prop::collection::vec(frame, 1..=5),
    )
        .prop_map(|(textures, buffers, scripts, frames)| Program {
            textures,
            buffers,
            scripts,
            frames,
        })
}
