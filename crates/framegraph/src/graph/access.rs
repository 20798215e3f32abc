//! Every use of a handle passes through here: brand, version and conflicts are checked at the call.

use super::{Access, FrameGraph, Resource, Shape, UNBOUND};
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
    #[inline(always)]
    pub(crate) fn resolve(&mut self, raw: Raw, site: Site) -> Option<usize> {
        if raw.resource == u32::MAX {
            return None;
        }
        if raw.brand != self.brand {
            self.report_other_graph(site);
            return None;
        }
        Some(raw.resource as usize)
    }

    #[cold]
    fn report_other_graph(&mut self, site: Site) {
        self.fail(
            Code::OtherGraph,
            "a handle of another frame graph is used".into(),
            site,
            "handles live for one frame: declare or import the resource in this graph",
        );
    }

    /// Reports more workgroups than the device dispatches.
    #[inline(always)]
    pub(crate) fn check_workgroups(&mut self, node: u32, workgroups: [u32; 3], site: Site) {
        let max = self.caps.limits.max_compute_workgroups_per_dimension;
        if workgroups.iter().any(|&n| n > max) {
            let label = &self.nodes[node as usize].label;
            let message = format!("`{label}` dispatches {workgroups:?} workgroups");
            let help = format!("this device dispatches at most {max} in each dimension");
            self.fail(Code::Dispatch, message, site, help);
        }
    }

    /// The range of a view; reports one that lies outside.
    #[inline(always)]
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
                self.report_range(resource, site);
                None
            }
        }
    }

    #[cold]
    fn report_range(&mut self, resource: usize, site: Site) {
        let r = &self.resources[resource];
        let (label, (mips, layers)) = (&r.label, r.shape.extent());
        let error = GraphError::new(
            Code::OutOfRange,
            format!("the view lies outside `{label}`, which has {mips} mips and {layers} layers"),
            site,
            "count mips and layers from 0",
        )
        .with("declared", r.site);
        self.errors.push(error);
    }

    /// Records that `node` uses a range, and returns the access' index.
    #[inline(always)]
    pub(crate) fn access(
        &mut self,
        node: u32,
        raw: Raw,
        range: Subresources,
        (mode, state, usage): (Mode, State, u32),
        site: Site,
    ) -> u32 {
        self.access_in(UNBOUND, node, raw, range, (mode, state, usage), site)
    }

    /// The same in a slot of the node's kernel.
    #[inline(always)]
    pub(crate) fn access_in(
        &mut self,
        slot: u16,
        node: u32,
        raw: Raw,
        range: Subresources,
        (mode, state, usage): (Mode, State, u32),
        site: Site,
    ) -> u32 {
        let latest = self.latest[raw.resource as usize];
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
            slot,
            usage,
            version: latest,
            site,
        };
        self.note_access(&access);
        self.accesses.push(access);
        self.nodes[node as usize].accesses.end = index + 1;
        self.latest[raw.resource as usize] = latest + u32::from(mode.writes());
        index
    }

    /// The handle that holds after an access by `raw`.
    #[inline(always)]
    pub(crate) fn handle(&self, raw: Raw, mode: Mode) -> Raw {
        match mode.writes() {
            true => Raw {
                version: self.latest[raw.resource as usize],
                ..raw
            },
            false => raw,
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
    #[inline(always)]
    pub(crate) fn check_conflict(
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
            let first = clash.site;
            self.report_conflict(node, resource, site, first);
        }
    }

    #[cold]
    fn report_conflict(&mut self, node: u32, resource: u32, site: Site, first: Site) {
        let error = GraphError::new(
            Code::Conflict,
            format!(
                "`{}` touches the same part of `{}` twice, and writes it",
                self.nodes[node as usize].label, self.resources[resource as usize].label
            ),
            site,
            "bind it once with `modify`, or read another mip, layer or resource",
        )
        .with("first touched", first);
        self.errors.push(error);
    }
}
