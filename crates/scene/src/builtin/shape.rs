//! Parametric surfaces as triangle meshes.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use crate::model::Mesh;

/// Triangles under construction. Front faces are counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    indices: Vec<[u32; 3]>,
}

impl Shape {
    pub(super) fn into_mesh(self, name: &str, material: u32) -> Mesh {
        Mesh {
            name: name.to_owned(),
            positions: self.positions,
            normals: self.normals,
            uvs: self.uvs,
            indices: self.indices,
            material,
            ..Mesh::default()
        }
    }

    /// A flat quad, counter-clockwise seen from its front; uv in metres times `scale`, u along
    /// the first edge.
    pub(super) fn quad(mut self, corners: [Vec3; 4], scale: f32) -> Self {
        let [a, b, _, d] = corners;
        let normal = (b - a).cross(d - a).normalize_or(Vec3::Y);
        let u = (b - a).normalize_or(Vec3::X);
        let v = normal.cross(u);
        let base = self.positions.len() as u32;
        for corner in corners {
            self.positions.push(corner);
            self.normals.push(normal);
            // v of an image points down.
            let uv = Vec2::new((corner - a).dot(u), -(corner - a).dot(v));
            self.uvs.push(uv * scale);
        }
        self.indices
            .extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        self
    }

    /// An axis-aligned box, seen from outside.
    pub(super) fn block(self, min: Vec3, max: Vec3, scale: f32) -> Self {
        let corner = |x: bool, y: bool, z: bool| {
            Vec3::new(
                if x { max.x } else { min.x },
                if y { max.y } else { min.y },
                if z { max.z } else { min.z },
            )
        };
        let (o, i) = (false, true);
        [
            [[o, o, i], [i, o, i], [i, i, i], [o, i, i]],
            [[i, o, o], [o, o, o], [o, i, o], [i, i, o]],
            [[i, o, i], [i, o, o], [i, i, o], [i, i, i]],
            [[o, o, o], [o, o, i], [o, i, i], [o, i, o]],
            [[o, i, i], [i, i, i], [i, i, o], [o, i, o]],
            [[o, o, o], [i, o, o], [i, o, i], [o, o, i]],
        ]
        .into_iter()
        .fold(self, |shape, face| {
            shape.quad(face.map(|[x, y, z]| corner(x, y, z)), scale)
        })
    }

    /// A surface over [0, 1]^2 of `columns` x `rows` quads. `point` gives position and uv; the
    /// normal is dP/du x dP/dv, by central differences.
    pub(super) fn grid(
        mut self,
        columns: u32,
        rows: u32,
        point: impl Fn(f32, f32) -> (Vec3, Vec2),
    ) -> Self {
        // A hundredth of a cell: far above the rounding of f32, far below the features.
        let (du, dv) = (0.01 / columns as f32, 0.01 / rows as f32);
        let base = self.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
                let (position, uv) = point(u, v);
                let along_u = point(u + du, v).0 - point(u - du, v).0;
                let along_v = point(u, v + dv).0 - point(u, v - dv).0;
                self.positions.push(position);
                self.normals
                    .push(along_u.cross(along_v).normalize_or(Vec3::Y));
                self.uvs.push(uv);
            }
        }
        let width = columns + 1;
        for row in 0..rows {
            for column in 0..columns {
                let a = base + row * width + column;
                let (b, c, d) = (a + 1, a + width + 1, a + width);
                self.indices.extend([[a, b, c], [a, c, d]]);
            }
        }
        self
    }

    /// A profile of (radius, height), upwards, turned about the y axis. `swell(angle, height)`
    /// multiplies the radius.
    pub(super) fn lathe(
        self,
        segments: u32,
        rows: u32,
        profile: &[[f32; 2]],
        swell: impl Fn(f32, f32) -> f32,
    ) -> Self {
        self.grid(segments, rows, |u, v| {
            let angle = -u * TAU;
            let [radius, height] = along(profile, v);
            let radius = radius * swell(angle, height);
            let position = Vec3::new(radius * angle.cos(), height, radius * angle.sin());
            (position, Vec2::new(2.0 * u, -height))
        })
    }

    /// Both shapes.
    pub(super) fn with(mut self, other: &Shape, transform: Affine3A) -> Self {
        let base = self.positions.len() as u32;
        let points = other.positions.iter();
        self.positions
            .extend(points.map(|p| transform.transform_point3(*p)));
        let normals = other.normals.iter();
        self.normals
            .extend(normals.map(|n| transform.transform_vector3(*n).normalize_or(Vec3::Y)));
        self.uvs.extend(&other.uvs);
        self.indices
            .extend(other.indices.iter().map(|t| t.map(|i| base + i)));
        self
    }
}

/// The point at `v` in [0, 1] of a polyline whose points are equally far apart in `v`.
fn along(profile: &[[f32; 2]], v: f32) -> [f32; 2] {
    let last = profile.len() - 1;
    let at = v.clamp(0.0, 1.0) * last as f32;
    let i = (at as usize).min(last - 1);
    let s = at - i as f32;
    [0, 1].map(|c| profile[i][c] * (1.0 - s) + profile[i + 1][c] * s)
}

/// A sphere of 20 * 4^`levels` flat triangles, its vertices on the unit sphere: convex.
pub(super) fn icosphere(levels: u32) -> Mesh {
    let t = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = [
        [-1.0, t, 0.0],
        [1.0, t, 0.0],
        [-1.0, -t, 0.0],
        [1.0, -t, 0.0],
        [0.0, -1.0, t],
        [0.0, 1.0, t],
        [0.0, -1.0, -t],
        [0.0, 1.0, -t],
        [t, 0.0, -1.0],
        [t, 0.0, 1.0],
        [-t, 0.0, -1.0],
        [-t, 0.0, 1.0],
    ]
    .into_iter()
    .map(|p| Vec3::from(p).normalize())
    .collect();
    let mut indices: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| -> u32 {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let point = (positions[a as usize] + positions[b as usize]).normalize();
                positions.push(point);
                (positions.len() - 1) as u32
            })
        };
        indices = indices
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh {
        positions,
        indices,
        ..Mesh::default()
    }
}
