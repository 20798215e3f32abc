//! A frame of a program as concrete nodes: every pick is made among what is legal at that point, and an
//! op for which nothing is legal is left out. So programs stay legal while they shrink.

use framegraph::{Mode, State, Subresources};

use crate::frame::{
    Frame, History, Job, Node, Resource, Role, Shape, Use, blocks, buffers, mips, overlap, singles,
    textures, uniforms,
};
use crate::kernels::{In, LOOKERS, Out, Signature, WRITERS, hash, input_state, output_state};
use crate::model::Rings;
use crate::program::{FrameSpec, Op, Origin, Program, Rule, SizeSpec, What};

mod switch;

struct Resolver {
    frame: Frame,
    /// Of each resource, whether each (mip, layer) has contents.
    defined: Vec<Vec<bool>>,
    /// And the switch without which it has none.
    bare: Vec<Vec<Option<u8>>>,
    /// The switch of the op, and what chooses what stands in.
    switch: Option<(u8, u16)>,
    /// Which switches are on.
    on: u8,
    /// Buffers that hold arguments of an indirect dispatch.
    arguments: Vec<bool>,
    observed: u32,
    /// The transients in reach.
    reach: std::ops::Range<usize>,
}

/// Frame `number` of the program, given what its histories hold; lookers count on from `observed`.
pub fn resolve(program: &Program, number: usize, rings: &Rings, observed: u32) -> Frame {
    let FrameSpec {
        size, script, on, ..
    } = program.frames[number];
    let script = &program.scripts[script % program.scripts.len()];
    let mut r = Resolver {
        frame: Frame {
            number: number as u64,
            size,
            reset: None,
            resources: Vec::new(),
            histories: Vec::new(),
            sources: 0,
            nodes: Vec::new(),
            exports: Vec::new(),
        },
        defined: Vec::new(),
        bare: Vec::new(),
        switch: None,
        on,
        arguments: Vec::new(),
        observed,
        reach: 0..usize::MAX,
    };
    r.declare(program, rings);
    r.frame.reset = reset_of(program, number).map(|h| r.frame.histories[h].key.clone());
    for (i, op) in script.ops.iter().enumerate() {
        r.slide(script.window, i, script.ops.len());
        r.op(op);
        r.switch = None;
    }
    r.finish_histories(script.unwritten);
    r.frame.exports = (0..r.frame.resources.len())
        .filter(|&i| script.exports >> (i % 32) & 1 == 1)
        .filter(|&i| r.is_defined(i, r.frame.resources[i].shape.whole()))
        .collect();
    r.frame
}

/// The history that is reset before a frame.
pub fn reset_of(program: &Program, number: usize) -> Option<usize> {
    let count = specs(program)
        .filter(|s| matches!(s.0, Origin::History { .. }))
        .count();
    program.frames[number].reset?.checked_rem(count)
}

/// Origin and shape (for a frame of some size) of all that the program declares.
fn specs(program: &Program) -> impl Iterator<Item = (Origin, Option<SizeSpec>, [u32; 3])> {
    let textures = program
        .textures
        .iter()
        .map(|t| (t.origin, Some(t.size), [t.mips, t.layers, 0]));
    let buffers = program
        .buffers
        .iter()
        .map(|b| (b.origin, None, [0, 0, b.words]));
    textures.chain(buffers)
}

/// The shapes of the program's imports.
pub fn imports(program: &Program) -> Vec<Shape> {
    specs(program)
        .filter(|s| matches!(s.0, Origin::Import))
        .map(|s| shape(s, [4, 4]))
        .collect()
}

fn shape(
    (origin, size, [mips, layers, words]): (Origin, Option<SizeSpec>, [u32; 3]),
    frame: [u32; 2],
) -> Shape {
    let Some(size) = size else {
        return Shape::Buffer { words };
    };
    let size = match (size, origin) {
        (SizeSpec::Absolute(size), _) => size,
        // An import does not change with the frame.
        (_, Origin::Import) => [4, 3],
        (SizeSpec::Frame, _) => frame,
        (SizeSpec::Half, _) => frame.map(|x| x.div_ceil(2)),
    };
    let levels = 32 - size[0].max(size[1]).leading_zeros();
    Shape::Texture {
        size,
        mips: mips.min(levels),
        layers,
    }
}

impl Resolver {
    fn add(&mut self, name: String, shape: Shape, role: Role) -> usize {
        let [mips, layers] = shape.extent();
        let defined = matches!(role, Role::Import(_) | Role::Previous { kept: true, .. });
        self.frame.resources.push(Resource { name, shape, role });
        self.defined.push(vec![defined; (mips * layers) as usize]);
        self.bare.push(vec![None; (mips * layers) as usize]);
        self.arguments.push(false);
        self.frame.resources.len() - 1
    }

    /// Resources, and the nodes that stand in for missing frames of histories.
    fn declare(&mut self, program: &Program, rings: &Rings) {
        let mut sources = Vec::new();
        let mut import = 0;
        for (i, spec) in specs(program).enumerate() {
            let shape = shape(spec, self.frame.size);
            match spec.0 {
                Origin::Transient => {
                    self.add(format!("t{i}"), shape, Role::Transient);
                }
                Origin::Import => {
                    self.add(format!("i{i}"), shape, Role::Import(import));
                    import += 1;
                }
                Origin::History {
                    first: Rule::Copy,
                    value,
                    ..
                } => {
                    let source = self.add(format!("s{i}"), shape, Role::Transient);
                    sources.push(source);
                    self.constant(source, value);
                }
                Origin::History { .. } => {}
            }
        }
        self.frame.sources = self.frame.nodes.len();
        let mut sources = sources.into_iter();
        for (i, spec) in specs(program).enumerate() {
            let Origin::History {
                frames,
                first,
                value,
            } = spec.0
            else {
                continue;
            };
            let shape = shape(spec, self.frame.size);
            let history = self.frame.histories.len();
            let source = (first == Rule::Copy).then(|| sources.next()).flatten();
            let current = self.add(format!("h{i}"), shape, Role::Current(history));
            let kept = rings.kept(history, shape, frames);
            let previous = (1..=frames)
                .map(|age| {
                    self.previous(i, history, age, age <= kept, (first, value, source), shape)
                })
                .collect();
            self.frame.histories.push(History {
                key: format!("h{i}"),
                current,
                previous,
                frames,
                first,
                value,
                source,
            });
        }
    }

    fn previous(
        &mut self,
        spec: usize,
        history: usize,
        age: u32,
        kept: bool,
        (first, value, source): (Rule, u32, Option<usize>),
        shape: Shape,
    ) -> Option<usize> {
        if !kept && first == Rule::Skip {
            return None;
        }
        let name = format!("h{spec}@-{age}");
        let role = Role::Previous { history, age, kept };
        let resource = self.add(name.clone(), shape, role);
        if !kept {
            match source {
                Some(from) => self.copy(from, resource),
                None => self.constant(resource, value),
            }
            if let Some(node) = self.frame.nodes.last_mut() {
                node.name = format!("first {name}");
                node.implicit = true;
            }
        }
        Some(resource)
    }

    fn whole(&self, resource: usize, mode: Mode, state: State) -> Use {
        Use {
            resource,
            range: self.frame.resources[resource].shape.whole(),
            mode,
            state,
        }
    }

    fn node(&mut self, job: Job, uses: Vec<Use>) {
        for u in uses.iter().filter(|u| u.writes()) {
            for (sub, _) in self.frame.subresources(u) {
                self.defined[u.resource][sub] = true;
            }
            self.arguments[u.resource] = job == Job::Arguments;
        }
        let n = self.frame.nodes.len();
        let stand_ins = self.stand_ins(&uses);
        self.frame.nodes.push(Node {
            name: format!("n{n}"),
            job,
            // Other data in each frame, also where the plan is the same.
            seed: hash(n as u32 + 1000 * self.frame.number as u32),
            uses,
            implicit: false,
            switch: self.switch.map(|(k, _)| self.on >> k & 1 == 1),
            stand_ins,
        });
        for i in 0..self.frame.nodes[n].stand_ins.len() {
            let node = self.stand_in(n, i);
            self.frame.nodes.push(node);
        }
    }

    fn constant(&mut self, resource: usize, value: u32) {
        match self.frame.resources[resource].shape {
            Shape::Texture { .. } => {
                let u = self.whole(resource, Mode::Overwrite, State::ColorTarget);
                self.node(Job::Clear(value), vec![u]);
            }
            Shape::Buffer { .. } => {
                let u = self.whole(resource, Mode::Overwrite, State::CopyTarget);
                self.node(Job::Fill(value), vec![u]);
            }
        }
    }

    fn copy(&mut self, from: usize, to: usize) {
        let job = match self.frame.resources[from].shape {
            Shape::Texture { .. } => Job::CopyTexture,
            Shape::Buffer { .. } => Job::CopyBuffer,
        };
        let from = self.whole(from, Mode::Read, State::CopySource);
        let to = self.whole(to, Mode::Overwrite, State::CopyTarget);
        self.node(job, vec![from, to]);
    }

    fn is_defined(&self, resource: usize, range: Subresources) -> bool {
        let u = Use {
            resource,
            range,
            mode: Mode::Read,
            state: State::Undefined,
        };
        let switch = self.switch.map(|(k, _)| k);
        self.frame.subresources(&u).iter().all(|&(sub, _)| {
            let bare = self.bare[resource][sub];
            self.defined[resource][sub] && (bare.is_none() || bare == switch)
        })
    }

    /// All ranges that `ranges` gives for the resources, of which `pick` chooses one that may be touched so
    /// beside what the node touches already.
    fn choose(
        &self,
        pick: u16,
        uses: &[Use],
        mode: Mode,
        state: State,
        ranges: impl Fn(Shape) -> Vec<Subresources>,
    ) -> Option<Use> {
        let mut found = Vec::new();
        let mut transients = 0;
        for (resource, r) in self.frame.resources.iter().enumerate() {
            if r.role == Role::Transient {
                transients += 1;
                if !self.reach.contains(&(transients - 1)) {
                    continue;
                }
            }
            if mode != Mode::Read && matches!(r.role, Role::Previous { .. }) {
                continue;
            }
            for range in ranges(r.shape) {
                let clash = uses.iter().any(|u| {
                    u.resource == resource
                        && overlap(&u.range, &range)
                        && (u.writes() || mode != Mode::Read)
                });
                if !clash && (mode == Mode::Overwrite || self.is_defined(resource, range)) {
                    found.push(Use {
                        resource,
                        range,
                        mode,
                        state,
                    });
                }
            }
        }
        (!found.is_empty()).then(|| found[pick as usize % found.len()].clone())
    }

    fn input(&self, input: In, pick: u16, uses: &[Use]) -> Option<Use> {
        self.choose(pick, uses, Mode::Read, input_state(input), ranges(input))
    }

    /// Whether what a node reads could be this input too.
    fn fits(&self, input: In, u: &Use) -> bool {
        ranges(input)(self.frame.resources[u.resource].shape).contains(&u.range)
    }

    fn output(&self, output: Out, pick: u16, uses: &[Use]) -> Option<Use> {
        let (mode, ranges): (Mode, fn(Shape) -> Vec<Subresources>) = match output {
            Out::Texture => (Mode::Overwrite, singles),
            Out::TexturePart | Out::TextureUpdate => (Mode::Modify, singles),
            Out::Layers => (Mode::Overwrite, mips),
            Out::Buffer => (Mode::Overwrite, buffers),
            Out::BufferPart | Out::BufferUpdate => (Mode::Modify, buffers),
        };
        self.choose(pick, uses, mode, output_state(output), ranges)
    }

    fn signature(&self, s: &Signature, picks: &[u16]) -> Option<Vec<Use>> {
        let mut uses = Vec::new();
        let mut picks = picks.iter().copied().cycle();
        for &input in s.inputs {
            let pick = picks.next()?;
            let chosen = self.input(input, pick, &uses)?;
            // Now and then what the node reads already, perhaps in another way.
            let again = uses.iter().find(|u| self.fits(input, u));
            uses.push(match again {
                Some(u) if pick % 4 == 0 => Use {
                    state: chosen.state,
                    ..u.clone()
                },
                _ => chosen,
            });
        }
        for &output in s.outputs {
            uses.push(self.output(output, picks.next()?, &uses)?);
        }
        Some(uses)
    }

    /// Puts the transients in reach of op `i` of `count`.
    fn slide(&mut self, window: usize, i: usize, count: usize) {
        let is_transient = |r: &Resource| r.role == Role::Transient;
        let transients = self
            .frame
            .resources
            .iter()
            .filter(|r| is_transient(r))
            .count();
        let start = i * (transients + 1).saturating_sub(window) / count;
        if window > 0 {
            self.reach = start..start + window;
        }
    }

    /// Declares the op, unless nothing is legal for it.
    fn op(
        &mut self,
        Op {
            what,
            picks,
            switch,
        }: &Op,
    ) -> Option<()> {
        let [a, b, c, ..] = *picks;
        // Copies and the like have no switch, and of arguments nobody knows what stands in for them.
        let switched = [
            What::Kernel,
            What::Look,
            What::Indirect,
            What::Raster,
            What::Foreign,
        ];
        self.switch = switch.filter(|_| switched.contains(what));
        let value = u32::from(a) << 16 | u32::from(b);
        match what {
            What::Kernel => {
                let row = a as usize % WRITERS.len();
                let uses = self.signature(&WRITERS[row], &picks[1..])?;
                self.node(Job::Writer(row), uses);
            }
            What::Look => {
                let row = a as usize % LOOKERS.len();
                let uses = self.signature(&LOOKERS[row], &picks[1..])?;
                self.node(Job::Looker(row, self.observed), uses);
                self.observed += 1;
            }
            What::Arguments => {
                let u = self.output(Out::Buffer, a, &[])?;
                self.node(Job::Arguments, vec![u]);
            }
            What::Indirect => {
                let held = (0..self.arguments.len()).filter(|&i| self.arguments[i]);
                let held: Vec<usize> = held.collect();
                let from = *held.get(b as usize % held.len().max(1))?;
                let arguments = self.whole(from, Mode::Read, State::Indirect);
                let out = self.output(Out::BufferPart, a, std::slice::from_ref(&arguments))?;
                self.node(Job::Indirect, vec![out, arguments]);
            }
            What::Raster => {
                let (clear, part) = ((c % 2 == 0).then_some(value), c / 2 % 2 == 0);
                let mode = if clear.is_some() {
                    Mode::Overwrite
                } else {
                    Mode::Modify
                };
                let input = self.input(In::Texture, a, &[])?;
                let uses = std::slice::from_ref(&input);
                let target = self.choose(b, uses, mode, State::ColorTarget, singles)?;
                self.node(Job::Raster { clear, part }, vec![input, target]);
            }
            What::Clear => {
                let u = self.choose(c, &[], Mode::Overwrite, State::ColorTarget, textures)?;
                self.node(Job::Clear(value), vec![u]);
            }
            What::CopyTexture | What::CopyBuffer => {
                let ranges = if *what == What::CopyBuffer {
                    buffers
                } else {
                    textures
                };
                let from = self.choose(a, &[], Mode::Read, State::CopySource, ranges)?;
                let shape = self.frame.resources[from.resource].shape;
                let same = |s: Shape| {
                    if s == shape {
                        vec![s.whole()]
                    } else {
                        Vec::new()
                    }
                };
                let uses = std::slice::from_ref(&from);
                let to = self.choose(b, uses, Mode::Overwrite, State::CopyTarget, same)?;
                self.copy(from.resource, to.resource);
            }
            What::Fill => {
                let u = self.choose(c, &[], Mode::Overwrite, State::CopyTarget, buffers)?;
                // Zero is another command than the rest.
                self.node(Job::Fill(if a % 2 == 0 { 0 } else { value }), vec![u]);
            }
            What::Upload => {
                let u = self.choose(c, &[], Mode::Overwrite, State::CopyTarget, buffers)?;
                self.node(Job::Upload, vec![u]);
            }
            What::Foreign => self.foreign(a, b, c)?,
        }
        Some(())
    }

    fn foreign(&mut self, a: u16, b: u16, c: u16) -> Option<()> {
        if c.is_multiple_of(4) {
            let from = self.choose(a, &[], Mode::Read, State::Foreign, buffers)?;
            let uses = std::slice::from_ref(&from);
            let to = self.choose(b, uses, Mode::Modify, State::Foreign, buffers)?;
            self.node(Job::ForeignBuffer, vec![from, to]);
            return Some(());
        }
        let whole = c.is_multiple_of(2);
        let mode = if whole { Mode::Overwrite } else { Mode::Modify };
        let from = self.choose(a, &[], Mode::Read, State::Foreign, singles)?;
        let size = self.frame.resources[from.resource]
            .shape
            .mip_size(from.range.mip);
        let same = |s: Shape| {
            let mut ranges = singles(s);
            ranges.retain(|r| !whole || s.mip_size(r.mip) == size);
            ranges
        };
        let to = self.choose(b, std::slice::from_ref(&from), mode, State::Foreign, same)?;
        self.node(Job::ForeignTexture { whole }, vec![from, to]);
        Some(())
    }

    /// A history is written wholly or not at all.
    fn finish_histories(&mut self, unwritten: u32) {
        for h in 0..self.frame.histories.len() {
            let current = self.frame.histories[h].current;
            let shape = self.frame.resources[current].shape;
            let some = self.defined[current].iter().any(|&d| d);
            if !some && unwritten >> h & 1 == 1 {
                continue;
            }
            let (ranges, job, output) = match shape {
                Shape::Texture { .. } => (singles(shape), 0, Out::Texture),
                Shape::Buffer { .. } => (buffers(shape), 14, Out::Buffer),
            };
            for range in ranges {
                if !self.is_defined(current, range) {
                    let u = Use {
                        resource: current,
                        range,
                        mode: Mode::Overwrite,
                        state: output_state(output),
                    };
                    self.node(Job::Writer(job), vec![u]);
                }
            }
        }
    }
}

/// What an input may be of a resource.
fn ranges(input: In) -> fn(Shape) -> Vec<Subresources> {
    match input {
        In::Texture | In::Storage => singles,
        In::Layers => blocks,
        In::Buffer => buffers,
        In::Uniform => uniforms,
    }
}
