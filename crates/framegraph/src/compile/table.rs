//! Tables that hold something for every (mip, layer) of every resource.

use crate::graph::FrameGraph;
use crate::handle::Subresources;

/// Where the entries of each resource start, mip after mip.
#[derive(Default)]
pub(crate) struct Table {
    /// For each resource, and at the end the number of all entries.
    base: Vec<u32>,
    layers: Vec<u32>,
}

impl Table {
    pub fn fill(&mut self, graph: &FrameGraph<'_>) {
        self.base.clear();
        self.layers.clear();
        let mut len = 0;
        for r in &graph.resources {
            let (mips, layers) = r.shape.extent();
            self.base.push(len);
            self.layers.push(layers);
            len += mips * layers;
        }
        self.base.push(len);
    }

    pub fn len(&self) -> usize {
        self.base.last().map_or(0, |&len| len as usize)
    }

    /// The entries of a range of a resource.
    pub fn entries(&self, resource: u32, range: Subresources) -> Entries {
        let layers = self.layers[resource as usize];
        let at = self.base[resource as usize] + range.mip * layers + range.layer;
        Entries {
            at,
            end: at + range.layers,
            rows: range.mips - 1,
            skip: layers - range.layers,
            width: range.layers,
        }
    }

    /// All entries of a resource.
    pub fn all(&self, resource: u32) -> std::ops::Range<usize> {
        self.base[resource as usize] as usize..self.base[resource as usize + 1] as usize
    }
}

/// Row after row of a rectangle.
pub(crate) struct Entries {
    at: u32,
    end: u32,
    rows: u32,
    skip: u32,
    width: u32,
}

impl Iterator for Entries {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        if self.at == self.end {
            if self.rows == 0 {
                return None;
            }
            self.rows -= 1;
            self.at += self.skip;
            self.end = self.at + self.width;
        }
        self.at += 1;
        Some(self.at as usize - 1)
    }
}
