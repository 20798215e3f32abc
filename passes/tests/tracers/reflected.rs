//! Reflections in a flat mirror, against the closed form: a mirror shows the world behind it.

use glam::Vec3;
use scumble::FrameInput;
use scumble_scene::{Material, Sky};

use crate::common::geometry::{direction, pixel_uv, project};
use crate::common::rig::Rig;
use crate::common::scenes::{quad, scene};

const SIZE: [u32; 2] = [64, 48];

const GRAPH: &str = r#"(version: 1, passes: [
    (use: "gbuffer"),
    (use: "path-trace", with: (samples: 8, max_bounces: 0), in: {
        "normal": "gbuffer.normal", "albedo": "gbuffer.albedo", "surface_id": "gbuffer.surface_id"}),
    (use: "gbuffer-reflected", in: {"normal": "gbuffer.normal", "surface_id": "gbuffer.surface_id"}),
    (use: "specular-reproject", as: "first", with: (radius: 0), in: {
        "position": "gbuffer.position", "normal": "gbuffer.normal", "view_z": "gbuffer.view_z", "motion": "gbuffer.motion",
        "past_view_z": "gbuffer.past_view_z", "material": "gbuffer.material", "surface_id": "gbuffer.surface_id",
        "hit_t": "path-trace.hit_t", "hit_weight": "path-trace.hit_weight"}),
    (use: "specular-reproject", as: "second", with: (radius: 0), in: {
        "position": "gbuffer.position", "normal": "gbuffer.normal", "view_z": "gbuffer.view_z", "motion": "gbuffer.motion",
        "past_view_z": "gbuffer.past_view_z", "material": "gbuffer.material", "surface_id": "gbuffer.surface_id",
        "hit_t": "path-trace.hit_t", "hit_weight": "path-trace.hit_weight", "reflected_view_z": "gbuffer-reflected.view_z",
        "reflected_hit_t": "gbuffer-reflected.hit_t", "reflected_displacement": "gbuffer-reflected.displacement"}),
], outputs: {"m1": "first.motion", "z1": "first.past_view_z", "m2": "second.motion", "z2": "second.past_view_z",
    "view_z": "gbuffer-reflected.view_z", "hit_t": "gbuffer-reflected.hit_t", "normal": "gbuffer-reflected.normal",
    "id": "gbuffer-reflected.surface_id", "albedo": "gbuffer-reflected.albedo", "d": "gbuffer-reflected.displacement",
    "real_id": "gbuffer.surface_id", "hits": "path-trace.hit_t"})"#;

/// A floor that is a mirror, and a red wall behind it at z = -2.
fn rig() -> Rig {
    let mirror = Material {
        base_color: Vec3::ONE.extend(1.0),
        metallic: 1.0,
        roughness: 0.0,
        ..Material::default()
    };
    let low = Vec3::new(-2.0, 0.0, -2.0);
    let meshes = vec![
        quad(low, Vec3::Z * 4.0, Vec3::X * 4.0, 0),
        quad(low, Vec3::X * 4.0, Vec3::Y * 3.0, 1),
    ];
    let materials = vec![
        mirror,
        Material::lambert("red", Vec3::new(0.75, 0.25, 0.125)),
    ];
    let scene = scene(
        meshes,
        materials,
        Sky::Constant(Vec3::ONE),
        Vec3::new(0.3, 1.2, 3.0),
        Vec3::new(0.0, 0.3, 0.0),
    );
    Rig::new(GRAPH, scene, SIZE)
}

#[test]
fn a_mirror_shows_the_world_behind_it() {
    let mut rig = rig();
    let camera = rig.camera;
    let mut previous = camera;
    previous.world_from_view.w_axis += Vec3::new(0.15, 0.05, 0.1).extend(0.0);
    rig.render(&FrameInput {
        camera,
        previous_camera: previous,
        ..FrameInput::default()
    });
    let [m1, z1, m2, z2, view_z, hit_t, albedo, displacement, hits] = [
        "m1", "z1", "m2", "z2", "view_z", "hit_t", "albedo", "d", "hits",
    ]
    .map(|name| rig.read(name));
    let (normals, ids, real_ids) = (rig.normals("normal"), rig.words("id"), rig.words("real_id"));
    let eye = camera.position();
    let (floor, wall) = (1, 2 ^ (1 << 20));
    let (mut mirrored, mut sky, mut off) = (0, 0, 0);
    for (i, id) in real_ids.iter().enumerate() {
        if *id != floor {
            // The wall is no mirror.
            assert_eq!((view_z[i][0], ids[i]), (-1.0, 0), "{i}");
            continue;
        }
        let uv = pixel_uv(i, SIZE);
        let v = direction(&camera, SIZE, uv);
        let on_floor = eye - v * (eye.y / v.y);
        // Where the ray that goes on behind the mirror meets the image of the wall.
        let image = eye + v * ((-2.0 - eye.z) / v.z);
        if (image.x.abs() - 2.0).abs() < 0.05 || (image.y + 3.0).abs() < 0.05 || image.y > -0.05 {
            continue; // The edge of the wall, or of the floor.
        }
        if image.x.abs() > 2.0 || image.y < -3.0 {
            assert_eq!((view_z[i][0], ids[i]), (1e30, 0), "{i}");
            assert_eq!(hit_t[i][0], 1e30);
            sky += 1;
            continue;
        }
        mirrored += 1;
        assert_eq!(ids[i], wall, "{i}");
        // Raster coordinates are snapped to 1/256 pixel.
        let near = |a: f32, b: f32, part: f32| (a - b).abs() <= part * b.abs();
        let depth = (camera.clip_from_world(SIZE) * image.extend(1.0)).w;
        assert!(near(view_z[i][0], depth, 1e-3), "{i}: {}", view_z[i][0]);
        assert!(near(hit_t[i][0], image.distance(on_floor), 2e-3), "{i}");
        assert!(normals[i].distance(Vec3::Z) < 1e-3, "{i}");
        assert_eq!(albedo[i][..3], [0.75, 0.25, 0.125], "{i}");
        assert_eq!(displacement[i][..3], [0.0; 3], "{i}");

        let motion = uv - project(&previous, SIZE, image);
        // Where the previous eye's ray to the image passes the floor.
        let to = image - previous.position();
        let through = previous.position() - to * (previous.position().y / to.y);
        let past_z = (previous.clip_from_world(SIZE) * through.extend(1.0)).w;
        let differs = |m: &[[f32; 4]], z: &[[f32; 4]], tolerance: f32| {
            (m[i][0] - motion.x).abs() > tolerance
                || (m[i][1] - motion.y).abs() > tolerance
                || !near(z[i][0], past_z, 10.0 * tolerance)
        };
        // A hundredth of a pixel.
        assert!(
            !differs(&m2, &z2, 2e-4),
            "{i}: {:?} instead of {motion}",
            m2[i]
        );
        // The lobe has a width of 1e-4 and long tails.
        off += u32::from(differs(&m1, &z1, 1e-3) || !near(hits[i][0], hit_t[i][0], 0.01));
    }
    assert!(mirrored > 500 && sky > 50, "{mirrored} {sky}");
    assert!(50 * off <= mirrored, "{off} of {mirrored}");
}
