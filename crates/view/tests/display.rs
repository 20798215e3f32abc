//! Pictures of ports on the GPU, against the equations of `display.wgsl` in f64.

mod common;

use common::gpu;
use scumble::{Signal, readback, signal};
use scumble_lab::Gpu;
use scumble_metrics::ColorMap;
use scumble_view::display::{
    Channels, Display, Look, Probe, Range, Settings, Statistics, components, ramp,
};
use wgpu::TextureFormat as F;

const LOW: f32 = -0.5;
const HIGH: f32 = 2.0;

/// A texture of 32-bit components.
fn texture(gpu: &Gpu, format: F, size: [u32; 2], texels: &[[u32; 4]]) -> wgpu::Texture {
    let count = components(format) as usize;
    let words: Vec<u32> = texels.iter().flat_map(|t| &t[..count]).copied().collect();
    let extent = wgpu::Extent3d {
        width: size[0],
        height: size[1],
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(size[0] * 4 * count as u32),
        rows_per_image: None,
    };
    let bytes = bytemuck::cast_slice(&words);
    let copy = texture.as_image_copy();
    gpu.queue.write_texture(copy, bytes, layout, extent);
    texture
}

/// Numbers of every kind: plain, negative, above the range, not finite, sky, a hole.
fn texels(integer: bool) -> Vec<[u32; 4]> {
    let mut word = 1_u32;
    let mut random = || {
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        word >> 8
    };
    let special = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        0.0,
        1e30,
        -1.0,
        1.0,
        65504.0,
    ];
    let float = |i: usize, x: u32| match i % 5 {
        4 => special[x as usize % special.len()],
        _ => x as f32 / (1 << 24) as f32 * 3.0 - 0.4,
    };
    let texel = |i: usize| {
        [0; 4].map(|_: u32| match integer {
            true if i.is_multiple_of(7) => 0,
            true => random() % 40,
            false => float(i, random()).to_bits(),
        })
    };
    (0..13 * 11).map(texel).collect()
}

/// The picture of a texel, from the equations.
fn twin(signal: Signal, settings: &Settings, format: F, texel: [u32; 4]) -> [f64; 3] {
    let look = Look::of(signal);
    let bits = {
        let mut bits = [0, 0, 0, 1.0_f32.to_bits()];
        if look.is_integer() {
            bits[3] = 1;
        }
        let count = components(format) as usize;
        bits[..count].copy_from_slice(&texel[..count]);
        bits
    };
    let one = match settings.channels {
        Channels::All => None,
        one => Some(one as usize - 1),
    };
    let gain = f64::from(settings.exposure).exp2();
    let (low, high) = (f64::from(LOW), f64::from(HIGH));
    let s = |x: f64| ((x - low) / (high - low)).clamp(0.0, 1.0);
    let map = |m: f64| {
        let at = 255.0 * s(m);
        let colours = ramp(settings.colours.unwrap());
        let (i, t) = (at.floor() as usize, at.fract());
        let next = colours[(i + 1).min(255)];
        [0, 1, 2].map(|c| (1.0 - t) * f64::from(colours[i][c]) + t * f64::from(next[c]))
    };
    let srgb = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        if x <= 0.0031308 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        }
    };
    let luminance = |v: &[f64; 4]| 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2];
    let false_colour = settings.colours.is_some();
    let rgb = |v: [f64; 4]| [v[0], v[1], v[2]];
    let grey = |v: [f64; 4], one: usize| [v[one]; 3];
    let shown = |v: [f64; 4]| one.map_or(rgb(v), |one| grey(v, one));
    let word = bits[one.unwrap_or(0)];
    let mut v = bits.map(|b| f64::from(f32::from_bits(b)));
    match look {
        Look::Mask => return [f64::from(u8::from(word != 0)); 3],
        Look::Identity if !false_colour => {
            let mut h = word;
            h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
            h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
            h ^= h >> 16;
            let channel = |shift: u32| 0.2 + 0.8 * f64::from((h >> shift) & 255) / 255.0;
            return if word == 0 {
                [0.0; 3]
            } else {
                [0, 8, 16].map(channel)
            };
        }
        Look::Identity | Look::Integers => {
            v = bits.map(f64::from);
            return match false_colour {
                true => map(v[one.unwrap_or(0)]),
                false => shown(v).map(|x| x / high),
            };
        }
        Look::Normal => {
            let snorm = |b: u32| (f64::from(b as u16 as i16) / 32767.0).max(-1.0);
            let (x, y) = (snorm(bits[0]), snorm(bits[0] >> 16));
            let z = 1.0 - x.abs() - y.abs();
            let (x, y) = match z >= 0.0 {
                true => (x, y),
                false => (
                    (1.0 - y.abs()) * if x >= 0.0 { 1.0 } else { -1.0 },
                    (1.0 - x.abs()) * if y >= 0.0 { 1.0 } else { -1.0 },
                ),
            };
            let n = (x * x + y * y + z * z).sqrt();
            v = [x / n, y / n, z / n, 0.0];
            return match false_colour {
                true => map(v[one.unwrap_or(1)]),
                false => shown(v).map(|x| 0.5 * x + 0.5),
            };
        }
        _ => {}
    }
    if v[..components(format) as usize]
        .iter()
        .any(|x| !x.is_finite())
    {
        return if settings.highlight {
            [1.0, 0.0, 1.0]
        } else {
            [0.0; 3]
        };
    }
    let may_be_negative = !look.is_light() && look != Look::Scalar;
    if settings.highlight && !may_be_negative && shown(v).iter().any(|x| *x < 0.0) {
        return [0.0, 0.35, 1.0];
    }
    if look == Look::Encoded {
        if gain == 1.0 && one.is_none() && !false_colour {
            return rgb(v);
        }
        let linear = |x: f64| {
            if x <= 0.04045 {
                x / 12.92
            } else {
                ((x + 0.055) / 1.055).powf(2.4)
            }
        };
        for x in &mut v[..3] {
            *x = linear(*x);
        }
    }
    if look.is_light() {
        for x in &mut v[..3] {
            *x *= gain;
        }
    }
    let sky = v[0] >= 0.5e30;
    if (look == Look::Scalar && sky) || (look == Look::Depth && (sky || v[0] < 0.0)) {
        return [0.0; 3];
    }
    if false_colour {
        return map(match (one, look) {
            (Some(one), _) => v[one],
            (None, Look::Light | Look::Encoded) => luminance(&v),
            (None, Look::Signed) => (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt(),
            (None, _) => v[0],
        });
    }
    match look {
        Look::Light | Look::Encoded => shown(v).map(srgb),
        Look::Signed => shown(v).map(|x| 0.5 + 0.5 * x / high.max(-low)),
        _ => [s(v[one.unwrap_or(0)]); 3],
    }
}

#[test]
fn every_look_is_its_equation() {
    let Some(gpu) = gpu() else { return };
    let mut display = Display::new(&gpu.device, &gpu.queue).unwrap();
    let signals = [
        (signal::RADIANCE, F::Rgba32Float),
        (signal::DISPLAY, F::Rgba32Float),
        (signal::AGE, F::R32Float),
        (signal::VIEW_Z, F::R32Float),
        (signal::MOTION, F::Rg32Float),
        (signal::POSITION, F::Rgba32Float),
        (signal::NORMAL, F::R32Uint),
        (signal::PIXEL, F::Rg32Uint),
        (signal::SURFACE_ID, F::R32Uint),
        (signal::MASK, F::R32Uint),
    ];
    let size = [13, 11];
    for (signal, format) in signals {
        let words = match Look::of(signal) {
            // All bits of a normal count.
            Look::Normal => (0..143)
                .map(|i: u32| [i.wrapping_mul(0x9e37_79b9); 4])
                .collect(),
            look => texels(look.is_integer()),
        };
        let port = texture(gpu, format, size, &words);
        for &(channels, _) in Channels::among(components(format)) {
            for colours in [None, Some(ColorMap::Magma)] {
                for (highlight, exposure) in [(true, 0.0), (false, 1.5)] {
                    let settings = Settings {
                        channels,
                        exposure,
                        colours,
                        range: Range::Fixed(LOW, HIGH),
                        highlight,
                    };
                    let mut encoder = gpu.device.create_command_encoder(&Default::default());
                    let painted = display.paint(&mut encoder, &port, signal, &settings, None);
                    let painted = painted.unwrap().clone();
                    gpu.finish(encoder).unwrap();
                    let shown = readback(&gpu.device, &gpu.queue, &painted).unwrap();
                    for (i, (shown, words)) in shown.iter().zip(&words).enumerate() {
                        let wanted = twin(signal, &settings, format, *words);
                        for c in 0..3 {
                            let off = f64::from(shown[c]) - wanted[c].clamp(0.0, 1.0);
                            // Half of the last of 8 bits, and f32's pow, which may be some of its last bits off.
                            let most = 0.5 / 255.0 + 2e-4;
                            assert!(
                                off.abs() <= most,
                                "{signal}, {settings:?}, texel {i} {words:08x?}: {shown:?}, not {wanted:?}"
                            );
                        }
                        assert_eq!(shown[3], 1.0, "opaque");
                    }
                }
            }
        }
    }
}

#[test]
fn a_picture_stays_the_same_texture_while_the_size_does() {
    let Some(gpu) = gpu() else { return };
    let mut display = Display::new(&gpu.device, &gpu.queue).unwrap();
    let mut paint = |size: [u32; 2]| {
        let words = vec![[7; 4]; (size[0] * size[1]) as usize];
        let port = texture(gpu, F::R32Uint, size, &words);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let settings = Settings::default();
        let painted = display.paint(&mut encoder, &port, signal::MASK, &settings, None);
        let painted = painted.unwrap().clone();
        gpu.finish(encoder).unwrap();
        painted
    };
    let first = paint([1, 1]);
    assert_eq!(paint([1, 1]), first);
    let wide = paint([9, 1]);
    assert_ne!(wide, first);
    assert_eq!([wide.width(), wide.height()], [9, 1]);
}

#[test]
fn the_value_under_the_cursor_has_every_bit() {
    let Some(gpu) = gpu() else { return };
    let awkward = 0x3eaa_aaab_u32;
    let mut words = vec![[0; 4]; 6];
    words[4] = [awkward, f32::NAN.to_bits(), 0, 0];
    let port = texture(gpu, F::Rg32Float, [3, 2], &words);
    let mut probe = Probe::default();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    probe
        .look(&gpu.device, &mut encoder, &port, signal::MOTION, [1, 1])
        .unwrap();
    gpu.queue.submit([encoder.finish()]);
    probe.submitted();
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap();
    let texel = probe.latest().unwrap().unwrap().to_string();
    assert_eq!(texel, "(1, 1): 0.33333334, NaN");
    assert_eq!("0.33333334".parse::<f32>().unwrap().to_bits(), awkward);
}

#[test]
fn statistics_agree_with_what_is_painted() {
    // What is painted magenta is counted, and so is what is painted blue.
    let words = texels(false);
    let texels: Vec<[f32; 4]> = words.iter().map(|t| t.map(f32::from_bits)).collect();
    let settings = Settings::default();
    let found = Statistics::of(signal::RADIANCE, 4, &settings, &texels);
    let painted = |colour: [f64; 3]| {
        let of = |words: &&[u32; 4]| {
            twin(signal::RADIANCE, &settings, F::Rgba32Float, **words) == colour
        };
        words.iter().filter(of).count()
    };
    assert_eq!(found.not_finite, painted([1.0, 0.0, 1.0]));
    assert_eq!(found.negative, painted([0.0, 0.35, 1.0]));
    assert!(found.not_finite > 0 && found.negative > 0);
}
