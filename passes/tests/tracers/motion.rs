//! Motion vectors against motion computed from the poses of the scene.

use crate::common::geometry::{
    Triangle, direction, nearest, pixel_uv, point, project, scene_camera, triangles,
    triangles_of_moving,
};
use crate::common::rig::Rig;
use crate::common::scenes::room;
use glam::{Vec2, Vec3};
use scumble::{Camera, FrameInput};
use scumble_scene::Scene;

fn graph(with: &str) -> String {
    format!(
        r#"(version: 1, about: "test", passes: [(use: "gbuffer", with: ({with}))], outputs: {{"motion": "gbuffer.motion",
            "view_z": "gbuffer.view_z", "surface_id": "gbuffer.surface_id", "position": "gbuffer.position"}})"#
    )
}

/// Compares motion between two times with that of the nearest triangle's own vertices, found by brute force in `all`.
/// Returns (pixels that hit something, pixels off by more than 0.01 pixel, pixels that moved).
fn compare(
    scene: Scene,
    all: &[Triangle],
    camera: [Camera; 2],
    times: [f32; 2],
    size: [u32; 2],
    source: &str,
) -> (usize, usize, usize) {
    let mut rig = Rig::new(&graph(&format!("source: {source}")), scene, size);
    for time in times {
        rig.pose(time);
        let input = FrameInput {
            previous_camera: camera[0],
            camera: camera[1],
            time,
            ..FrameInput::default()
        };
        rig.render(&input);
    }
    let (motion, ids) = (rig.read("motion"), rig.words("surface_id"));
    let pixels = Vec2::new(size[0] as f32, size[1] as f32);
    let (mut hits, mut wrong, mut moved) = (0, 0, 0);
    for i in 0..motion.len() {
        let d = direction(&camera[1], size, pixel_uv(i, size));
        let Some(met) = nearest(all, camera[1].position(), d, f32::MAX) else {
            continue;
        };
        // Pixels along edges, where one of the two sees the sky, are not hits of both.
        if ids[i] == 0 {
            continue;
        }
        let triangle = &all[met.triangle];
        let now = project(&camera[1], size, point(triangle.now, met.uv));
        let expected = now - project(&camera[0], size, point(triangle.before, met.uv));
        hits += 1;
        moved += usize::from((expected * pixels).length() > 0.1);
        wrong += usize::from(
            ((Vec2::new(motion[i][0], motion[i][1]) - expected) * pixels).length() > 0.01,
        );
    }
    (hits, wrong, moved)
}

/// Nodes, camera, skin and morph target of `moving`, against its closed form.
#[test]
fn motion_of_the_closed_form() {
    let scene = scumble_scene::builtin("moving").unwrap();
    let times = [0.5, 0.55];
    let cameras = times.map(|time| {
        let camera = scene_camera(&scene.pose(time).cameras[0]);
        let eye = scumble_scene::moving::camera(f64::from(time)).as_vec3();
        assert!(camera.position().distance(eye) < 3e-6, "ten ulp of 6 m");
        camera
    });
    let all = triangles_of_moving(&scene, times[1], times[0]);
    for source in ["RayTraced", "Raster"] {
        let (hits, wrong, moved) = compare(scene.clone(), &all, cameras, times, [96, 64], source);
        assert!(
            hits > 1000 && moved > hits / 20,
            "{source}: {hits} hits, {moved} moved"
        );
        assert!(
            wrong * 1000 <= hits,
            "{source}: {wrong} of {hits} are off by more than 0.01 pixel"
        );
    }
}

/// The column fills the image: every hit is on skinned and morphed vertices.
#[test]
fn motion_of_skin_and_morph_target() {
    let mut scene = scumble_scene::builtin("moving").unwrap();
    let column = scene.animation.deformers[0].mesh;
    scene.instances.retain(|instance| instance.mesh == column);
    let middle = scumble_scene::moving::COLUMN_PLACE.as_vec3() + 0.75 * Vec3::Y;
    let camera = Camera::look_at(middle + Vec3::new(0.5, 0.6, 2.0), middle, 45.0);
    // The second pair spans a turning point of both, at a quarter of the period.
    for times in [[0.5, 0.6], [0.96, 1.06]] {
        let all = triangles_of_moving(&scene, times[1], times[0]);
        for source in ["RayTraced", "Raster"] {
            let (hits, wrong, moved) =
                compare(scene.clone(), &all, [camera; 2], times, [96, 96], source);
            assert!(
                hits > 1500 && moved > hits / 2,
                "{source}: {hits} hits, {moved} moved"
            );
            assert!(
                wrong * 1000 <= hits,
                "{source}: {wrong} of {hits} are off by more than 0.01 pixel"
            );
        }
    }
}

/// A file's many joints, against the poses of the scene.
#[test]
fn motion_of_skinned_vertices() {
    let Some(path) = scumble_scene::shared("scenes/CesiumMan.glb") else {
        eprintln!(
            "SKIPPED: scenes/CesiumMan.glb is not there; set SCUMBLE_SHARED to the folder that has it"
        );
        return;
    };
    let scene = scumble_scene::load(&path, &scumble_scene::LoadOptions::default()).unwrap();
    let camera = scene_camera(&scene.cameras[0]);
    let moved_camera = Camera {
        world_from_view: glam::Mat4::from_rotation_y(0.01) * camera.world_from_view,
        ..camera
    };
    let (cameras, times) = ([camera, moved_camera], [0.3, 0.35]);
    let all = triangles(&scene, times[1], times[0]);
    for source in ["RayTraced", "Raster"] {
        let (hits, wrong, moved) = compare(scene.clone(), &all, cameras, times, [96, 96], source);
        assert!(hits > 500 && moved > hits / 2, "{hits} hits, {moved} moved");
        assert!(
            wrong * 1000 <= hits,
            "{source}: {wrong} of {hits} are off by more than 0.01 pixel"
        );
    }
}

/// A still camera before a still scene has motion 0, bit by bit, whatever the jitter; so has one whose nodes, skins and
/// morph targets stand still in the middle of their clips.
#[test]
fn jitter_is_not_motion() {
    for source in ["Raster", "RayTraced"] {
        for scene in [room(), scumble_scene::builtin("moving").unwrap()] {
            let name = scene.name.clone();
            let graph = graph(&format!("source: {source}, jitter: Halton"));
            let mut rig = Rig::new(&graph, scene, [45, 32]);
            rig.pose(0.7);
            rig.render(&rig.still(0, 0));
            for frame in 1..5 {
                rig.pose(0.7);
                rig.render(&rig.still(frame, 0));
                assert!(
                    rig.read("motion")
                        .iter()
                        .all(|m| m[0] == 0.0 && m[1] == 0.0),
                    "{name}, {source}, frame {frame}"
                );
            }
        }
    }
}

/// Where the point a pixel sees was hidden one frame earlier, the position at uv - motion is another one; where it was
/// in view, it is the same one. Judged by rays from the previous camera.
#[test]
fn disocclusion_is_found_by_reprojection() {
    let size = [128, 128];
    let scene = room();
    let all = triangles(&scene, 0.0, 0.0);
    let mut rig = Rig::new(&graph("source: RayTraced"), scene, size);
    let before = rig.camera;
    let now = Camera {
        world_from_view: glam::Mat4::from_rotation_y(0.1) * before.world_from_view,
        ..before
    };
    rig.render(&FrameInput::still(before));
    let old = rig.read("position");
    rig.render(&FrameInput {
        previous_camera: before,
        ..FrameInput::still(now)
    });
    let (motion, position, ids) = (
        rig.read("motion"),
        rig.read("position"),
        rig.words("surface_id"),
    );

    let (mut judged, mut agree, mut hidden_count, mut found) = (0, 0, 0, 0);
    for i in 0..position.len() {
        let uv = pixel_uv(i, size) - Vec2::new(motion[i][0], motion[i][1]);
        if ids[i] == 0 || uv.min_element() < 0.0 || uv.max_element() >= 1.0 {
            continue;
        }
        let p = Vec3::from_slice(&position[i][..3]);
        let to_point = p - before.position();
        let distance = to_point.length();
        let hidden = nearest(
            &all,
            before.position(),
            to_point / distance,
            distance * 0.999,
        )
        .is_some();
        // In view when one of the four texels around saw the point or its surroundings: up to a pixel away, 2 tan(0.4) /
        // 128 of the distance sideways, and a few times that along a slope.
        let corner = (uv * 128.0 - 0.5).floor();
        let same = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            .into_iter()
            .any(|(x, y)| {
                let at = (corner + Vec2::new(x, y))
                    .clamp(Vec2::ZERO, Vec2::splat(127.0))
                    .as_uvec2();
                let q = old[(at.y * 128 + at.x) as usize];
                q[3] != 0.0 && p.distance(Vec3::from_slice(&q[..3])) < 0.02 * distance
            });
        judged += 1;
        hidden_count += usize::from(hidden);
        found += usize::from(hidden && !same);
        agree += usize::from(same != hidden);
    }
    assert!(
        judged > 8000 && hidden_count > 80,
        "{hidden_count} of {judged} were hidden"
    );
    assert!(
        agree * 1000 >= judged * 995,
        "{agree} of {judged} agree; {found} of {hidden_count} hidden ones are found"
    );
    // The rest lies within a pixel of what was in view.
    assert!(
        found * 3 > hidden_count * 2,
        "{found} of {hidden_count} hidden ones are found"
    );
}
