//! A frame that is the last one again, but for what may differ from frame to frame, is repeated instead of declared.

use framegraph::{FrameParams, Pool, Repeat};

use crate::declare::{Handles, Outside, Real, copy_texel, copy_word, params};
use crate::frame::{Frame, Job, Node, Role};
use crate::model::uploaded;

/// The repeat of the last frame, where the next is the same; `Err` where the pool is wrong about what is possible.
pub fn again<'f>(
    pool: &Pool,
    frames: &[Frame],
    number: usize,
) -> Result<Option<Repeat<'f>>, String> {
    let frame = &frames[number];
    let last = number.checked_sub(1).map(|n| &frames[n]);
    let again = pool.repeat(FrameParams {
        size: frame.size,
        frame: frame.number,
    });
    let possible = last.is_some_and(|last| is_possible(frame, last));
    match (again, last) {
        (Ok(_), _) if !possible => Err("what is another graph is repeated".into()),
        (Err(why), _) if possible => Err(format!("it is not repeated: {why}")),
        (Ok(again), Some(last)) if is_same(frame, last) => Ok(Some(again)),
        _ => Ok(None),
    }
}

/// Whether the same calls would declare the same graph.
fn is_possible(frame: &Frame, last: &Frame) -> bool {
    let kept = |f: &Frame| -> Vec<Role> {
        let roles = f.resources.iter().map(|r| r.role);
        let kept = |r: &Role| matches!(r, Role::Previous { kept: true, .. });
        roles.filter(kept).collect()
    };
    frame.size == last.size && frame.reset.is_none() && kept(frame) == kept(last)
}

/// Whether the calls are the same, but for what a repeat can be told.
fn is_same(frame: &Frame, last: &Frame) -> bool {
    let same = |(a, b): (&Node, &Node)| {
        let job = match (a.job, b.job) {
            (Job::Looker(a, _), Job::Looker(b, _)) => a == b,
            (a, b) => a == b,
        };
        job && a.name == b.name
            && a.uses == b.uses
            && a.stand_ins == b.stand_ins
            && a.switch.is_some() == b.switch.is_some()
    };
    frame.nodes.len() == last.nodes.len()
        && frame.exports == last.exports
        && frame.nodes.iter().zip(&last.nodes).all(same)
}

/// Tells a repeat all that differs; `handles` are those of the frame that was declared.
pub fn tell(again: &mut Repeat<'_>, frame: &Frame, outside: &Outside<'_>, handles: &Handles) {
    for r in &frame.resources {
        let Role::Import(i) = r.role else { continue };
        match &outside.imports[i] {
            Real::Texture(texture) => again.import_texture(&r.name, texture),
            Real::Buffer(buffer) => again.import_buffer(&r.name, buffer),
        };
    }
    for node in frame.nodes.iter().filter(|n| !n.implicit) {
        let name = &node.name;
        let [from, to] = [0, 1].map(|i| node.uses.get(i));
        match (node.job, from, to) {
            (Job::Writer(_) | Job::Arguments | Job::Indirect, ..) => {
                again.uniform(name, "params", &params(node, 0));
            }
            (Job::Looker(_, place), ..) => {
                again.uniform(name, "params", &params(node, place));
                again.bind_group(name, 1, outside.observed);
            }
            (Job::Raster { part, .. }, ..) => {
                again.uniform(name, "params", &params(node, part.into()));
                again.draw(name, |pass| pass.draw(0..3, 0..1));
            }
            (Job::Upload, Some(to), _) => {
                let words = frame.resources[to.resource].shape.words().unwrap_or(0);
                again.upload(name, bytemuck::cast_slice(&uploaded(node.seed, words)));
            }
            (Job::ForeignTexture { whole }, Some(from), Some(to)) => {
                let size = frame.resources[to.resource].shape.mip_size(to.range.mip);
                let both = [from, to].map(|u| (handles[&u.resource].texture(), u.range));
                again.record(name, copy_texel(both, if whole { size } else { [1, 1] }));
            }
            (Job::ForeignBuffer, Some(from), Some(to)) => {
                let both = [from, to].map(|u| handles[&u.resource].buffer());
                again.record(name, copy_word(both));
            }
            _ => {}
        }
        if let Some(on) = node.switch {
            again.enabled_if(name, on);
        }
    }
}
