//! What stands in for the outputs of a node that may be off.

use framegraph::{Mode, State};

use super::Resolver;
use crate::frame::{Job, Node, Resource, Role, Shape, StandIn, Use};
use crate::kernels::hash;

impl Resolver {
    /// What stands in for the outputs of the op's node while it is off. What has nothing has contents only while the
    /// switch is on; so that is for transients alone.
    pub(super) fn stand_ins(&mut self, uses: &[Use]) -> Vec<(usize, StandIn)> {
        let Some((k, pick)) = self.switch else {
            for u in uses.iter().filter(|u| u.mode == Mode::Overwrite) {
                for (sub, _) in self.frame.subresources(u) {
                    self.bare[u.resource][sub] = None;
                }
            }
            return Vec::new();
        };
        let mut stand_ins = Vec::new();
        for (i, u) in uses.iter().enumerate() {
            if u.mode != Mode::Overwrite {
                continue;
            }
            let Resource { shape, role, .. } = self.frame.resources[u.resource];
            let none = role == Role::Transient && (pick >> i) % 4 == 0;
            for (sub, _) in self.frame.subresources(u) {
                self.bare[u.resource][sub] = none.then_some(k);
            }
            if none {
                continue;
            }
            // What stands in runs when the others of its switch do not.
            let switch = self.switch.take();
            let like = |s: Shape| Vec::from_iter((s == shape).then_some(u.range));
            let from = self.choose(pick, uses, Mode::Read, State::CopySource, like);
            self.switch = switch;
            let value = match pick % 3 {
                0 => 0,
                _ => hash(pick.into()),
            };
            let what = match (from, shape) {
                (Some(from), _) if pick % 2 == 0 => StandIn::Use(from.resource),
                (_, Shape::Texture { .. }) => StandIn::Clear(value),
                (_, Shape::Buffer { .. }) => StandIn::Fill(value),
            };
            stand_ins.push((i, what));
        }
        stand_ins
    }

    /// The node that runs while another is off. What it writes it modifies, because it stays while that is on.
    pub(super) fn stand_in(&self, of: usize, i: usize) -> Node {
        let node = &self.frame.nodes[of];
        let (output, what) = node.stand_ins[i];
        let output = |state| Use {
            mode: Mode::Modify,
            state,
            ..node.uses[output].clone()
        };
        let (job, uses) = match what {
            StandIn::Clear(value) => (Job::Clear(value), vec![output(State::ColorTarget)]),
            StandIn::Fill(word) => (Job::Fill(word), vec![output(State::CopyTarget)]),
            StandIn::Use(resource) => {
                let to = output(State::CopyTarget);
                let from = Use {
                    resource,
                    mode: Mode::Read,
                    state: State::CopySource,
                    ..to.clone()
                };
                let job = match self.frame.resources[resource].shape {
                    Shape::Texture { .. } => Job::CopyTexture,
                    Shape::Buffer { .. } => Job::CopyBuffer,
                };
                (job, vec![from, to])
            }
        };
        Node {
            job,
            uses,
            implicit: true,
            switch: node.switch.map(|on| !on),
            stand_ins: Vec::new(),
            ..node.clone()
        }
    }
}
