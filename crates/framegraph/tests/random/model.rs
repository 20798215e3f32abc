//! What a program means: its nodes one after the other, on the CPU, each resource with memory of its own;
//! nothing is dropped, reordered, shared or reused.

use crate::check::needed;
use crate::frame::{Frame, Job, Node, Resource, Role, Shape, writer};
use crate::kernels::{LOOKERS, WRITERS, fragment, hash, is_odd, look, write};
use crate::program::Program;
use crate::resolve::{imports, reset_of, resolve};

/// The words of each (mip, layer), mip-major, of each resource.
pub type Contents = Vec<Vec<Vec<u32>>>;

/// What a frame of a history holds.
type Past = Vec<Vec<u32>>;

/// What the histories hold between frames.
#[derive(Default)]
pub struct Rings(Vec<Option<Ring>>);

struct Ring {
    shape: Shape,
    frames: u32,
    /// Newest first.
    past: Vec<Past>,
}

impl Rings {
    /// How many past frames a history has for this shape and number of frames.
    pub fn kept(&self, history: usize, shape: Shape, frames: u32) -> u32 {
        match self.0.get(history) {
            Some(Some(r)) if r.shape == shape && r.frames == frames => r.past.len() as u32,
            _ => 0,
        }
    }

    fn reset(&mut self, history: usize) {
        if let Some(Some(ring)) = self.0.get_mut(history) {
            ring.past.clear();
        }
    }

    fn past(&self, history: usize, age: u32) -> &Past {
        match &self.0[history] {
            Some(ring) => &ring.past[age as usize - 1],
            None => unreachable!("only kept frames are asked for"),
        }
    }

    /// A history takes this frame's contents where all of them were kept from culling; else it stays.
    fn advance(&mut self, frame: &Frame, contents: &Contents) {
        let touched = frame.touched();
        let live = needed(frame, &touched);
        self.0
            .resize_with(frame.histories.len().max(self.0.len()), || None);
        for (i, h) in frame.histories.iter().enumerate() {
            let shape = frame.resources[h.current].shape;
            if self.kept(i, shape, h.frames) == 0 {
                self.0[i] = Some(Ring {
                    shape,
                    frames: h.frames,
                    past: Vec::new(),
                });
            }
            let kept = frame
                .all_places(h.current)
                .iter()
                .all(|&place| writer(&touched, touched.len(), place).is_some_and(|n| live[n]));
            if let (true, Some(ring)) = (kept, &mut self.0[i]) {
                ring.past.insert(0, contents[h.current].clone());
                ring.past.truncate(h.frames as usize);
            }
        }
    }
}

/// What can be seen of a program from outside.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Of each frame, name and contents of each export.
    pub exports: Vec<Vec<(String, Past)>>,
    /// What the lookers left, in the order of declaration.
    pub observed: Vec<u32>,
    /// The imports after the last frame.
    pub imports: Vec<Past>,
}

/// What an import holds before the first frame.
pub fn imported(import: usize, shape: Shape) -> Past {
    let [mips, layers] = shape.extent();
    (0..mips * layers)
        .map(|sub| {
            let [w, h] = shape.mip_size(sub / layers);
            let seed = 1000 * import as u32 + 100 * sub;
            (0..w * h).map(|n| hash(seed + n)).collect()
        })
        .collect()
}

/// All frames of a program as they are declared, and what they mean.
pub fn interpret(program: &Program) -> (Vec<Frame>, Outcome) {
    let mut rings = Rings::default();
    let mut outcome = Outcome::default();
    let shapes = imports(program);
    outcome.imports = shapes
        .iter()
        .enumerate()
        .map(|(i, &shape)| imported(i, shape))
        .collect();
    let mut frames = Vec::new();
    for number in 0..program.frames.len() {
        if let Some(h) = reset_of(program, number) {
            rings.reset(h);
        }
        let frame = resolve(program, number, &rings, outcome.observed.len() as u32);
        let mut contents: Contents = frame
            .resources
            .iter()
            .map(|r| initial(r, &rings, &outcome.imports))
            .collect();
        for node in &frame.nodes {
            run(&frame, node, &mut contents, &mut outcome.observed);
        }
        for (r, words) in frame.resources.iter().zip(&contents) {
            if let Role::Import(i) = r.role {
                outcome.imports[i].clone_from(words);
            }
        }
        let exported = |&i: &usize| (frame.resources[i].name.clone(), contents[i].clone());
        outcome
            .exports
            .push(frame.exports.iter().map(exported).collect());
        rings.advance(&frame, &contents);
        frames.push(frame);
    }
    (frames, outcome)
}

fn initial(r: &Resource, rings: &Rings, imports: &[Past]) -> Past {
    match r.role {
        Role::Import(i) => imports[i].clone(),
        Role::Previous {
            history,
            age,
            kept: true,
        } => rings.past(history, age).clone(),
        // Undefined; `resolve` lets nobody read it.
        _ => {
            let [mips, layers] = r.shape.extent();
            let words = |mip| r.shape.mip_size(mip).iter().product::<u32>() as usize;
            (0..mips * layers)
                .map(|sub| vec![0; words(sub / layers)])
                .collect()
        }
    }
}

/// The bytes that an upload has.
pub fn uploaded(seed: u32, words: u32) -> Vec<u32> {
    (0..words).map(|n| hash(seed ^ n)).collect()
}

fn run(frame: &Frame, node: &Node, contents: &mut Contents, observed: &mut Vec<u32>) {
    if node.is_off() {
        // Its place stays as the buffer was made.
        observed.extend(matches!(node.job, Job::Looker(..)).then_some(0));
        return;
    }
    let seed = node.seed;
    // The only, or the first and second, (mip, layer) touched.
    let at = |i: usize| {
        let u = &node.uses[i];
        (u.resource, frame.subresources(u)[0])
    };
    match node.job {
        Job::Writer(row) => write(frame, contents, node, &WRITERS[row], seed),
        Job::Looker(row, place) => {
            assert_eq!(place as usize, observed.len());
            observed.push(look(frame, contents, node, LOOKERS[row].inputs.len(), seed));
        }
        Job::Arguments => {
            for (i, word) in contents[at(0).0][0].iter_mut().enumerate() {
                let h = hash(seed.wrapping_add(i as u32));
                *word = match i {
                    0 => h % 5,
                    1 | 2 => 1,
                    _ => h,
                };
            }
        }
        Job::Indirect => {
            let count = contents[at(1).0][0][0] as usize;
            for (i, word) in contents[at(0).0][0].iter_mut().enumerate().take(count) {
                *word = hash(seed ^ i as u32);
            }
        }
        Job::Raster { clear, part } => {
            let (target, (sub, [w, h])) = at(1);
            for n in 0..w * h {
                let p = [n % w, n / w];
                let value = fragment(frame, contents, node, seed, p);
                let texel = &mut contents[target][sub][n as usize];
                if let Some(clear) = clear {
                    *texel = clear;
                }
                if !part || is_odd(seed, p) {
                    *texel = value;
                }
            }
        }
        Job::Clear(value) | Job::Fill(value) => {
            for (sub, _) in frame.subresources(&node.uses[0]) {
                contents[at(0).0][sub].fill(value);
            }
        }
        Job::CopyTexture | Job::CopyBuffer => {
            for (sub, _) in frame.subresources(&node.uses[0]) {
                contents[at(1).0][sub] = contents[at(0).0][sub].clone();
            }
        }
        Job::Upload => {
            let words = &mut contents[at(0).0][0];
            *words = uploaded(seed, words.len() as u32);
        }
        Job::ForeignTexture { whole } => {
            let ((from, (a, _)), (to, (b, _))) = (at(0), at(1));
            match whole {
                true => contents[to][b] = contents[from][a].clone(),
                false => contents[to][b][0] = contents[from][a][0],
            }
        }
        Job::ForeignBuffer => contents[at(1).0][0][0] = contents[at(0).0][0][0],
    }
}
