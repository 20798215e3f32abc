//! The graph while it is put together: passes of all files in one list, joined by links.
//!
//! Each input and output of a graph that is used as a pass is a *relay*: a vertex that hands on one
//! texture. A relay input reads in the outer scope and is seen in the inner one; a relay output the
//! other way round. So wiring knows one kind of thing, and relays vanish at the end.

use std::sync::Arc;

use crate::diagnostics::{Span, nearest};
use crate::params::ErasedParams;
use crate::port::{FirstFrame, Port, PortSignal, Resolution};
use crate::registry::PassType;
use crate::signal::Signal;

pub(crate) type VertexId = usize;
pub(crate) type ScopeId = usize;

/// All files of a graph, put together.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub vertices: Vec<Vertex>,
    pub scopes: Vec<Scope>,
    /// Passes and relays beside an input that was named wrongly; which of theirs was meant is not
    /// known, so that what is not wired there is not reported again.
    pub misnamed: Vec<VertexId>,
}

/// What one graph file names.
#[derive(Debug)]
pub(crate) struct Scope {
    /// Before the names of its passes: empty, or such as `e/`.
    pub prefix: String,
    pub members: Vec<(String, Member)>,
    pub inputs: Vec<(String, VertexId)>,
    pub outputs: Vec<(String, VertexId)>,
}

/// What a name in a scope is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Member {
    Pass(VertexId),
    Graph(ScopeId),
    /// A pass that could not be understood; whatever reads it is not reported again.
    Broken,
}

/// A pass, or a relay.
#[derive(Debug)]
pub(crate) struct Vertex {
    /// Its name in the whole graph: `e/jbu`, and for relays `e.value`.
    pub name: String,
    pub kind: VertexKind,
    /// Where its inputs are wired.
    pub scope: ScopeId,
    /// Where its outputs are seen.
    pub seen_in: Option<ScopeId>,
    pub inputs: Vec<Input>,
    pub outputs: Vec<Slot>,
    pub span: Span,
    /// What its free ports carry.
    pub signal: Option<Signal>,
    /// Full or grid: the class of its ports of free resolution.
    pub class: Option<Resolution>,
    /// Pixels per texel of its grid ports, and who says so.
    pub grid: Option<(u32, String)>,
    /// Pixels per texel of its ports of free resolution, and who says so.
    pub any_grid: Option<(u32, String)>,
    pub removed: bool,
}

#[derive(Debug)]
pub(crate) enum VertexKind {
    Pass(PassVertex),
    /// An input of the whole graph.
    HostInput {
        grid: u32,
    },
    /// An input of a graph that is used as a pass.
    RelayIn(ScopeId),
    /// An output of a graph.
    RelayOut(ScopeId),
}

#[derive(Debug)]
pub(crate) struct PassVertex {
    pub ty: Arc<PassType>,
    pub params: ErasedParams,
    /// Where it is asked to be bypassed.
    pub bypass: Option<Span>,
}

/// A port.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    pub name: String,
    /// Of an input, the port name it looks for; of an output, the name it is found by.
    pub source: String,
    pub signal: PortSignal,
    pub resolution: Resolution,
    pub optional: bool,
    pub first: Option<FirstFrame>,
}

#[derive(Clone, Debug)]
pub(crate) struct Input {
    pub slot: Slot,
    pub wire: Wire,
}

#[derive(Clone, Debug)]
pub(crate) enum Wire {
    Open,
    To(Link),
    /// Reported already.
    Broken,
}

#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub vertex: VertexId,
    pub output: usize,
    pub previous: bool,
    /// Where it is written; `None` when it is implicit.
    pub span: Option<Span>,
}

impl Slot {
    pub fn of(port: &Port) -> Self {
        Self {
            name: port.name.to_owned(),
            source: port.source_name().to_owned(),
            signal: port.signal,
            resolution: port.resolution,
            optional: port.optional,
            first: port.first,
        }
    }

    /// The end of a relay output: takes what it gets.
    pub fn relay(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            source: name.to_owned(),
            signal: PortSignal::Any,
            resolution: Resolution::Any,
            optional: false,
            first: None,
        }
    }
}

impl Wire {
    pub fn link(&self) -> Option<&Link> {
        match self {
            Self::To(link) => Some(link),
            _ => None,
        }
    }
}

impl Vertex {
    pub fn new(name: String, kind: VertexKind, scope: ScopeId, span: &Span) -> Self {
        Self {
            name,
            kind,
            scope,
            seen_in: Some(scope),
            inputs: Vec::new(),
            outputs: Vec::new(),
            span: span.clone(),
            signal: None,
            class: None,
            grid: None,
            any_grid: None,
            removed: false,
        }
    }

    pub fn pass(&self) -> Option<&PassVertex> {
        match &self.kind {
            VertexKind::Pass(pass) => Some(pass),
            _ => None,
        }
    }

    pub fn is_relay(&self) -> bool {
        matches!(self.kind, VertexKind::RelayIn(_) | VertexKind::RelayOut(_))
    }

    /// The graph that a relay belongs to.
    pub fn relay_of(&self) -> Option<ScopeId> {
        match self.kind {
            VertexKind::RelayIn(scope) | VertexKind::RelayOut(scope) => Some(scope),
            _ => None,
        }
    }

    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|input| input.slot.name == name)
    }

    /// What a port carries, when that is known.
    pub fn signal_of(&self, slot: &Slot) -> Option<Signal> {
        match slot.signal {
            PortSignal::Is(signal) => Some(signal),
            PortSignal::Any => self.signal,
        }
    }

    /// The class of a port, full or grid, when that is known.
    pub fn class_of(&self, slot: &Slot) -> Option<Resolution> {
        match slot.resolution {
            Resolution::Any => self.class,
            class => Some(class),
        }
    }

    /// Pixels per texel of a port, and who says so, when that is known.
    pub fn grid_of(&self, slot: &Slot) -> Option<(u32, String)> {
        match slot.resolution {
            Resolution::Full => Some((1, self.address(slot))),
            Resolution::Grid => self.grid.clone(),
            Resolution::Any => self.any_grid.clone(),
        }
    }

    /// A port as a message names it. A relay is named like its port.
    pub fn address(&self, slot: &Slot) -> String {
        match self.kind {
            VertexKind::Pass(_) => format!("{}.{}", self.name, slot.name),
            _ => self.name.clone(),
        }
    }
}

impl Draft {
    /// The passes that are there, in order.
    pub fn passes(&self) -> impl Iterator<Item = (VertexId, &Vertex, &PassVertex)> {
        let vertices = self.vertices.iter().enumerate();
        vertices.filter_map(|(id, vertex)| {
            let pass = vertex.pass().filter(|_| !vertex.removed)?;
            Some((id, vertex, pass))
        })
    }

    /// Every input that is there.
    pub fn all_inputs(&self) -> impl Iterator<Item = (VertexId, usize, &Input)> {
        let vertices = self.vertices.iter().enumerate().filter(|(_, v)| !v.removed);
        vertices.flat_map(|(id, v)| {
            v.inputs
                .iter()
                .enumerate()
                .map(move |(i, input)| (id, i, input))
        })
    }

    /// Every link that reads an output of `vertex`.
    pub fn readers(&self, vertex: VertexId) -> Vec<(VertexId, usize, Link)> {
        let inputs = self.all_inputs();
        let links = inputs.filter_map(|(v, i, input)| Some((v, i, input.wire.link()?.clone())));
        links.filter(|(_, _, link)| link.vertex == vertex).collect()
    }

    /// What an address without a port names, from `scope`: `jbu`, `e`, `e/jbu`.
    pub fn member(&self, scope: ScopeId, path: &str) -> Option<Member> {
        let (first, rest) = match path.split_once('/') {
            Some((first, rest)) => (first, Some(rest)),
            None => (path, None),
        };
        let members = &self.scopes[scope].members;
        let member = members.iter().find(|(name, _)| name == first)?.1;
        match (member, rest) {
            (member, None) => Some(member),
            (Member::Graph(inner), Some(rest)) => self.member(inner, rest),
            (Member::Broken, Some(_)) => Some(Member::Broken),
            (Member::Pass(_), Some(_)) => None,
        }
    }

    /// [`Draft::member`]; and for a name that is nearest to that of a pass that could not be
    /// understood, that pass: its name may be what is wrong with it, and is reported already.
    pub fn meant(&self, scope: ScopeId, path: &str) -> Option<Member> {
        self.member(scope, path).or_else(|| {
            let names = self.member_names(scope);
            let meant = nearest(path, names.iter().map(String::as_str))?;
            let broken = |member: &Member| *member == Member::Broken;
            self.member(scope, meant).filter(broken)
        })
    }

    /// Every address without a port that can be used from `scope`.
    pub fn member_names(&self, scope: ScopeId) -> Vec<String> {
        let mut names = Vec::new();
        for (name, member) in &self.scopes[scope].members {
            names.push(name.clone());
            if let Member::Graph(inner) = member {
                let inner = self.member_names(*inner).into_iter();
                names.extend(inner.map(|deeper| format!("{name}/{deeper}")));
            }
        }
        names
    }

    /// The outputs of a member by name: vertex and position.
    pub fn outputs_of(&self, member: Member) -> Vec<(String, VertexId, usize)> {
        match member {
            Member::Pass(id) => {
                let outputs = self.vertices[id].outputs.iter().enumerate();
                outputs
                    .map(|(i, slot)| (slot.name.clone(), id, i))
                    .collect()
            }
            Member::Graph(scope) => {
                let outputs = self.scopes[scope].outputs.iter();
                outputs.map(|(name, id)| (name.clone(), *id, 0)).collect()
            }
            Member::Broken => Vec::new(),
        }
    }

    /// The inputs of a member by name: vertex and position.
    pub fn inputs_of(&self, member: Member) -> Vec<(String, VertexId, usize)> {
        match member {
            Member::Pass(id) => {
                let inputs = self.vertices[id].inputs.iter().enumerate();
                inputs
                    .map(|(i, input)| (input.slot.name.clone(), id, i))
                    .collect()
            }
            Member::Graph(scope) => {
                let inputs = self.scopes[scope].inputs.iter();
                inputs.map(|(name, id)| (name.clone(), *id, 0)).collect()
            }
            Member::Broken => Vec::new(),
        }
    }

    /// Whether something in `scope` could not be understood, so that what is missing there may be
    /// what it would have given.
    pub fn is_broken(&self, scope: ScopeId) -> bool {
        let mut members = self.scopes[scope].members.iter();
        members.any(|(_, member)| match member {
            Member::Broken => true,
            Member::Graph(inner) => self.is_broken(*inner),
            Member::Pass(_) => false,
        })
    }
}
