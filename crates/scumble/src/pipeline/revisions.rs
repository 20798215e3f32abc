//! When an average over frames must start anew, for each pass.

use crate::camera::Camera;
use crate::frame_input::FrameInput;
use crate::pass_frame::Upstream;

/// What every pass has upstream, besides passes.
#[derive(Clone, PartialEq)]
struct Given {
    camera: Camera,
    scene_revision: u64,
    time: f32,
    size: [u32; 2],
}

/// The revision of what is upstream of each pass.
pub(super) struct Revisions {
    given: Option<Given>,
    counter: u64,
    passes: Vec<Upstream>,
    /// For each pass, which passes its results reach, itself left out.
    reach: Vec<Vec<usize>>,
}

impl Revisions {
    /// `readers[p]` lists the passes that read pass `p`, also those that read its previous frame.
    pub fn new(readers: &[Vec<usize>]) -> Revisions {
        let reach = (0..readers.len())
            .map(|pass| reached(readers, pass))
            .collect();
        let passes = vec![
            Upstream {
                revision: 1,
                changed: None
            };
            readers.len()
        ];
        Revisions {
            given: None,
            counter: 1,
            passes,
            reach,
        }
    }

    /// Goes on with another graph, in which pass `p` is what `before[p]` was in this one, or new.
    pub fn follow(&mut self, readers: &[Vec<usize>], before: &[Option<usize>]) {
        self.counter += 1;
        let new = Upstream {
            revision: self.counter,
            changed: None,
        };
        let known = |p: &Option<usize>| p.and_then(|p| self.passes.get(p)).cloned();
        let passes = before.iter().map(|p| known(p).unwrap_or(new.clone()));
        self.passes = passes.collect();
        self.reach = (0..readers.len())
            .map(|pass| reached(readers, pass))
            .collect();
    }

    pub fn of(&self, pass: usize) -> &Upstream {
        &self.passes[pass]
    }

    /// Compares a frame with the one before.
    pub fn begin_frame(&mut self, input: &FrameInput, size: [u32; 2]) {
        let now = Given {
            camera: input.camera,
            scene_revision: input.scene_revision,
            time: input.time,
            size,
        };
        if let Some(before) = self.given.replace(now.clone()) {
            let mut changes = Vec::new();
            if before.camera != now.camera {
                changes.push("camera moved".to_owned());
            }
            if before.scene_revision != now.scene_revision {
                changes.push("scene changed".to_owned());
            }
            if before.time != now.time {
                changes.push(format!("time: {} s -> {} s", before.time, now.time));
            }
            if before.size != now.size {
                let ([w, h], [to_w, to_h]) = (before.size, now.size);
                changes.push(format!("size: {w}x{h} -> {to_w}x{to_h}"));
            }
            if input.cut {
                changes.push("cut".to_owned());
            }
            if !changes.is_empty() {
                self.change(0..self.passes.len(), &changes.join(", "));
            }
        }
    }

    /// Something about a pass changed that its own results depend on.
    pub fn pass_changed(&mut self, pass: usize, what: &str) {
        let reach = std::mem::take(&mut self.reach[pass]);
        self.change(reach.iter().copied(), what);
        self.reach[pass] = reach;
    }

    /// Something that `readers` read changed.
    pub fn source_changed(&mut self, readers: &[usize], what: &str) {
        let mut all = readers.to_vec();
        all.extend(readers.iter().flat_map(|&pass| self.reach[pass].clone()));
        self.change(all.into_iter(), what);
    }

    fn change(&mut self, passes: impl Iterator<Item = usize>, what: &str) {
        self.counter += 1;
        for pass in passes {
            let upstream = &mut self.passes[pass];
            upstream.revision = self.counter;
            upstream.changed = Some(what.to_owned());
        }
    }
}

fn reached(readers: &[Vec<usize>], pass: usize) -> Vec<usize> {
    let mut seen = vec![false; readers.len()];
    let mut open = readers[pass].clone();
    while let Some(next) = open.pop() {
        if !std::mem::replace(&mut seen[next], true) {
            open.extend(&readers[next]);
        }
    }
    seen[pass] = false;
    (0..readers.len()).filter(|&p| seen[p]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // 0 -> 1 -> 2, and 2 is read by 1 in the next frame.
    fn chain() -> Revisions {
        Revisions::new(&[vec![1], vec![2], vec![1]])
    }

    #[test]
    fn a_parameter_reaches_what_is_downstream_and_not_its_own_pass() {
        let mut r = chain();
        r.pass_changed(0, "a.x: 1 -> 2");
        assert_eq!(
            r.of(0),
            &Upstream {
                revision: 1,
                changed: None
            }
        );
        assert_eq!(r.of(1).changed.as_deref(), Some("a.x: 1 -> 2"));
        let before = r.of(2).clone();
        assert_eq!(before.revision, r.of(1).revision);
        r.pass_changed(2, "c.y: 1 -> 2");
        assert_eq!(
            r.of(2),
            &before,
            "a pass is not upstream of itself, even through its own past"
        );
        assert_ne!(
            r.of(1).revision,
            before.revision,
            "the past of 2 is upstream of 1"
        );
    }

    #[test]
    fn only_what_an_average_may_not_mix_counts() {
        let mut r = chain();
        let still = FrameInput::default();
        r.begin_frame(&still, [8, 8]);
        let at = |r: &Revisions| r.of(2).revision;
        let before = at(&r);
        let jitter = Some(glam::Vec2::new(0.25, 0.0));
        let moved_before = Camera::look_at([1.0, 0.0, 0.0], [0.0; 3], 50.0);
        let same = FrameInput {
            frame: 9,
            seed: 9,
            jitter,
            dt: 1.0,
            previous_camera: moved_before,
            ..still.clone()
        };
        r.begin_frame(&same, [8, 8]);
        assert_eq!(at(&r), before);
        for (input, size, what) in [
            (
                FrameInput {
                    camera: moved_before,
                    ..still.clone()
                },
                [8, 8],
                "camera moved",
            ),
            (
                FrameInput {
                    scene_revision: 1,
                    ..still.clone()
                },
                [8, 8],
                "scene changed",
            ),
            (
                FrameInput {
                    time: 0.5,
                    ..still.clone()
                },
                [8, 8],
                "time: 0 s -> 0.5 s",
            ),
            (still.clone(), [8, 9], "size: 8x8 -> 8x9"),
            (
                FrameInput {
                    cut: true,
                    ..still.clone()
                },
                [8, 8],
                "cut",
            ),
        ] {
            let mut r = chain();
            r.begin_frame(&still, [8, 8]);
            r.begin_frame(&input, size);
            assert_ne!(at(&r), before, "{what}");
            assert_eq!(r.of(2).changed.as_deref(), Some(what));
        }
    }
}
