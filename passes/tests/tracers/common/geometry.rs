//! A scene's triangles on the CPU, met by brute force: an independent answer to "what is there".

use glam::{Vec2, Vec3};
use scumble::Camera;
use scumble_scene::{Pose, Scene, moving};
pub use scumble_tests::scene_camera;

/// A triangle in world space, now and one frame earlier.
pub struct Triangle {
    pub now: [Vec3; 3],
    pub before: [Vec3; 3],
    /// Radiance it emits from its front.
    pub emission: Vec3,
}

/// What a ray met.
#[derive(Clone, Copy)]
pub struct Met {
    pub t: f32,
    pub triangle: usize,
    pub uv: Vec2,
}

fn corners(scene: &Scene, pose: &Pose, instance: usize) -> Vec<Vec3> {
    let placed = &scene.instances[instance];
    let deformed = pose.deformed.iter().find(|d| d.mesh == placed.mesh);
    let local = deformed.map_or(&scene.meshes[placed.mesh as usize].positions, |d| {
        &d.positions
    });
    local
        .iter()
        .map(|&p| pose.instances[instance].transform_point3(p))
        .collect()
}

/// All triangles of a scene at two times, as its poses have them.
pub fn triangles(scene: &Scene, now: f32, before: f32) -> Vec<Triangle> {
    let poses = [scene.pose(now), scene.pose(before)];
    triangles_by(scene, |i| {
        poses.each_ref().map(|pose| corners(scene, pose, i))
    })
}

/// All triangles of the built-in `moving` at two times, by its closed form.
pub fn triangles_of_moving(scene: &Scene, now: f32, before: f32) -> Vec<Triangle> {
    let column = &scene.animation.deformers[0];
    triangles_by(scene, |i| {
        let rest = &scene.meshes[scene.instances[i].mesh as usize].positions;
        [now, before].map(|time| {
            let at = |(v, p): (usize, &Vec3)| {
                let p = p.as_dvec3();
                match scene.instances[i].mesh {
                    mesh if mesh == column.mesh => {
                        let displacement = column.targets[0].positions[v].as_dvec3();
                        moving::column(f64::from(time), p, displacement)
                    }
                    // The object comes first and is the only one that a node carries.
                    0 => moving::object(f64::from(time)).transform_point3(p),
                    _ => p,
                }
            };
            rest.iter().enumerate().map(|v| at(v).as_vec3()).collect()
        })
    })
}

/// Triangles from the world positions of each instance's vertices, now and one frame earlier.
fn triangles_by(scene: &Scene, vertices: impl Fn(usize) -> [Vec<Vec3>; 2]) -> Vec<Triangle> {
    let mut all = Vec::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let [now, before] = vertices(i);
        let emission = scene.materials[mesh.material as usize].emission;
        for t in &mesh.indices {
            let at = |v: &[Vec3]| t.map(|k| v[k as usize]);
            all.push(Triangle {
                now: at(&now),
                before: at(&before),
                emission,
            });
        }
    }
    all
}

/// The nearest triangle of `all` (as it is now) along a ray.
pub fn nearest(all: &[Triangle], origin: Vec3, direction: Vec3, t_max: f32) -> Option<Met> {
    let mut best: Option<Met> = None;
    for (i, triangle) in all.iter().enumerate() {
        let limit = best.map_or(t_max, |b| b.t);
        if let Some((t, uv)) = meet(triangle.now, origin, direction)
            && t > 1e-5
            && t < limit
        {
            best = Some(Met { t, triangle: i, uv });
        }
    }
    best
}

/// Moeller and Trumbore 1997.
fn meet([a, b, c]: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f32, Vec2)> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    if det.abs() < 1e-20 {
        return None;
    }
    let s = origin - a;
    let q = s.cross(e1);
    let (u, v) = (s.dot(p) / det, direction.dot(q) / det);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some((e2.dot(q) / det, Vec2::new(u, v)))
}

/// The point of a triangle at barycentric `uv`.
pub fn point([a, b, c]: [Vec3; 3], uv: Vec2) -> Vec3 {
    a + (b - a) * uv.x + (c - a) * uv.y
}

/// How far a point is from a triangle.
pub fn distance([a, b, c]: [Vec3; 3], p: Vec3) -> f32 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(q, r)| (r - q).cross(p - q).dot(normal) >= 0.0);
    if inside && normal != Vec3::ZERO {
        return (p - a).dot(normal.normalize()).abs();
    }
    let to_edge = |(q, r): (Vec3, Vec3)| {
        let along = r - q;
        let t = (p - q).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
        p.distance(q + along * t.clamp(0.0, 1.0))
    };
    [(a, b), (b, c), (c, a)]
        .map(to_edge)
        .into_iter()
        .fold(f32::MAX, f32::min)
}

/// Image position of a world-space point; origin top-left, 1 at the far borders.
pub fn project(camera: &Camera, size: [u32; 2], p: Vec3) -> Vec2 {
    let clip = camera.clip_from_world(size) * p.extend(1.0);
    Vec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w)
}

/// Unit direction from the camera through an image position.
pub fn direction(camera: &Camera, size: [u32; 2], uv: Vec2) -> Vec3 {
    let height = (0.5 * camera.y_fov).tan();
    let width = height * size[0] as f32 / size[1] as f32;
    let view = Vec3::new(
        (2.0 * uv.x - 1.0) * width,
        (1.0 - 2.0 * uv.y) * height,
        -1.0,
    );
    camera.world_from_view.transform_vector3(view).normalize()
}

/// Image position of the centre of a pixel by its index.
pub fn pixel_uv(i: usize, size: [u32; 2]) -> Vec2 {
    let [w, h] = size.map(|n| n as usize);
    Vec2::new(
        ((i % w) as f32 + 0.5) / w as f32,
        ((i / w) as f32 + 0.5) / h as f32,
    )
}
