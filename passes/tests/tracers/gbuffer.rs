//! The G-buffer: raster against primary rays, holes, jitter, sky.

use crate::common::geometry::{direction, distance, nearest, pixel_uv, point, triangles};
use crate::common::rig::Rig;
use crate::common::scenes::room;
use glam::{Vec2, Vec3};
use scumble::FrameInput;

fn gbuffer(with: &str) -> String {
    format!(
        r#"(version: 1, about: "test", passes: [(use: "gbuffer", with: ({with}))], outputs: {{
            "albedo": "gbuffer.albedo", "normal": "gbuffer.normal", "geo_normal": "gbuffer.geo_normal",
            "view_z": "gbuffer.view_z", "position": "gbuffer.position", "motion": "gbuffer.motion",
            "material": "gbuffer.material", "surface_id": "gbuffer.surface_id", "emission": "gbuffer.emission"}})"#
    )
}

/// Both sources see the same triangles (but along edges) and shade them alike.
#[test]
fn raster_and_primary_rays_agree() {
    let size = [101, 67];
    let shot = |source: &str| {
        let mut rig = Rig::new(
            &gbuffer(&format!("source: {source}, jitter: Halton")),
            room(),
            size,
        );
        rig.render(&rig.still(5, 0));
        rig
    };
    let (raster, traced) = (shot("Raster"), shot("RayTraced"));
    let (a, b) = (raster.words("surface_id"), traced.words("surface_id"));
    let same: Vec<usize> = (0..a.len()).filter(|&i| a[i] == b[i]).collect();
    // Coverage is decided at coordinates snapped to 1/256 pixel: of the pixels that edges cross, about one in a hundred.
    assert!(
        same.len() as f64 >= 0.998 * a.len() as f64,
        "{} of {} pixels see another surface",
        a.len() - same.len(),
        a.len()
    );
    let ids: std::collections::BTreeSet<u32> = a.iter().copied().collect();
    assert_eq!(ids.len(), 6, "five meshes and the sky are in view: {ids:?}");

    let pairs = |name: &str| (raster.read(name), traced.read(name));
    let near = |name: &str, tolerance: f32, channels: usize| {
        let (x, y) = pairs(name);
        let far = same.iter().filter(|&&i| {
            let scale = y[i].iter().fold(1e-3f32, |m, v| m.max(v.abs()));
            (0..channels).any(|c| (x[i][c] - y[i][c]).abs() > tolerance * scale)
        });
        far.count()
    };
    let n = same.len();
    // The snapped point is up to 1/512 pixel off, 2e-5 of the image: times the slope of the surface, seen at grazing
    // angles too. Facets of one mesh have one id, so along their edges normals may differ: 1 % of pixels.
    assert!(near("view_z", 1e-3, 1) * 100 < n, "view_z");
    assert!(near("position", 1e-3, 3) * 100 < n, "position");
    // Constant over each mesh: equal whichever triangle is seen.
    assert_eq!(near("albedo", 0.0, 4), 0, "albedo");
    assert_eq!(near("material", 0.0, 4), 0, "material");
    assert_eq!(near("emission", 0.0, 3), 0, "emission");
    for name in ["normal", "geo_normal"] {
        let (x, y) = (raster.normals(name), traced.normals(name));
        let far = same
            .iter()
            .filter(|&&i| a[i] != 0 && x[i].distance(y[i]) > 1e-3)
            .count();
        assert!(far * 100 < n, "{name}: {far}");
    }
}

/// Where rasterisation sees a triangle that a ray through the pixel's centre misses, snapped as its vertices are, the point
/// it reports still lies on the triangle: no spikes along silhouettes and creases.
#[test]
fn rasterised_points_lie_on_the_surface() {
    let scene = scumble_scene::builtin("moving").unwrap();
    let rig = |source: &str| {
        let graph = gbuffer(&format!("source: {source}"));
        Rig::new(&graph, scene.clone(), [400, 300])
    };
    let mut rigs = [rig("Raster"), rig("RayTraced")];
    let (mut suspects, mut farthest) = (0, 0.0f32);
    for i in 1..=8 {
        let time = 0.4 * i as f32;
        let [raster, traced] = rigs.each_mut().map(|rig| {
            rig.pose(time);
            rig.render(&rig.still(0, 0));
            rig.read("position")
        });
        let all = triangles(&scene, time, time);
        for (p, q) in raster.iter().zip(&traced).filter(|(p, _)| p[3] != 0.0) {
            let (p, q) = (Vec3::from_slice(&p[..3]), Vec3::from_slice(&q[..3]));
            // Both are on the pixel's ray; they differ where another triangle is seen, nearer or farther by more than this.
            if p.distance(q) > 0.001 {
                suspects += 1;
                let to = |t: &crate::common::geometry::Triangle| distance(t.now, p);
                farthest = farthest.max(all.iter().map(to).fold(f32::MAX, f32::min));
            }
        }
    }
    assert!(suspects >= 4, "only {suspects} points can tell");
    // Ten ulp of f32 at 6 m.
    assert!(
        farthest < 5e-6,
        "of {suspects} points one is {farthest} m off every triangle"
    );
}

/// Primary rays find what brute force finds, at the distance it finds it; normals face the viewer.
#[test]
fn primary_rays_agree_with_brute_force() {
    let size = [33, 17];
    let mut rig = Rig::new(&gbuffer("source: RayTraced"), room(), size);
    rig.render(&rig.still(0, 0));
    let all = triangles(&room(), 0.0, 0.0);
    let (z, position) = (rig.read("view_z"), rig.read("position"));
    let (normals, geo_normals) = (rig.normals("normal"), rig.normals("geo_normal"));
    let forward = rig.camera.world_from_view.transform_vector3(Vec3::NEG_Z);
    let mut surfaces = 0;
    for i in 0..z.len() {
        let d = direction(&rig.camera, size, pixel_uv(i, size));
        let Some(met) = nearest(&all, rig.camera.position(), d, f32::MAX) else {
            assert_eq!(z[i][0], 1e30);
            continue;
        };
        surfaces += 1;
        let p = point(all[met.triangle].now, met.uv);
        // f32 barycentrics of two different intersection tests at a distance of about 3.
        assert!(
            p.distance(Vec3::from_slice(&position[i][..3])) < 1e-4,
            "pixel {i}"
        );
        assert!((z[i][0] - d.dot(forward) * met.t).abs() < 1e-4, "pixel {i}");
        assert!(
            normals[i].dot(d) < 0.0 && geo_normals[i].dot(d) < 0.0,
            "pixel {i}"
        );
    }
    assert!(surfaces > 150, "{surfaces} pixels see a surface");
}

/// Where the mask is 0 there are holes, everywhere else nothing changes.
#[test]
fn the_mask_makes_holes() {
    let size = [19, 11];
    let graph = |input: &str, wire: &str, source: &str| {
        format!(
            r#"(version: 1, about: "test", {input} passes: [(use: "gbuffer", {wire} with: (source: {source}))],
                outputs: {{"view_z": "gbuffer.view_z", "surface_id": "gbuffer.surface_id", "position": "gbuffer.position"}})"#
        )
    };
    for source in ["Raster", "RayTraced"] {
        let input = r#"inputs: {"mask": (signal: mask, resolution: full)},"#;
        let mut masked = Rig::new(
            &graph(input, r#"in: {"mask": "mask"},"#, source),
            room(),
            size,
        );
        let mut whole = Rig::new(&graph("", "", source), room(), size);
        let mask: Vec<u32> = (0..size[0] * size[1]).map(|i| i * i % 3).collect();
        masked.feed("mask", &mask);
        masked.render(&masked.still(0, 0));
        whole.render(&whole.still(0, 0));
        let (z, all_z) = (masked.read("view_z"), whole.read("view_z"));
        let (id, position) = (masked.words("surface_id"), masked.read("position"));
        for i in 0..mask.len() {
            if mask[i] == 0 {
                assert_eq!(
                    (z[i][0], id[i], position[i]),
                    (-1.0, 0, [0.0; 4]),
                    "{source} {i}"
                );
            } else {
                assert_eq!(z[i][0], all_z[i][0], "{source} {i}");
            }
        }
    }
}

/// The sampled point: the sky is exact, so its direction tells where in the pixel it was taken.
#[test]
fn jitter_moves_the_sample_inside_the_pixel() {
    let size = [64, 64];
    let position_with = |jitter: &str, input: &dyn Fn(&Rig) -> FrameInput| {
        let mut rig = Rig::new(
            &gbuffer(&format!("source: RayTraced, jitter: {jitter}")),
            room(),
            size,
        );
        let input = input(&rig);
        rig.render(&input);
        // A pixel on the floor, which is flat: its position tells the offset.
        let p = Vec3::from_slice(&rig.read("position")[40 * 64 + 20][..3]);
        crate::common::geometry::project(&rig.camera, size, p) * 64.0 - Vec2::new(20.5, 40.5)
    };
    let off = position_with("Off", &|rig| rig.still(3, 0));
    assert!(off.length() < 1e-3, "{off}");
    // Radical inverses of 4 in bases 2 and 3: 1/8 and 4/9.
    let halton = position_with("Halton", &|rig| rig.still(3, 0));
    assert!(
        halton.distance(Vec2::new(0.125 - 0.5, 4.0 / 9.0 - 0.5)) < 1e-3,
        "{halton}"
    );
    let said = Vec2::new(0.25, -0.375);
    let host = position_with("Host", &|rig| FrameInput {
        jitter: Some(said),
        ..rig.still(3, 0)
    });
    assert!(host.distance(said) < 1e-3, "{host}");
}
