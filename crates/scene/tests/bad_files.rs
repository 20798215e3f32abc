//! What is wrong with a file is said exactly, and no bytes make the loader panic.

mod common;

use std::sync::LazyLock;

use common::{glb, message, read, with};
use proptest::prelude::*;
use scumble_scene::{LoadOptions, Sky, builtin, load, load_bytes, to_glb};
use serde_json::{Value, json};

#[test]
fn the_plain_triangle_loads() {
    let scene = read(&with(|_, _| {})).unwrap();
    assert_eq!(scene.stats().triangles, 1);
    assert_eq!(scene.meshes[0].normals, vec![glam::Vec3::Z; 3]);
    assert_eq!(
        scene.warnings,
        [
            "no camera in the scene: added one that has everything in view",
            "no light in the scene: added a constant sky of radiance 1",
        ]
    );
    assert_eq!(scene.sky, Sky::Constant(glam::Vec3::ONE));
}

#[test]
fn missing_file() {
    let error = load("no/such.glb".as_ref(), &LoadOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "scene file `no/such.glb` does not exist; give a .glb or .gltf file or a built-in scene \
         (atrium, cornell, furnace, moving)"
    );
}

#[test]
fn truncated() {
    let bytes = with(|_, _| {});
    let whole = bytes.len();
    assert_eq!(
        message(&bytes[..whole - 8]),
        format!(
            "the file is truncated: its container should have {whole} bytes and has {}; copy or \
             export it again",
            whole - 8
        )
    );
    assert_eq!(
        message(&bytes[..7]),
        "the file is truncated: its header should have 8 bytes and has 7; copy or export it again"
    );
    let short = with(|document, _| document["buffers"][0]["byteLength"] = json!(4200));
    assert_eq!(
        message(&short),
        "the file is truncated: its buffer 0 should have 4200 bytes and has 44; copy or export \
         it again"
    );
    // On disk the file is named too.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.glb");
    std::fs::write(&path, &bytes[..whole - 8]).unwrap();
    let error = load(&path, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.starts_with(&format!("`{}`: the file is truncated", path.display())));
}

#[test]
fn index_out_of_range() {
    let bytes = with(|_, binary| binary[40] = 7);
    assert_eq!(
        message(&bytes),
        "mesh `Tri`, primitive 0: index 7 of triangle 0 is out of range, there are 3 vertices; \
         repair or export the mesh again"
    );
}

#[test]
fn nan_position() {
    let bytes = with(|_, binary| binary[16..20].copy_from_slice(&f32::NAN.to_le_bytes()));
    assert_eq!(
        message(&bytes),
        "mesh `Tri`, primitive 0: the position of vertex 1 is not finite (1, NaN, 0); repair the \
         mesh where it was made"
    );
}

#[test]
fn zero_area() {
    let flat = |binary: &mut Vec<u8>| binary[28..32].copy_from_slice(&0.0f32.to_le_bytes());
    assert_eq!(
        message(&with(|_, binary| flat(binary))),
        "scene `test` has nothing to render: all of its 1 triangles have zero area; check the \
         scale and the positions of its meshes"
    );
    // A second triangle with an area: the other is dropped with a warning.
    let bytes = with(|document, binary| {
        binary[40..42].copy_from_slice(&1u16.to_le_bytes());
        for index in [0u16, 1, 2] {
            binary.extend(index.to_le_bytes());
        }
        document["accessors"][1]["count"] = json!(6);
        document["bufferViews"][1]["byteLength"] = json!(12);
        document["buffers"][0]["byteLength"] = json!(48);
    });
    let scene = read(&bytes).unwrap();
    assert_eq!(scene.stats().triangles, 1);
    assert_eq!(
        scene.warnings[0],
        "dropped 1 triangle of zero area in mesh `Tri`, primitive 0"
    );
}

#[test]
fn empty() {
    let bytes = with(|document, _| document["scenes"][0]["nodes"] = json!([]));
    let expected = "scene `test` is empty: it has no triangles to render";
    assert_eq!(message(&bytes), expected);
    assert_eq!(message(br#"{"asset": {"version": "2.0"}}"#), expected);
}

#[test]
fn missing_texture() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = with(|document, _| {
        document["materials"] =
            json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        document["textures"] = json!([{"source": 0}]);
        document["images"] = json!([{"uri": "wood%20oak.png", "name": "oak"}]);
    });
    let path = folder.path().join("table.glb");
    std::fs::write(&path, bytes).unwrap();
    let error = load(&path, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        format!(
            "`{}`: texture file `{}` (image 0 `oak`) does not exist; put it there or remove the \
             texture from its material",
            path.display(),
            folder.path().join("wood oak.png").display()
        )
    );
}

#[test]
fn missing_buffer() {
    let folder = tempfile::tempdir().unwrap();
    let [path, buffer] = ["box.gltf", "box.bin"].map(|name| folder.path().join(name));
    scumble_scene::export(&builtin("cornell").unwrap(), &path).unwrap();
    std::fs::remove_file(&buffer).unwrap();
    let error = load(&path, &LoadOptions::default()).unwrap_err();
    // What the system says follows.
    let expected = format!("`{}`: cannot read `{}`: ", path.display(), buffer.display());
    assert!(error.to_string().starts_with(&expected), "{error}");
}

#[test]
fn required_extension() {
    let bytes = with(|document, _| {
        document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    });
    assert_eq!(
        message(&bytes),
        "it requires the glTF extension KHR_draco_mesh_compression, which is not supported; \
         export it without (supported: KHR_lights_punctual, KHR_materials_emissive_strength, \
         KHR_materials_ior, KHR_materials_specular, KHR_mesh_quantization, KHR_texture_transform)"
    );
}

#[test]
fn accessors_that_do_not_fit() {
    let count = with(|document, _| document["accessors"][0]["count"] = json!(4));
    assert_eq!(
        message(&count),
        "mesh `Tri`, primitive 0, POSITION: 4 elements of 12 bytes from byte 0 on do not fit into \
         buffer view 0 of 36 bytes; export the file again"
    );
    let view = with(|document, _| document["bufferViews"][1]["byteOffset"] = json!(40));
    assert_eq!(
        message(&view),
        "mesh `Tri`, primitive 0, indices: buffer view 1 spans bytes 40 to 46 of a buffer of 44 \
         bytes"
    );
    let huge = with(|document, _| document["accessors"][0]["count"] = json!(u64::MAX));
    assert!(message(&huge).contains("18446744073709551615 elements"));
    let kind = with(|document, _| document["accessors"][0]["type"] = json!("VEC2"));
    assert_eq!(
        message(&kind),
        "mesh `Tri`, primitive 0, POSITION: accessor 0 must have the type VEC3"
    );
}

#[test]
fn nodes_that_are_no_trees() {
    let own = with(|document, _| document["nodes"] = json!([{"mesh": 0}, {"children": [1]}]));
    assert_eq!(
        message(&own),
        "node 1: it is its own ancestor; the nodes must form trees"
    );
    let twice = with(|document, _| {
        document["nodes"] = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]);
    });
    assert_eq!(
        message(&twice),
        "node 0: it is a child of two nodes; the nodes must form trees"
    );
}

#[test]
fn not_gltf() {
    let reference = with(|document, _| document["nodes"][0]["mesh"] = json!(3));
    assert_eq!(
        message(&reference),
        "not a valid glTF 2.0 file: nodes[0].mesh: Index out of bounds"
    );
    assert!(message(b"hello").starts_with("not a valid glTF 2.0 file: JSON, "));
    let accessor = with(|document, _| {
        document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(u32::MAX);
    });
    assert_eq!(
        message(&accessor),
        "not a valid glTF 2.0 file: meshes[0].primitives[0]: accessor 4294967295 does not exist"
    );
    assert!(message(b"").starts_with("not a valid glTF 2.0 file: JSON, "));
}

#[test]
fn sparse_and_byte_indices() {
    // Vertex 2 is replaced by (0, 2, 0); indices are bytes.
    let bytes = with(|document, binary| {
        binary.truncate(36);
        binary.extend([0u8, 1, 2, 2]);
        for value in [0.0f32, 2.0, 0.0] {
            binary.extend(value.to_le_bytes());
        }
        document["accessors"][0]["sparse"] = json!({
            "count": 1,
            "indices": {"bufferView": 2, "componentType": 5121},
            "values": {"bufferView": 3},
        });
        document["accessors"][1]["componentType"] = json!(5121);
        document["bufferViews"][1]["byteLength"] = json!(3);
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": 39, "byteLength": 1}));
        views.push(json!({"buffer": 0, "byteOffset": 40, "byteLength": 12}));
        document["buffers"][0]["byteLength"] = json!(52);
    });
    let scene = read(&bytes).unwrap();
    assert_eq!(scene.meshes[0].positions[2], glam::Vec3::new(0.0, 2.0, 0.0));
}

#[test]
fn transparent_materials_are_opaque_with_one_warning_each() {
    let bytes = with(|document, _| {
        document["materials"] = json!([
            {"name": "veil", "alphaMode": "BLEND"},
            {"name": "glass", "alphaMode": "BLEND",
             "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}}},
            {"name": "pane",
             "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0}}},
            {"name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.25},
        ]);
    });
    let scene = read(&bytes).unwrap();
    assert_eq!(
        &scene.warnings[..3],
        [
            "material `veil` is blended (alphaMode BLEND): rendered opaque",
            "material `glass` is blended (alphaMode BLEND): rendered opaque",
            "material `pane` is transmissive (KHR_materials_transmission): rendered opaque",
        ]
    );
    assert_eq!(scene.warnings.len(), 5, "{:?}", scene.warnings);
    assert_eq!(scene.materials[3].alpha_cutoff, Some(0.25));
    assert!(
        scene.materials[..3]
            .iter()
            .all(|m| m.alpha_cutoff.is_none())
    );
}

#[test]
fn morph_targets_move_and_mirrored_nodes_stay_mirrored() {
    // One target lifts vertex 2 by 1; its weight goes 0 -> 1 in one second.
    let bytes = with(|document, binary| {
        binary.resize(44, 0);
        for value in [0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            binary.extend(value.to_le_bytes());
        }
        for value in [0.0f32, 1.0] {
            binary.extend(value.to_le_bytes());
        }
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": 44, "byteLength": 36}));
        views.push(json!({"buffer": 0, "byteOffset": 80, "byteLength": 8}));
        let accessors = document["accessors"].as_array_mut().unwrap();
        accessors.push(json!({"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"}));
        accessors
            .push(json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR"}));
        document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 2}]);
        document["nodes"][0]["scale"] = json!([-1.0, 1.0, 1.0]);
        document["animations"] = json!([{
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": 3, "output": 3}],
        }]);
        document["buffers"][0]["byteLength"] = json!(88);
    });
    let scene = read(&bytes).unwrap();
    let pose = scene.pose(0.75);
    // 0.75 is exact in binary.
    assert_eq!(
        pose.deformed[0].positions[2],
        glam::Vec3::new(0.0, 1.75, 0.0)
    );
    assert!(pose.instances[0].matrix3.determinant() < 0.0);
    let again = load_bytes(&to_glb(&scene).unwrap(), "test", &LoadOptions::default()).unwrap();
    assert_eq!(again.pose(0.75).deformed, pose.deformed);
    assert_eq!(again.pose(0.75).instances, pose.instances);
}

/// A small file with textures, lights, a camera and an animation.
static VICTIM: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut scene = builtin("moving").unwrap();
    for texture in &mut scene.textures {
        (texture.width, texture.height) = (2, 2);
        texture.rgba8.truncate(16);
    }
    to_glb(&scene).unwrap()
});

proptest! {
    // Each case loads 200 kB; 250 of them take some seconds.
    #![proptest_config(ProptestConfig { cases: 250, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        in_json in any::<bool>(),
    ) {
        let mut bytes = VICTIM.clone();
        let json = 20 + u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        let range = if in_json { json } else { bytes.len() };
        for (index, value) in flips {
            let at = index.index(range);
            bytes[at] = value;
        }
        if let Ok(scene) = read(&bytes) {
            scene.pose(1.0);
        }
    }

    #[test]
    fn cut_files_never_panic(length in any::<prop::sample::Index>()) {
        let bytes = &*VICTIM;
        let cut = &bytes[..length.index(bytes.len())];
        prop_assert!(read(cut).is_err());
    }
}

/// Every number of the document, one after the other, becomes each of these.
fn change_numbers(bytes: &[u8], every: usize) {
    let json = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let document: Value = serde_json::from_slice(&bytes[20..20 + json]).unwrap();
    let mut copy = document.clone();
    let mut numbers = Vec::new();
    collect(&mut copy, &mut numbers);
    for place in (0..numbers.len()).step_by(every) {
        for value in [
            json!(-1),
            json!(1),
            json!(7),
            json!(1e30),
            json!(u32::MAX),
            json!(u64::MAX),
        ] {
            let mut changed = document.clone();
            let mut numbers = Vec::new();
            collect(&mut changed, &mut numbers);
            *numbers.swap_remove(place) = value;
            if let Ok(scene) = read(&glb(&changed, &bytes[28 + json..])) {
                scene.pose(1.0);
            }
        }
    }
}

#[test]
fn changed_numbers_never_panic() {
    change_numbers(&VICTIM, 1);
}

#[test]
fn changed_numbers_of_a_skinned_file_never_panic() {
    if let Some(path) = common::shared_scene("CesiumMan.glb") {
        // A prime step: over 2,000 numbers, of which neighbours are alike.
        change_numbers(&std::fs::read(path).unwrap(), 23);
    }
}

fn collect<'a>(value: &'a mut Value, numbers: &mut Vec<&'a mut Value>) {
    match value {
        Value::Number(_) => numbers.push(value),
        Value::Array(list) => list.iter_mut().for_each(|v| collect(v, numbers)),
        Value::Object(map) => map.values_mut().for_each(|v| collect(v, numbers)),
        _ => {}
    }
}
