//! Texture lookups against a twin in f64.

use crate::support::*;
use glam::{Affine2, Vec2};
use scumble_scene::{Material, Scene, TextureImage, TextureRef, Wrap};

const KERNEL: &str = r#"
#include "scene/texture.wgsl"
fn item(i: u32) { output[i] = scene_texture(u32(input[i].z), input[i].xy); }
"#;

fn image(stream: &mut Stream, size: [u32; 2], srgb: bool, wrap: [Wrap; 2]) -> TextureImage {
    TextureImage {
        name: "noise".into(),
        width: size[0],
        height: size[1],
        rgba8: (0..4 * size[0] * size[1])
            .map(|_| (stream.next() * 256.0) as u8)
            .collect(),
        srgb,
        wrap,
    }
}

fn wrapped(i: i64, n: i64, wrap: Wrap) -> usize {
    let j = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            k.min(2 * n - 1 - k)
        }
    };
    j as usize
}

fn twin(image: &TextureImage, uv: [f64; 2]) -> [f64; 4] {
    let size = [image.width, image.height].map(f64::from);
    let at: [f64; 2] = std::array::from_fn(|k| uv[k] * size[k] - 0.5);
    let low = at.map(f64::floor);
    let mut sum = [0.0; 4];
    for (dy, dx) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let x = wrapped(low[0] as i64 + dx, image.width.into(), image.wrap[0]);
        let y = wrapped(low[1] as i64 + dy, image.height.into(), image.wrap[1]);
        let t = [at[0] - low[0], at[1] - low[1]];
        let weight = [1.0 - t[0], t[0]][dx as usize] * [1.0 - t[1], t[1]][dy as usize];
        for (c, s) in sum.iter_mut().enumerate() {
            let coded = f64::from(image.rgba8[4 * (y * image.width as usize + x) + c]) / 255.0;
            let linear = match (image.srgb && c < 3, coded <= 0.04045) {
                (false, _) => coded,
                (true, true) => coded / 12.92,
                (true, false) => ((coded + 0.055) / 1.055).powf(2.4),
            };
            *s += weight * linear;
        }
    }
    sum
}

#[test]
fn textures_are_filtered_and_wrapped_as_by_their_twin() {
    let mut stream = Stream(3);
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let sizes = [[1, 1], [7, 5], [33, 17], [64, 64]];
    let mut textures = Vec::new();
    for size in sizes {
        for u in wraps {
            for v in wraps {
                textures.push(image(&mut stream, size, textures.len() % 2 == 0, [u, v]));
            }
        }
    }
    let transform =
        Affine2::from_scale_angle_translation(Vec2::new(0.7, -1.3), 0.4, Vec2::new(0.2, 3.1));
    let materials = (0..textures.len() as u32)
        .map(|texture| Material {
            base_color_texture: Some(TextureRef { texture, transform }),
            ..Material::default()
        })
        .collect();
    let scene = Scene {
        textures: textures.clone(),
        materials,
        ..Scene::default()
    };
    let Some(gpu) = gpu_scene(scene) else { return };

    let mut queries = Vec::new();
    for slot in 0..textures.len() {
        for _ in 0..200 {
            let uv = stream.point(4.0);
            queries.push([uv.x, uv.y, slot as f32, 0.0]);
        }
        queries
            .extend([[0.0, 0.0], [1.0, 1.0], [-1.0, 0.5]].map(|[u, v]| [u, v, slot as f32, 0.0]));
    }
    let out: Vec<[f32; 4]> = run(&gpu, KERNEL, &queries, queries.len() as u32, queries.len());
    for (query, found) in queries.iter().zip(out) {
        let image = &textures[query[2] as usize];
        let uv = transform.transform_point2(Vec2::new(query[0], query[1]));
        let expected = twin(image, [uv.x.into(), uv.y.into()]);
        for c in 0..4 {
            // uv up to 10 in f32 errs by 1e-6, times 64 texels times a step of at most 1 between
            // two of them; sRGB's pow adds some 1e-6.
            let error = (f64::from(found[c]) - expected[c]).abs();
            assert!(
                error < 2e-4,
                "{query:?} {:?}: {found:?} {expected:?}",
                image.wrap
            );
        }
    }
}

#[test]
fn far_coordinates_stay_inside_their_texture() {
    let mut stream = Stream(4);
    let textures = vec![
        image(&mut stream, [5, 3], false, [Wrap::Repeat, Wrap::Mirror]),
        TextureImage {
            rgba8: vec![9; 4 * 15],
            ..image(&mut stream, [5, 3], false, [Wrap::Clamp; 2])
        },
    ];
    let materials = (0..2)
        .map(|t| Material {
            base_color_texture: Some(TextureRef::new(t)),
            ..Material::default()
        })
        .collect();
    let mut scene = Scene {
        textures,
        materials,
        ..Scene::default()
    };
    scene.textures[0].rgba8.fill(9);
    let Some(gpu) = gpu_scene(scene) else { return };
    let queries: Vec<[f32; 4]> = [1e4, -1e4, 1e9, -1e9, 1e20]
        .into_iter()
        .flat_map(|x| [[x, -x, 0.0, 0.0], [x, x, 1.0, 0.0]])
        .collect();
    let out: Vec<[f32; 4]> = run(&gpu, KERNEL, &queries, queries.len() as u32, queries.len());
    // Every texel is 9 / 255, whichever it is.
    assert!(
        out.iter().flatten().all(|c| (c - 9.0 / 255.0).abs() < 1e-6),
        "{out:?}"
    );
}
