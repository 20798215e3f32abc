//! A plan as JSON. `docs/plan-json.md` says what each member means.

use std::fmt::{Display, Write};

use super::snapshot::{Snapshot, UseInfo};
use crate::compile::Hazard;
use crate::plan::Transition;
use crate::state::Mode;

/// Writes JSON: values one after the other, commas where they belong.
#[derive(Default)]
struct Json {
    text: String,
    /// Whether the next value or key follows another one.
    follows: bool,
}

impl Json {
    fn comma(&mut self) {
        if std::mem::replace(&mut self.follows, true) {
            self.text.push(',');
        }
    }

    fn within(&mut self, ends: [char; 2], write: impl FnOnce(&mut Json)) {
        self.comma();
        self.text.push(ends[0]);
        self.follows = false;
        write(self);
        self.text.push(ends[1]);
        self.follows = true;
    }

    fn object(&mut self, write: impl FnOnce(&mut Json)) {
        self.within(['{', '}'], write);
    }

    fn array<T>(&mut self, items: impl IntoIterator<Item = T>, write: impl Fn(&mut Json, T)) {
        self.within(['[', ']'], |json| {
            for item in items {
                write(json, item);
            }
        });
    }

    fn key(&mut self, key: &str) -> &mut Json {
        self.comma();
        self.quoted(key);
        self.text.push(':');
        self.follows = false;
        self
    }

    fn string(&mut self, text: &str) {
        self.comma();
        self.quoted(text);
    }

    /// A number, a boolean or null.
    fn plain(&mut self, value: impl Display) {
        self.comma();
        // Writing to a string cannot fail.
        let _ = write!(self.text, "{value}");
    }

    fn maybe(&mut self, value: Option<impl Display>) {
        match value {
            Some(value) => self.plain(value),
            None => self.plain("null"),
        }
    }

    fn quoted(&mut self, text: &str) {
        self.text.push('"');
        for c in text.chars() {
            match c {
                '"' | '\\' => self.text.extend(['\\', c]),
                c if c < ' ' => {
                    let _ = write!(self.text, "\\u{:04x}", c as u32);
                }
                c => self.text.push(c),
            }
        }
        self.text.push('"');
    }
}

pub(super) fn json(s: &Snapshot) -> String {
    let mut json = Json::default();
    json.object(|j| {
        j.key("version").plain(1);
        j.key("frame").plain(s.frame.frame);
        j.key("size").array(s.frame.size, Json::plain);
        j.key("order").array(&s.order, Json::plain);
        j.key("nodes").array(0..s.nodes.len(), |j, n| node(j, s, n));
        j.key("resources").array(&s.resources, |j, r| {
            j.object(|j| {
                j.key("name").string(&r.name);
                j.key("shape").string(&r.shape);
                j.key("kind").string(r.kind.as_str());
                j.key("bytes").plain(r.bytes);
                j.key("slot").maybe(r.slot);
                j.key("first").maybe(r.lifetime.map(|l| l.0));
                j.key("last").maybe(r.lifetime.map(|l| l.1));
                j.key("written_by").array(&r.last, Json::plain);
            });
        });
        j.key("passes").array(&s.passes, |j, pass| {
            j.object(|j| {
                j.key("nodes").array(&pass.nodes, Json::plain);
                match &pass.apart {
                    Some(reason) => j.key("apart").string(reason),
                    None => j.key("apart").plain("null"),
                }
            });
        });
        j.key("edges").array(&s.edges, |j, e| {
            j.object(|j| {
                j.key("from").plain(e.from);
                j.key("to").plain(e.to);
                j.key("hazard").string(match e.hazard {
                    Hazard::ReadAfterWrite => "raw",
                    Hazard::WriteAfterRead => "war",
                    Hazard::WriteAfterWrite => "waw",
                });
            });
        });
        j.key("exports").array(&s.exports, |j, (key, resource)| {
            j.object(|j| {
                j.key("key").string(key);
                j.key("resource").plain(resource);
            });
        });
        j.key("slots").array(&s.memory.slots, |j, slot| {
            j.object(|j| {
                j.key("bytes").plain(slot.bytes);
                j.key("class").string(&s.memory.classes[slot.class].shape);
            });
        });
        j.key("memory").object(|j| {
            j.key("without_reuse").plain(s.memory.without_reuse);
            j.key("lower_bound").plain(s.memory.lower_bound);
            j.key("achieved").plain(s.memory.achieved);
            j.key("histories").plain(s.memory.histories);
        });
        j.key("barriers").plain(s.barriers);
        j.key("warnings")
            .array(&s.warnings, |j, warning| j.string(warning));
    });
    json.text.push('\n');
    json.text
}

fn node(j: &mut Json, s: &Snapshot, n: usize) {
    let node = &s.nodes[n];
    j.object(|j| {
        j.key("name").string(&node.name);
        j.key("kind").string(node.kind.verb());
        j.key("live").plain(node.live);
        j.key("off").plain(node.off);
        j.key("pass").maybe(node.pass);
        if let Some(workgroups) = node.workgroups {
            j.key("workgroups").array(workgroups, Json::plain);
        }
        if let Some(reason) = node.side_effect {
            j.key("side_effect").string(reason);
        }
        j.key("batch").array(&node.batch, |j, (resource, t)| {
            j.object(|j| {
                j.key("resource").plain(resource);
                change(j, t);
            });
        });
        j.key("uses")
            .array(node.uses.clone(), |j, u| usage(j, u, &s.uses[u as usize]));
    });
}

fn usage(j: &mut Json, index: u32, u: &UseInfo) {
    j.object(|j| {
        j.key("use").plain(index);
        j.key("port").string(&u.port);
        j.key("resource").plain(u.resource);
        j.key("version").plain(u.version);
        j.key("mode").string(match u.mode {
            Mode::Read => "read",
            Mode::Modify => "modify",
            Mode::Overwrite => "overwrite",
        });
        j.key("mips")
            .array([u.range.mip, u.range.mips], Json::plain);
        j.key("layers")
            .array([u.range.layer, u.range.layers], Json::plain);
        j.key("state").string(&u.state.to_string());
        j.key("transitions").array(&u.transitions, |j, t| {
            j.object(|j| {
                change(j, t);
                j.key("barrier").plain(t.barrier);
                j.key("batched").plain(t.batched);
            });
        });
        j.key("discarded").plain(u.discarded);
        j.key("from").array(&u.from, Json::plain);
        j.key("from_before").plain(u.from_before);
    });
}

fn change(j: &mut Json, t: &Transition) {
    j.key("mips")
        .array([t.range.mip, t.range.mips], Json::plain);
    j.key("layers")
        .array([t.range.layer, t.range.layers], Json::plain);
    j.key("before").string(&t.before.to_string());
    j.key("after").string(&t.after.to_string());
}
