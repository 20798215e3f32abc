//! Student's t distribution.

/// ln Γ(x) for x > 0 (Lanczos 1964, g = 7, nine terms).
fn ln_gamma(x: f64) -> f64 {
    const TERMS: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum: f64 = TERMS[1..]
        .iter()
        .zip(1..)
        .fold(TERMS[0], |sum, (term, i)| sum + term / (x + f64::from(i)));
    let t = x + 7.5;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// The regularised incomplete beta function I_x(a, b), by its continued fraction (DLMF 8.17.22) with the
/// recurrence of Lentz 1976.
fn beta_regularised(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The fraction converges quickly below the mean; above it the other tail is taken.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_regularised(1.0 - x, b, a);
    }
    let front = ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln();
    let away_from_zero = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for m in 1..=500 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut step = 1.0;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            step = c * d;
            fraction *= step;
        }
        if (step - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front.exp() * fraction / a
}

/// P(T <= t) with `freedom` degrees of freedom.
fn cumulative(t: f64, freedom: f64) -> f64 {
    let tail = 0.5 * beta_regularised(freedom / (freedom + t * t), 0.5 * freedom, 0.5);
    if t > 0.0 { 1.0 - tail } else { tail }
}

/// The t with P(|T| <= t) = `level`, with `freedom` degrees of freedom.
///
/// ```
/// // The classic table: 95 %, 3 degrees of freedom.
/// assert!((scumble_lab::student_t(0.95, 3) - 3.182446).abs() < 1e-6);
/// ```
pub fn student_t(level: f64, freedom: u32) -> f64 {
    let (freedom, wanted) = (f64::from(freedom.max(1)), 0.5 + 0.5 * level);
    let (mut low, mut high) = (0.0, 1.0);
    while cumulative(high, freedom) < wanted && high < 1e12 {
        high *= 2.0;
    }
    // Each step halves the interval; 100 of them leave less than an ulp.
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if cumulative(middle, freedom) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Relative; rounding of the fraction and of ln Γ is near 1e-14, magnified by the flat tails.
    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn one_degree_is_cauchy_and_two_have_a_root() {
        for level in [0.5, 0.9, 0.95, 0.99] {
            close(student_t(level, 1), (0.5 * PI * level).tan());
            // F(t) = 1/2 + t / (2 sqrt(2 + t^2)).
            close(
                student_t(level, 2),
                level * (2.0 / (1.0 - level * level)).sqrt(),
            );
        }
    }

    #[test]
    fn many_degrees_are_normal() {
        // Hill 1970, first terms of the expansion about the normal quantile.
        let z = 1.959_963_984_540_054_f64;
        let n = 10_000.0;
        let expanded = z + (z.powi(3) + z) / (4.0 * n);
        // The next term is of order 1/n^2.
        assert!((student_t(0.95, 10_000) - expanded).abs() < 1e-7);
    }

    #[test]
    fn an_independent_quadrature_of_the_density_agrees() {
        for freedom in [3u32, 4, 7, 15, 31] {
            let n = f64::from(freedom);
            let norm = (ln_gamma(0.5 * (n + 1.0)) - ln_gamma(0.5 * n)).exp() / (n * PI).sqrt();
            let density = |t: f64| norm * (1.0 + t * t / n).powf(-0.5 * (n + 1.0));
            let t = student_t(0.95, freedom);
            // Simpson's rule with 2000 intervals: its error is far below 1e-10 here.
            let h = t / 2000.0;
            let inner: f64 = (1..2000)
                .map(|i| f64::from(2 + 2 * (i % 2)) * density(f64::from(i) * h))
                .sum();
            let area = 2.0 * h / 3.0 * (density(0.0) + inner + density(t));
            assert!((area - 0.95).abs() < 1e-9, "{freedom}: {area}");
        }
    }

    #[test]
    fn gamma_of_halves_and_whole_numbers() {
        close(ln_gamma(0.5), 0.5 * PI.ln());
        close(ln_gamma(10.0), 362_880f64.ln());
    }
}
