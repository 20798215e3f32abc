//! Numbers that make no sense, from a file or from a host: each is refused or left out, and said.

mod common;

use common::{message, read, with};
use glam::{Affine3A, Mat3, Quat, Vec3};
use scumble_scene::animation::{Animation, Local, Node};
use scumble_scene::{Camera, Instance, Light, Material, Mesh, SceneBuilder, Sky};
use serde_json::{Value, json};

/// The error of a file whose first node is this; its mesh is `Tri`, of one triangle.
fn node(node: Value) -> String {
    message(&with(|document, _| document["nodes"][0] = node))
}

/// The error of a scene of one triangle and what `add` adds.
fn built(add: impl FnOnce(&mut SceneBuilder, u32)) -> String {
    let mut builder = SceneBuilder::new("test");
    builder.material(Material::default()).unwrap();
    let mesh = Mesh {
        name: "Tri".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        indices: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let mesh = builder.mesh(mesh).unwrap();
    builder.instance(Instance::new(mesh, Affine3A::IDENTITY));
    add(&mut builder, mesh);
    builder.build().unwrap_err().to_string()
}

#[test]
fn a_scale_of_zero_is_left_out_and_said() {
    for scale in [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1e-30, 1e-30, 1e-30]] {
        assert_eq!(
            node(json!({"mesh": 0, "scale": scale})),
            "scene `test`: nothing to render: the transforms of all its instances have no volume; \
             check the scales of its nodes"
        );
    }
    let two = with(|document, _| {
        document["nodes"] = json!([{"mesh": 0, "scale": [1, 0, 1]}, {"mesh": 0}]);
        document["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let scene = read(&two).unwrap();
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(
        scene.warnings[0],
        "left out instance 0 of mesh `Tri`: a transform without volume (a scale of 0) makes it \
         flat, a line or a point"
    );
}

/// Growing out of nothing is how files show and hide things.
#[test]
fn a_scale_of_zero_that_a_clip_drives_stays() {
    let bytes = with(|document, binary| {
        binary.resize(44, 0);
        for value in [0.0f32, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0] {
            binary.extend(value.to_le_bytes());
        }
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": 44, "byteLength": 8}));
        views.push(json!({"buffer": 0, "byteOffset": 52, "byteLength": 24}));
        let accessors = document["accessors"].as_array_mut().unwrap();
        accessors
            .push(json!({"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR"}));
        accessors.push(json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}));
        document["nodes"] = json!([{"children": [1], "scale": [0, 0, 0]}, {"mesh": 0}]);
        document["animations"] = json!([{
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
            "samplers": [{"input": 2, "output": 3}],
        }]);
        document["buffers"][0]["byteLength"] = json!(76);
    });
    let scene = read(&bytes).unwrap();
    assert_eq!(scene.instances.len(), 1);
    assert_eq!(scene.pose(0.5).instances[0].matrix3.determinant(), 0.125);
}

#[test]
fn what_lies_too_far_away() {
    let reaches = |to: &str| {
        format!(
            "instance 0 of mesh `Tri`: it reaches to {to}, farther than 1e9 m from the origin; \
             check the scale and the positions of its nodes"
        )
    };
    // 2^40, as f32 is written.
    let large = 1099511627776.0f32;
    assert_eq!(
        node(json!({"mesh": 0, "scale": [large, large, large]})),
        reaches("[1099511600000, 0, 0]")
    );
    assert_eq!(
        node(json!({"mesh": 0, "translation": [0, 2e9, 0]})),
        reaches("[0, 2000000000, 0]")
    );
    let far = node(json!({"mesh": 0, "scale": [1e30, 1e30, 1e30]}));
    assert!(far.contains("farther than 1e9 m"), "{far}");
    assert_eq!(
        built(|builder, _| {
            builder.light(Light::Point {
                position: Vec3::new(0.0, 1e10, 0.0),
                intensity: Vec3::ONE,
            });
        }),
        "light 0: its position [0, 10000000000, 0] must be finite and within 1e9 m of the origin"
    );
}

#[test]
fn transforms_that_are_none() {
    let nested = with(|document, _| {
        let huge = [1e30, 1e30, 1e30];
        document["nodes"] = json!([{"children": [1], "scale": huge}, {"mesh": 0, "scale": huge}]);
    });
    assert_eq!(
        message(&nested),
        "node 1: its transform is not finite; repair it where it was made"
    );
    assert_eq!(
        node(json!({"mesh": 0, "rotation": [0, 0, 0, 0]})),
        "node 0: its rotation [0, 0, 0, 0] must be a unit quaternion, such as 0, 0, 0, 1"
    );
    assert_eq!(
        node(json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1]})),
        "node 0: the last row of its matrix is [0.0, 0.0, 0.5, 1.0] and must be 0, 0, 0, 1"
    );
    let nan = Affine3A::from_scale(Vec3::splat(f32::NAN));
    assert_eq!(
        built(|builder, mesh| _ = builder.instance(Instance::new(mesh, nan))),
        "instance 1: its transform is not finite; repair it where it was made"
    );
    let half = Local::Trs {
        translation: Vec3::ZERO,
        rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.5),
        scale: Vec3::ONE,
    };
    assert_eq!(
        built(|builder, _| builder.animation(Animation {
            nodes: vec![Node {
                name: "hinge".to_owned(),
                parent: None,
                local: half,
            }],
            ..Animation::default()
        })),
        "node 0 `hinge`: its rotation [0, 0, 0, 0.5] must be a unit quaternion"
    );
}

#[test]
fn cameras_that_see_nothing() {
    let camera = |change: &dyn Fn(&mut Camera)| {
        let mut camera = Camera::look_at(Vec3::Z * 3.0, Vec3::ZERO, 1.0);
        camera.name = "front".to_owned();
        change(&mut camera);
        built(|builder, _| _ = builder.camera(camera))
    };
    for (y_fov, shown) in [(0.0, "0"), (std::f32::consts::PI, "3.1415927"), (4.0, "4")] {
        assert_eq!(
            camera(&|c| c.y_fov = y_fov),
            format!(
                "camera `front`: its vertical field of view {shown} must be above 0 and below pi \
                 radians (180 degrees)"
            )
        );
    }
    for (near, shown) in [(0.0, "0"), (-1.0, "-1"), (f32::INFINITY, "inf")] {
        assert_eq!(
            camera(&|c| c.near = near),
            format!(
                "camera `front`: its near plane {shown} must be at a positive distance, such as \
                 0.01"
            )
        );
    }
    for axes in [
        Mat3::from_diagonal(Vec3::new(1.0, 2.0, 1.0)),
        Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0)),
        Mat3::ZERO,
    ] {
        assert_eq!(
            camera(&|c| c.world_from_view = Affine3A::from_mat3(axes)),
            "camera `front`: its axes must have length 1 and be at right angles, right-handed; \
             give it no scale"
        );
    }
    // As a file says it.
    let file = |yfov: f32, znear: f32, scale: f32| {
        read(&with(|document, _| {
            document["cameras"] = json!([{"name": "front", "type": "perspective",
                "perspective": {"yfov": yfov, "znear": znear}}]);
            document["nodes"] = json!([{"mesh": 0}, {"camera": 0, "scale": [scale, scale, scale]}]);
            document["scenes"][0]["nodes"] = json!([0, 1]);
        }))
    };
    assert!(file(1.0, 0.1, 2.0).is_ok());
    assert!(
        file(0.0, 0.1, 1.0)
            .unwrap_err()
            .to_string()
            .starts_with("camera `front`: its vertical field of view 0 must")
    );
    assert!(
        file(1.0, 0.0, 1.0)
            .unwrap_err()
            .to_string()
            .starts_with("camera `front`: its near plane 0 must")
    );
    assert_eq!(
        file(1.0, 0.1, 0.0).unwrap().warnings[0],
        "camera `front` is left out: the transform of its node has no volume (a scale of 0) and \
         so no axes"
    );
}

#[test]
fn lights_that_are_none() {
    let point = |intensity: Vec3| {
        built(|builder, _| {
            builder.light(Light::Point {
                position: Vec3::ZERO,
                intensity,
            });
        })
    };
    assert_eq!(
        point(Vec3::new(1.0, -2.0, 1.0)),
        "light 0: its power [1, -2, 1] must be within 0 and 1e18"
    );
    for bad in [f32::NAN, f32::INFINITY, 1e19] {
        assert!(point(Vec3::splat(bad)).ends_with("must be within 0 and 1e18"));
    }
    let directional = |direction| Light::Directional {
        direction,
        irradiance: Vec3::ONE,
    };
    assert_eq!(
        built(|builder, _| _ = builder.light(directional(Vec3::ZERO))),
        "light 0: its direction [0, 0, 0] must have length 1"
    );
    let spot = Light::Spot {
        position: Vec3::ZERO,
        direction: Vec3::Z,
        intensity: Vec3::ONE,
        inner: 0.5,
        outer: 0.25,
    };
    assert_eq!(
        built(|builder, _| _ = builder.light(spot)),
        "light 0: its cone must have 0 <= inner < outer <= pi/2, not 0.5 and 0.25"
    );
    assert_eq!(
        built(|builder, _| builder.sky(Sky::Constant(Vec3::NEG_Y))),
        "sky: its radiance [0, -1, 0] must be within 0 and 1e18"
    );
    let glowing = Material {
        name: "lamp".to_owned(),
        emission: Vec3::splat(-1.0),
        ..Material::default()
    };
    assert_eq!(
        SceneBuilder::new("test")
            .material(glowing)
            .unwrap_err()
            .to_string(),
        "material `lamp`: its emission [-1, -1, -1] must be within 0 and 1e18"
    );
}

/// A light that is off is no light: a picture of nothing would say nothing.
#[test]
fn a_light_of_no_power_is_no_light() {
    let bytes = with(|document, _| {
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        document["extensions"] =
            json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 0}]}});
        document["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    });
    assert_eq!(
        read(&bytes).unwrap().warnings.last().unwrap(),
        "no light in the scene: added a constant sky of radiance 1"
    );
}

#[test]
fn indices_that_are_not_whole_triangles() {
    let bytes = with(|document, _| document["accessors"][1]["count"] = json!(2));
    assert_eq!(
        message(&bytes),
        "mesh `Tri`, primitive 0: its 2 indices are not whole triangles; give a multiple of 3"
    );
}
