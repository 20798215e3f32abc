//! Building compressed wide BVHs: one over all that stands still, and in two levels one per mesh
//! that moves and one over their instances.
//!
//! Node layout and traversal: Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs". Built by `obvhs` (parallel locally-ordered clustering,
//! then reinsertion, then collapsing to eight children).

use glam::{Affine3A, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::{CwBvh, node::CwBvhNode};
use obvhs::ploc::PlocBuilder;
use obvhs::triangle::Triangle;

/// How much time a BVH may take to build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BuildQuality {
    /// About half the build time of `Medium`, a few per cent slower to trace.
    VeryFast,
    /// About the build time of Embree's default.
    #[default]
    Medium,
}

impl BuildQuality {
    fn params(self) -> BvhBuildParams {
        match self {
            Self::VeryFast => BvhBuildParams::very_fast_build(),
            Self::Medium => BvhBuildParams::medium_build(),
        }
    }
}

/// A compressed wide BVH over some primitives.
pub(crate) struct Bvh {
    nodes: Vec<CwBvhNode>,
    /// The primitive at each leaf place.
    pub order: Vec<u32>,
    /// Bounds of everything.
    pub bounds: Aabb,
    /// Levels of nodes, which bounds the entries a traversal pushes.
    pub depth: u32,
}

/// `u32` in a node.
const NODE_WORDS: usize = 20;

/// Bytes of a node.
pub(crate) const NODE_BYTES: u64 = 4 * NODE_WORDS as u64;

impl Bvh {
    /// Over the triangles of a mesh; `None` when there are none.
    pub fn over_triangles(
        positions: &[Vec3],
        indices: &[[u32; 3]],
        quality: BuildQuality,
    ) -> Option<Self> {
        let corner = |i: u32| Vec3A::from(positions[i as usize]);
        let triangles: Vec<Triangle> = indices
            .iter()
            .map(|&[a, b, c]| Triangle {
                v0: corner(a),
                v1: corner(b),
                v2: corner(c),
            })
            .collect();
        Self::over(&triangles, quality)
    }

    /// Over boxes; `None` when there are none.
    pub fn over_boxes(boxes: &[Aabb], quality: BuildQuality) -> Option<Self> {
        // A triangle with two corners of the box has the box as its bounds; so the builder is
        // compiled for one kind of primitive.
        let triangles: Vec<Triangle> = boxes
            .iter()
            .map(|b| Triangle {
                v0: b.min,
                v1: b.max,
                v2: b.min,
            })
            .collect();
        Self::over(&triangles, quality)
    }

    /// Over triangles given by their corners; `None` when there are none.
    pub fn over(triangles: &[Triangle], quality: BuildQuality) -> Option<Self> {
        if triangles.is_empty() {
            return None;
        }
        let params = quality.params();
        let mut bvh2 = PlocBuilder::with_capacity(triangles.len()).build(
            params.ploc_search_distance,
            triangles,
            (0..triangles.len() as u32).collect(),
            params.sort_precision,
            params.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut bvh2, params.reinsertion_batch_ratio, None);
        // A leaf of a compressed wide BVH has room for 3.
        let leaf = params.max_prims_per_leaf.clamp(1, 3);
        let wide = bvh2_to_cwbvh(&bvh2, leaf, true, false);
        Some(Self {
            depth: depth(&wide),
            nodes: wide.nodes,
            order: wide.primitive_indices,
            bounds: wide.total_aabb,
        })
    }

    /// Appends the nodes as the GPU reads them; returns the index of the root.
    ///
    /// `first_node` is the index of the first node of `nodes`, and `first_primitive` where leaf
    /// place 0 stands in the array of all leaves.
    pub fn append_to(&self, nodes: &mut Vec<u32>, first_node: u32, first_primitive: u32) -> u32 {
        let root = first_node + (nodes.len() / NODE_WORDS) as u32;
        for node in &self.nodes {
            let moved = CwBvhNode {
                child_base_idx: node.child_base_idx + root,
                primitive_base_idx: node.primitive_base_idx + first_primitive,
                ..*node
            };
            nodes.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&moved)));
        }
        root
    }
}

fn depth(bvh: &CwBvh) -> u32 {
    let mut deepest = 0;
    let mut open = vec![(0_usize, 1_u32)];
    while let Some((index, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let node = &bvh.nodes[index];
        open.extend(
            (0..8)
                .filter(|&child| !node.is_child_empty(child) && !node.is_leaf(child))
                .map(|child| (node.child_node_index(child) as usize, depth + 1)),
        );
    }
    deepest
}

/// World bounds of a box under a transform, a little larger than exact so that rounding in the
/// traversal cannot lose what touches its faces.
pub(crate) fn transformed_bounds(bounds: &Aabb, transform: &Affine3A) -> Aabb {
    let corners: [Vec3A; 8] = std::array::from_fn(|i| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        transform.transform_point3a(Vec3A::new(pick(0), pick(1), pick(2)))
    });
    let mut exact = Aabb::from_points(&corners);
    let size = exact.min.abs().max(exact.max.abs()).max_element();
    let pad = Vec3A::splat(size * 4.0 * f32::EPSILON);
    exact.min -= pad;
    exact.max += pad;
    exact
}
