//! The colour spaces of FLIP: YCxCz to filter in, Hunt-adjusted L*a*b* to compare in.

/// Linear Rec.709 RGB to XYZ; white is the sum of each row.
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [
        10_135_552.0 / 24_577_794.0,
        8_788_810.0 / 24_577_794.0,
        4_435_075.0 / 24_577_794.0,
    ],
    [
        2_613_072.0 / 12_288_897.0,
        8_788_810.0 / 12_288_897.0,
        887_015.0 / 12_288_897.0,
    ],
    [
        1_425_312.0 / 73_733_382.0,
        8_788_810.0 / 73_733_382.0,
        70_074_185.0 / 73_733_382.0,
    ],
];

/// D65, as the matrix above has it.
const WHITE: [f64; 3] = [
    XYZ_FROM_RGB[0][0] + XYZ_FROM_RGB[0][1] + XYZ_FROM_RGB[0][2],
    XYZ_FROM_RGB[1][0] + XYZ_FROM_RGB[1][1] + XYZ_FROM_RGB[1][2],
    XYZ_FROM_RGB[2][0] + XYZ_FROM_RGB[2][1] + XYZ_FROM_RGB[2][2],
];

const RGB_FROM_XYZ: [[f64; 3]; 3] = inverse(XYZ_FROM_RGB);

const fn inverse(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut adjugate = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 3 {
        let mut j = 0;
        while j < 3 {
            let (a, b) = ((j + 1) % 3, (j + 2) % 3);
            let (c, d) = ((i + 1) % 3, (i + 2) % 3);
            adjugate[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
            j += 1;
        }
        i += 1;
    }
    let determinant =
        m[0][0] * adjugate[0][0] + m[0][1] * adjugate[1][0] + m[0][2] * adjugate[2][0];
    let mut i = 0;
    while i < 9 {
        adjugate[i / 3][i % 3] /= determinant;
        i += 1;
    }
    adjugate
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ relative to white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = times(&XYZ_FROM_RGB, rgb);
    [x / WHITE[0], y / WHITE[1], z / WHITE[2]]
}

/// L*a*b* without its cube root, linear in RGB (2020, section 4.1.1).
pub fn ycxcz_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`ycxcz_from_rgb`].
pub fn rgb_from_ycxcz([l, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let [x, z] = [y + cx / 500.0, y - cz / 200.0];
    times(&RGB_FROM_XYZ, [x * WHITE[0], y * WHITE[1], z * WHITE[2]])
}

/// CIE L*a*b* with a* and b* scaled by L* / 100: what is dark has little colour (the Hunt effect; 2020,
/// equation 6).
pub fn hunt_lab_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb).map(lab_root);
    let l = 116.0 * y - 16.0;
    let hunt = 0.01 * l;
    [l, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// The cube root of CIE L*a*b*, with its linear part near black.
fn lab_root(t: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA {
        t.cbrt()
    } else {
        t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of f64 through two 3x3 products with values up to 500.
    const TOLERANCE: f64 = 1e-12;

    #[test]
    fn opponent_space_and_back() {
        for rgb in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.7, 0.4]] {
            let back = rgb_from_ycxcz(ycxcz_from_rgb(rgb));
            for (a, b) in back.iter().zip(rgb) {
                assert!((a - b).abs() < TOLERANCE, "{back:?} is not {rgb:?}");
            }
        }
    }

    #[test]
    fn greys_have_no_colour() {
        for (grey, lightness) in [(0.0, 0.0), (1.0, 100.0)] {
            let [l, a, b] = hunt_lab_from_rgb([grey; 3]);
            assert!((l - lightness).abs() < TOLERANCE);
            assert!(a.abs() < 1e-10 && b.abs() < 1e-10, "{a} {b}");
        }
    }

    #[test]
    fn white_is_d65() {
        for (found, given) in WHITE.iter().zip([0.950_428_545, 1.0, 1.088_900_371]) {
            // Given to nine digits.
            assert!((found - given).abs() < 1e-9);
        }
    }
}
