//! Every use of a handle passes through here: brand, version and conflicts are checked at the call.

use super::{Access, FrameGraph, Resource, Shape};
use crate::error::{Code, GraphError, Site};
use crate::handle::{Raw, Subresources, View};
use crate::state::{Mode, State};

impl FrameGraph<'_> {
    #[cold]
    pub(crate) fn fail(
        &mut self,
        code: Code,
        message: String,
        site: Site,
        help: impl Into<String>,
    ) {
        self.errors.push(GraphError::new(code, message, site, help));
    }

    /// The resource of a handle of this graph. Nothing is reported for the result of an earlier mistake.
    pub(crate) fn resolve(&mut self, raw: Raw, site: Site) -> Option<usize> {
        if raw.resource == u32::MAX {
            return None;
        }
        if raw.brand != self.brand {
            self.fail(
                Code::OtherGraph,
                "a handle of another frame graph is used".into(),
                site,
                "handles live for one frame: declare or import the resource in this graph",
            );
            return None;
        }
        Some(raw.resource as usize)
    }

    /// The range of a view; reports one that lies outside.
    pub(crate) fn resolve_view(
        &mut self,
        view: &View,
        site: Site,
    ) -> Option<(usize, Subresources)> {
        let resource = self.resolve(view.texture.0, site)?;
        let Resource {
            shape: Shape::Texture { mips, layers, .. },
            ..
        } = self.resources[resource]
        else {
            return None;
        };
        match view.resolve(mips, layers) {
            Some(range) => Some((resource, range)),
            None => {
                let Resource {
                    label,
                    site: declared,
                    ..
                } = &self.resources[resource];
                let error = GraphError::new(
                    Code::OutOfRange,
                    format!(
                        "the view lies outside `{label}`, which has {mips} mips and {layers} layers"
                    ),
                    site,
                    "count mips and layers from 0",
                )
                .with("declared", *declared);
                self.errors.push(error);
                None
            }
        }
    }

    /// Records that `node` uses a range, and returns the version that holds after it and the access' index.
    pub(crate) fn access(
        &mut self,
        node: u32,
        raw: Raw,
        range: Subresources,
        (mode, state, usage): (Mode, State, u32),
        site: Site,
    ) -> (Raw, u32) {
        let latest = self.resources[raw.resource as usize].latest;
        if raw.version != latest {
            self.check_stale(Some(node), raw, mode.writes(), site);
        }
        self.check_conflict(node, raw.resource, range, mode, site);
        let index = self.accesses.len() as u32;
        let access = Access {
            node,
            resource: raw.resource,
            range,
            mode,
            state,
            usage,
            version: latest,
            site,
        };
        self.note_access(&access);
        self.accesses.push(access);
        self.nodes[node as usize].accesses.end = index + 1;
        if mode.writes() {
            self.resources[raw.resource as usize].latest = latest + 1;
            (
                Raw {
                    version: latest + 1,
                    ..raw
                },
                index,
            )
        } else {
            (raw, index)
        }
    }

    /// Reports the use of a version that a node other than `node` has replaced.
    #[cold]
    pub(crate) fn check_stale(&mut self, node: Option<u32>, raw: Raw, writes: bool, site: Site) {
        let replacing =
            |a: &&Access| a.resource == raw.resource && a.mode.writes() && a.version == raw.version;
        let Some(by) = self.accesses.iter().find(replacing) else {
            return;
        };
        // Within one node reads may use the version from before its own writes.
        if Some(by.node) == node && !writes {
            return;
        }
        let resource = &self.resources[raw.resource as usize].label;
        let who = match node {
            Some(node) => format!(
                "`{}` {}",
                self.nodes[node as usize].label,
                if writes { "writes" } else { "reads" }
            ),
            None => "an export takes".into(),
        };
        let error = GraphError::new(
            Code::Stale,
            format!(
                "{who} version {} of `{resource}`, which `{}` has replaced by version {}",
                raw.version,
                self.nodes[by.node as usize].label,
                raw.version + 1
            ),
            site,
            match writes {
                true => "write to the handle that the other write returned",
                false => {
                    "use the handle that the write returned, or declare this use before the write"
                }
            },
        )
        .with("replaced", by.site);
        self.errors.push(error);
    }

    /// Reports a second touch of the same range by one node when either writes.
    fn check_conflict(
        &mut self,
        node: u32,
        resource: u32,
        range: Subresources,
        mode: Mode,
        site: Site,
    ) {
        let own = &self.accesses[self.nodes[node as usize].accesses.start as usize..];
        let clash = own.iter().find(|a| {
            a.resource == resource && (a.mode.writes() || mode.writes()) && a.range.overlaps(&range)
        });
        if let Some(clash) = clash {
            let error = GraphError::new(
                Code::Conflict,
                format!(
                    "`{}` touches the same part of `{}` twice, and writes it",
                    self.nodes[node as usize].label, self.resources[resource as usize].label
                ),
                site,
                "bind it once with `modify`, or read another mip, layer or resource",
            )
            .with("first touched", clash.site);
            self.errors.push(error);
        }
    }
}
