//! What several seeds say: means, their intervals, paired differences, effects of a factorial design.

use crate::student::student_t;
use serde::Serialize;

/// The level of every interval.
pub const LEVEL: f64 = 0.95;

/// A mean over seeds and its 95 % interval: mean ± `half`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Half the length of the interval, t(n - 1) s / sqrt(n); `None` of a single value.
    pub half: Option<f64>,
    /// How many values there are.
    pub count: usize,
}

impl Estimate {
    /// Of values that are independent and roughly normal: one of each seed. `None` of none.
    ///
    /// ```
    /// use scumble_lab::Estimate;
    /// let estimate = Estimate::of(&[1.0, 2.0, 3.0]).unwrap();
    /// assert_eq!(estimate.mean, 2.0);
    /// // s = 1, t(2) = 4.302653.
    /// assert!((estimate.half.unwrap() - 4.302653 / 3f64.sqrt()).abs() < 1e-6);
    /// ```
    pub fn of(values: &[f64]) -> Option<Estimate> {
        let count = values.len();
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let half = (count > 1).then(|| {
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let deviation = (squares / (n - 1.0)).sqrt();
            student_t(LEVEL, count as u32 - 1) * deviation / n.sqrt()
        });
        Some(Estimate { mean, half, count })
    }

    /// Of the differences of two series by seed. `None` where they are of different length or empty.
    pub fn paired(values: &[f64], base: &[f64]) -> Option<Estimate> {
        if values.len() != base.len() {
            return None;
        }
        let differences: Vec<f64> = values.iter().zip(base).map(|(v, b)| v - b).collect();
        Estimate::of(&differences)
    }

    /// Whether the interval leaves out 0.
    pub fn is_significant(&self) -> bool {
        self.half.is_some_and(|half| self.mean.abs() > half)
    }
}

/// What making changes does, of a 2^k design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Positions of the changes: one for a main effect, several for their interaction.
    pub factors: Vec<usize>,
    /// Main effect: mean with the change less mean without. Interaction of two: half of how much the second
    /// alters the effect of the first, and so on.
    pub estimate: Estimate,
}

/// Main effects and interactions. `values[c]` are those of combination c by seed, where bit i of c says whether
/// change i is made; there are 2^k combinations. `None` where one is missing or has other seeds.
///
/// ```
/// // y = 10 + 4 a - 6 b + 2 a b for a, b in {0, 1}; two seeds that differ by 1.
/// let at = |a: f64, b: f64| 10.0 + 4.0 * a - 6.0 * b + 2.0 * a * b;
/// let values: Vec<Vec<f64>> = (0..4)
///     .map(|c| at(f64::from(c & 1), f64::from(c >> 1)))
///     .map(|y| vec![y, y + 1.0])
///     .collect();
/// let effects = scumble_lab::effects(&values).unwrap();
/// let means: Vec<f64> = effects.iter().map(|e| e.estimate.mean).collect();
/// assert_eq!(means, [5.0, -5.0, 1.0]);
/// ```
pub fn effects(values: &[Vec<f64>]) -> Option<Vec<Effect>> {
    let combinations = values.len();
    let seeds = values.first()?.len();
    if !combinations.is_power_of_two() || values.iter().any(|v| v.len() != seeds) {
        return None;
    }
    let k = combinations.trailing_zeros() as usize;
    let mut subsets: Vec<usize> = (1..combinations).collect();
    subsets.sort_by_key(|s| (s.count_ones(), *s));
    let effect = |subset: usize| {
        let contrast = |seed: usize| {
            let signed = values.iter().enumerate().map(|(c, v)| {
                let missing = (subset & !c).count_ones();
                if missing.is_multiple_of(2) {
                    v[seed]
                } else {
                    -v[seed]
                }
            });
            signed.sum::<f64>() / (combinations / 2).max(1) as f64
        };
        let contrasts: Vec<f64> = (0..seeds).map(contrast).collect();
        Some(Effect {
            factors: (0..k).filter(|i| subset >> i & 1 == 1).collect(),
            estimate: Estimate::of(&contrasts)?,
        })
    };
    subsets.into_iter().map(effect).collect()
}

/// The value below which the fraction `p` of the values lies, between the nearest two (Hyndman and Fan 1996,
/// definition 7). `None` of none.
pub fn quantile(values: &[f64], p: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = p.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + (high - low) * at.fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) that look random (Marsaglia 2003).
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    #[test]
    fn an_interval_holds_the_truth_as_often_as_it_says() {
        let mut next = numbers(7);
        let mut normal = move || (0..12).map(|_| next()).sum::<f64>() - 6.0;
        let trials = 4000;
        let held = (0..trials).filter(|_| {
            let values: Vec<f64> = (0..4).map(|_| 3.0 + normal()).collect();
            let estimate = Estimate::of(&values).unwrap();
            (estimate.mean - 3.0).abs() <= estimate.half.unwrap()
        });
        let rate = held.count() as f64 / f64::from(trials);
        // The standard deviation of the rate is 0.0034: four of them, and the sum of 12 is nearly normal.
        assert!((rate - 0.95).abs() < 0.015, "{rate}");
    }

    #[test]
    fn pairing_takes_away_what_seeds_share() {
        let base = [1.0, 5.0, 9.0, 2.0];
        let better: Vec<f64> = base.iter().map(|v| v - 0.5).collect();
        let estimate = Estimate::paired(&better, &base).unwrap();
        assert_eq!((estimate.mean, estimate.half), (-0.5, Some(0.0)));
        assert!(estimate.is_significant());
        assert!(!Estimate::of(&base).unwrap().is_significant());
        assert_eq!(Estimate::paired(&better[1..], &base), None);
    }

    #[test]
    fn one_value_has_no_interval() {
        let estimate = Estimate::of(&[2.0]).unwrap();
        assert_eq!((estimate.mean, estimate.half), (2.0, None));
        assert!(!estimate.is_significant());
        assert_eq!(Estimate::of(&[]), None);
    }

    /// Least squares of the coded model y = b0 + Σ b_S Π_{i in S} x_i, x = ±1, is the independent computation:
    /// an effect is twice its coefficient. The columns are orthogonal, so b_S = <column, y> / 2^k.
    #[test]
    fn effects_are_twice_the_coefficients_of_the_coded_model() {
        let mut next = numbers(3);
        let values: Vec<Vec<f64>> = (0..8).map(|_| vec![next(), next(), next()]).collect();
        let found = effects(&values).unwrap();
        assert_eq!(found.len(), 7);
        for effect in &found {
            let x = |c: usize, i: usize| if c >> i & 1 == 1 { 1.0 } else { -1.0 };
            let column = |c: usize| effect.factors.iter().map(|&i| x(c, i)).product::<f64>();
            let mean = |c: usize| values[c].iter().sum::<f64>() / 3.0;
            let coefficient = (0..8).map(|c| column(c) * mean(c)).sum::<f64>() / 8.0;
            assert!((effect.estimate.mean - 2.0 * coefficient).abs() < 1e-12);
        }
        assert_eq!(found[0].factors, [0]);
        assert_eq!(found[3].factors, [0, 1]);
        assert_eq!(effects(&values[..3]), None);
    }

    #[test]
    fn quantiles_lie_between() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(&values, 0.5), Some(2.5));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 1.0), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
