//! Comparing Monte Carlo estimates by their own noise.

/// Mean and variance of the mean of one estimate.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    pub variance: f64,
}

pub fn luminance(c: [f32; 4]) -> f64 {
    0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
}

/// A pixel's estimate from the moments (E[L], E[L^2]) of `samples` independent samples.
pub fn from_moments(moments: [f32; 4], samples: u32) -> Estimate {
    let (first, second) = (f64::from(moments[0]), f64::from(moments[1]));
    // n - 1 for the unbiased variance of one sample.
    let spread =
        (second - first * first).max(0.0) * f64::from(samples) / f64::from((samples - 1).max(1));
    Estimate {
        mean: first,
        variance: spread / f64::from(samples),
    }
}

/// The mean over independent pixels.
pub fn mean(pixels: &[Estimate]) -> Estimate {
    let n = pixels.len() as f64;
    Estimate {
        mean: pixels.iter().map(|p| p.mean).sum::<f64>() / n,
        variance: pixels.iter().map(|p| p.variance).sum::<f64>() / (n * n),
    }
}

/// How many standard deviations two independent estimates lie apart.
pub fn sigmas(a: Estimate, b: Estimate) -> f64 {
    (a.mean - b.mean) / (a.variance + b.variance).sqrt().max(1e-12)
}

/// From values of independent runs.
pub fn from_runs(runs: &[f64]) -> Estimate {
    let n = runs.len() as f64;
    let mean = runs.iter().sum::<f64>() / n;
    let spread = runs.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
    Estimate {
        mean,
        variance: spread / n,
    }
}
