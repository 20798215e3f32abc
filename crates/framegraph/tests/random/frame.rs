//! One frame, concretely: resources, nodes with what each touches, histories, exports. Both the graph and
//! the model are made from this, and the checker reads it.

use framegraph::{Mode, State, Subresources};

use crate::program::Rule;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Texture {
        size: [u32; 2],
        mips: u32,
        layers: u32,
    },
    Buffer {
        words: u32,
    },
}

impl Shape {
    /// Of a buffer.
    pub fn words(self) -> Option<u32> {
        match self {
            Shape::Buffer { words } => Some(words),
            Shape::Texture { .. } => None,
        }
    }

    pub fn extent(self) -> [u32; 2] {
        match self {
            Shape::Buffer { .. } => [1, 1],
            Shape::Texture { mips, layers, .. } => [mips, layers],
        }
    }

    pub fn whole(self) -> Subresources {
        let [mips, layers] = self.extent();
        Subresources {
            mip: 0,
            mips,
            layer: 0,
            layers,
        }
    }

    /// Width and height of a mip; a buffer is one row of words.
    pub fn mip_size(self, mip: u32) -> [u32; 2] {
        match self {
            Shape::Buffer { words } => [words, 1],
            Shape::Texture { size, .. } => size.map(|x| (x >> mip).max(1)),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Transient,
    /// Which import of the program.
    Import(usize),
    /// Which history of the frame.
    Current(usize),
    Previous {
        history: usize,
        age: u32,
        kept: bool,
    },
}

#[derive(Clone, Debug)]
pub struct Resource {
    pub name: String,
    pub shape: Shape,
    pub role: Role,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Use {
    pub resource: usize,
    pub range: Subresources,
    pub mode: Mode,
    pub state: State,
}

impl Use {
    pub fn reads(&self) -> bool {
        self.mode != Mode::Overwrite
    }

    pub fn writes(&self) -> bool {
        self.mode != Mode::Read
    }
}

/// Whether two ranges have a (mip, layer) in common.
pub fn overlap(a: &Subresources, b: &Subresources) -> bool {
    let meet = |a: u32, n: u32, b: u32, m: u32| a < b + m && b < a + n;
    meet(a.mip, a.mips, b.mip, b.mips) && meet(a.layer, a.layers, b.layer, b.layers)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// Row of the table of writers.
    Writer(usize),
    /// Row of the table of lookers, and its place among all that are observed.
    Looker(usize, u32),
    Arguments,
    Indirect,
    Raster {
        clear: Option<u32>,
        part: bool,
    },
    Clear(u32),
    CopyTexture,
    CopyBuffer,
    Fill(u32),
    Upload,
    /// A copy of one (mip, layer), or of one texel of it.
    ForeignTexture {
        whole: bool,
    },
    ForeignBuffer,
}

#[derive(Clone, Debug)]
pub struct Node {
    pub name: String,
    pub job: Job,
    pub seed: u32,
    pub uses: Vec<Use>,
    /// Declared by the graph: for a history's missing frame, or to stand in for a node that is off.
    pub implicit: bool,
    /// Whether it is on in this frame; `None` where it always is.
    pub switch: Option<bool>,
    /// What stands in while it is off: for each output that has something, which use it is.
    pub stand_ins: Vec<(usize, StandIn)>,
}

impl Node {
    pub fn is_off(&self) -> bool {
        self.switch == Some(false)
    }
}

/// What an output holds while its node is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandIn {
    Clear(u32),
    Fill(u32),
    /// What another resource holds.
    Use(usize),
}

#[derive(Clone, Debug)]
pub struct History {
    pub key: String,
    pub current: usize,
    pub previous: Vec<Option<usize>>,
    pub frames: u32,
    pub first: Rule,
    pub value: u32,
    /// What the rule copies.
    pub source: Option<usize>,
}

/// One frame, concretely.
#[derive(Clone, Debug)]
pub struct Frame {
    pub number: u64,
    pub size: [u32; 2],
    /// Key of the history that is reset before.
    pub reset: Option<String>,
    pub resources: Vec<Resource>,
    pub histories: Vec<History>,
    /// Nodes that come before the histories are declared.
    pub sources: usize,
    pub nodes: Vec<Node>,
    pub exports: Vec<usize>,
}

impl Frame {
    /// Index and size of each (mip, layer) that a use touches, mip-major.
    pub fn subresources(&self, u: &Use) -> Vec<(usize, [u32; 2])> {
        let shape = self.resources[u.resource].shape;
        let [_, layers] = shape.extent();
        let r = u.range;
        (r.mip..r.mip + r.mips)
            .flat_map(|m| {
                (r.layer..r.layer + r.layers)
                    .map(move |l| ((m * layers + l) as usize, shape.mip_size(m)))
            })
            .collect()
    }

    /// The (mip, layer) pairs that each node touches, as numbers that tell all of the frame apart.
    pub fn touched(&self) -> Vec<Touched> {
        let places = |node: &Node, which: fn(&Use) -> bool| {
            let uses = node.uses.iter().filter(|u| which(u));
            uses.flat_map(|u| self.places(u)).collect()
        };
        self.nodes
            .iter()
            .map(|node| Touched {
                reads: places(node, Use::reads),
                writes: places(node, Use::writes),
            })
            .collect()
    }

    /// The numbers of what a use touches.
    pub fn places(&self, u: &Use) -> Vec<usize> {
        let at = |(sub, _)| place(u.resource, sub);
        self.subresources(u).into_iter().map(at).collect()
    }

    /// The numbers of all of a resource.
    pub fn all_places(&self, resource: usize) -> Vec<usize> {
        let [mips, layers] = self.resources[resource].shape.extent();
        (0..(mips * layers) as usize)
            .map(|sub| place(resource, sub))
            .collect()
    }
}

/// No texture has 16 pairs of mip and layer.
fn place(resource: usize, sub: usize) -> usize {
    16 * resource + sub
}

#[derive(Debug)]
pub struct Touched {
    pub reads: Vec<usize>,
    pub writes: Vec<usize>,
}

/// The last of the nodes before `before` that writes a place.
pub fn writer(touched: &[Touched], before: usize, place: usize) -> Option<usize> {
    (0..before)
        .rev()
        .find(|&n| touched[n].writes.contains(&place))
}

/// Each mip and layer of a texture.
pub fn singles(shape: Shape) -> Vec<Subresources> {
    let [mips, layers] = shape.extent();
    let one = |mip, layer| Subresources {
        mip,
        mips: 1,
        layer,
        layers: 1,
    };
    match shape {
        Shape::Buffer { .. } => Vec::new(),
        Shape::Texture { .. } => (0..mips)
            .flat_map(|m| (0..layers).map(move |l| one(m, l)))
            .collect(),
    }
}

/// Each mip of a texture, all layers.
pub fn mips(shape: Shape) -> Vec<Subresources> {
    match shape {
        Shape::Buffer { .. } => Vec::new(),
        Shape::Texture { mips, .. } => (0..mips)
            .map(|mip| Subresources {
                mip,
                mips: 1,
                ..shape.whole()
            })
            .collect(),
    }
}

/// All of a texture, each mip of it, and each layer.
pub fn blocks(shape: Shape) -> Vec<Subresources> {
    let layers = match shape {
        Shape::Buffer { .. } => 0,
        Shape::Texture { layers, .. } => layers,
    };
    let layers = (0..layers).map(|layer| Subresources {
        layer,
        layers: 1,
        ..shape.whole()
    });
    textures(shape)
        .into_iter()
        .chain(mips(shape))
        .chain(layers)
        .collect()
}

/// All of a texture.
pub fn textures(shape: Shape) -> Vec<Subresources> {
    match shape {
        Shape::Buffer { .. } => Vec::new(),
        Shape::Texture { .. } => vec![shape.whole()],
    }
}

/// All of a buffer.
pub fn buffers(shape: Shape) -> Vec<Subresources> {
    match shape {
        Shape::Buffer { .. } => vec![shape.whole()],
        Shape::Texture { .. } => Vec::new(),
    }
}

/// All of a buffer that is big enough for the kernels' uniform.
pub fn uniforms(shape: Shape) -> Vec<Subresources> {
    match shape.words() {
        Some(16) => vec![shape.whole()],
        _ => Vec::new(),
    }
}
