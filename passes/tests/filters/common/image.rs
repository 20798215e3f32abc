//! Images in f64, and random ones with sky, holes and a bad texel.

use half::f16;

/// Sizes every kernel must be right at: one texel, odd sides smaller and larger than a workgroup, and whole workgroups.
pub const SIZES: [[u32; 2]; 4] = [[1, 1], [7, 5], [33, 17], [64, 64]];

/// What a texture holds, exactly.
#[derive(Clone)]
pub struct Image {
    pub size: [u32; 2],
    pub texels: Vec<[f64; 4]>,
}

impl Image {
    pub fn new(size: [u32; 2], mut texel: impl FnMut([u32; 2]) -> [f64; 4]) -> Image {
        let texels = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| [x, y]))
            .map(&mut texel)
            .collect();
        Image { size, texels }
    }

    pub fn at(&self, p: [u32; 2]) -> [f64; 4] {
        self.texels[(p[1] * self.size[0] + p[0]) as usize]
    }

    pub fn x(&self, p: [u32; 2]) -> f64 {
        self.at(p)[0]
    }

    /// Every texel with its place.
    pub fn map<T>(&self, f: impl Fn([u32; 2]) -> T) -> Vec<T> {
        (0..self.texels.len() as u32)
            .map(|i| f([i % self.size[0], i / self.size[0]]))
            .collect()
    }

    /// The places within `radius` of `p`, `p` included.
    pub fn window(&self, p: [u32; 2], radius: u32) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [w, h] = self.size;
        let (x, y) = (
            p[0].saturating_sub(radius)..=(p[0] + radius).min(w - 1),
            p[1].saturating_sub(radius)..=(p[1] + radius).min(h - 1),
        );
        y.flat_map(move |y| x.clone().map(move |x| [x, y]))
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `[low, high)`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A texel of light over four orders of magnitude, representable in f16 and so in f32.
    pub fn light(&mut self) -> [f64; 4] {
        let base = self.range(-4.0, 4.0).exp();
        [0, 1, 2, 3].map(|_| f16::from_f64(base * self.range(0.2, 1.0)).to_f64())
    }

    /// Light with one texel that is not a number.
    pub fn light_with_a_bad_texel(&mut self, size: [u32; 2]) -> Image {
        let mut image = Image::new(size, |_| self.light());
        let bad = self.bits() as usize % image.texels.len();
        image.texels[bad][0] = f64::NAN;
        image
    }

    /// Two tilted, noisy surfaces that meet in the middle at a step in depth; one texel in ten is sky and one in ten a hole.
    pub fn guides(&mut self, size: [u32; 2]) -> Guides {
        let mut normals = Vec::new();
        let view_z = Image::new(size, |p| {
            let right = 2 * p[0] > size[0];
            let tilt = if right { [0.6, 0.2] } else { [-0.1, 0.3] };
            let n = [
                tilt[0] + self.range(-0.1, 0.1),
                tilt[1] + self.range(-0.1, 0.1),
                if right { -0.5 } else { 1.0 },
            ];
            normals.push(f64::from(octahedral_encode(n)));
            let surface =
                if right { 5.0 } else { 3.0 } + 0.02 * f64::from(p[0]) + self.range(0.0, 0.1);
            let kind = self.bits() % 10;
            let z = match kind {
                0 => 1e30,
                1 => -1.0,
                _ => surface,
            };
            [f64::from(z as f32), 0.0, 0.0, 1.0]
        });
        let mut normals = normals.into_iter();
        let normal = Image::new(size, |_| [normals.next().unwrap(), 0.0, 0.0, 1.0]);
        Guides { view_z, normal }
    }
}

/// Depth and packed normals.
pub struct Guides {
    pub view_z: Image,
    pub normal: Image,
}

impl Guides {
    /// A depth that carries a surface.
    pub fn is_surface(&self, p: [u32; 2]) -> bool {
        is_surface(self.view_z.x(p))
    }

    pub fn normal(&self, p: [u32; 2]) -> [f64; 3] {
        octahedral_decode(self.normal.x(p) as u32)
    }

    /// |n_p - n_q|^2.
    pub fn normal_distance(&self, p: [u32; 2], other: &Guides, q: [u32; 2]) -> f64 {
        let (a, b) = (self.normal(p), other.normal(q));
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum()
    }
}

/// Neither sky (1e30) nor a hole (-1).
pub fn is_surface(z: f64) -> bool {
    z > 0.0 && z < 1e29
}

/// Rec. 709.
pub fn luminance(c: [f64; 4]) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

pub fn is_finite(c: [f64; 4]) -> bool {
    c.iter().all(|v| v.is_finite())
}

fn octahedral_encode(n: [f64; 3]) -> u32 {
    let l1 = n.iter().map(|v| v.abs()).sum::<f64>();
    let [x, y, z] = n.map(|v| v / l1);
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    let (u, v) = if z >= 0.0 {
        (x, y)
    } else {
        ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
    };
    let snorm = |v: f64| u32::from((v * 32767.0).round() as i16 as u16);
    snorm(u) | snorm(v) << 16
}

fn octahedral_decode(packed: u32) -> [f64; 3] {
    let snorm = |v: u32| (f64::from(v as u16 as i16) / 32767.0).max(-1.0);
    let (u, v) = (snorm(packed & 0xffff), snorm(packed >> 16));
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    let z = 1.0 - u.abs() - v.abs();
    let (x, y) = if z >= 0.0 {
        (u, v)
    } else {
        ((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v))
    };
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}
