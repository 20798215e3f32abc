//! Known numbers: an analytic 64x64 pair whose metrics were computed by NumPy and scikit-image.

use scumble_metrics::{
    Image, MetricsError, Role, block_error, mse, psnr, relmse, rmse, ssim, ssim_luma,
};

/// ref = (x/63, y/63, checker of 8), tst = clamp(0.9 ref + 0.05 sin(0.7x) cos(0.3y), 0, 1).
fn reference(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        let checker = f64::from((x / 8 + y / 8) % 2);
        [f64::from(x) / 63.0, f64::from(y) / 63.0, checker].map(|v| v as f32)
    })
}

fn test(width: u32, height: u32) -> Image {
    Image::from_fn(width, height, |x, y| {
        let checker = f64::from((x / 8 + y / 8) % 2);
        let (x, y) = (f64::from(x), f64::from(y));
        let wave = 0.05 * (0.7 * x).sin() * (0.3 * y).cos();
        [x / 63.0, y / 63.0, checker].map(|v| (0.9 * v + wave).clamp(0.0, 1.0) as f32)
    })
}

/// The expected numbers have nine or more digits; the images are equal to those they were computed
/// from but for the last bit of a few f32 values (6e-8), which moves a mean by far less than this.
const TOLERANCE: f64 = 1e-8;

#[track_caller]
fn near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is not {expected} ± {tolerance}"
    );
}

#[test]
fn the_analytic_pair() {
    let (x, r) = (test(64, 64), reference(64, 64));
    // The published vector, rounded to nine and to six digits, computed in f32: hence 1e-6.
    near(mse(&x, &r).unwrap(), 0.004_471_438, 1e-6);
    near(psnr(&x, &r).unwrap(), 23.495_528, 1e-6);
    near(relmse(&x, &r).unwrap(), 0.018_142_514, 1e-6);
    near(ssim(&x, &r).unwrap(), 0.859_564, 1e-6);
    // The same in f64.
    near(mse(&x, &r).unwrap(), 0.004_471_436_970, TOLERANCE);
    near(
        rmse(&x, &r).unwrap(),
        0.004_471_436_970_f64.sqrt(),
        TOLERANCE,
    );
    near(relmse(&x, &r).unwrap(), 0.018_142_510_543, TOLERANCE);
    near(ssim(&x, &r).unwrap(), 0.859_564_054_680, TOLERANCE);
    near(ssim_luma(&x, &r).unwrap(), 0.851_815_331_880, TOLERANCE);
    // An image that is not square.
    near(
        ssim(&test(64, 40), &reference(64, 40)).unwrap(),
        0.855_942_422,
        TOLERANCE,
    );
}

#[test]
fn block_means_of_the_analytic_pair() {
    let error = block_error(&test(64, 64), &reference(64, 64)).unwrap();
    near(error.mean, -0.096_283_026, TOLERANCE);
    near(error.median, 0.095_878_019, TOLERANCE);
    near(error.p95, 0.098_961_590, TOLERANCE);
    near(error.max, 0.099_213_141, TOLERANCE);
}

#[test]
fn equal_images() {
    let r = reference(32, 32);
    assert_eq!(mse(&r, &r).unwrap(), 0.0);
    assert_eq!(relmse(&r, &r).unwrap(), 0.0);
    assert_eq!(psnr(&r, &r).unwrap(), f64::INFINITY);
    // Each position's quotient has equal numerator and denominator up to f64 rounding.
    near(ssim(&r, &r).unwrap(), 1.0, 1e-12);
    assert_eq!(block_error(&r, &r).unwrap().max, 0.0);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let (x, r) = (test(61, 47), reference(61, 47));
    let all = || {
        let values = [mse, relmse, psnr, ssim, ssim_luma].map(|f| f(&x, &r).unwrap().to_bits());
        (values, block_error(&x, &r).unwrap())
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(all)
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn bad_pairs_are_refused() {
    let (x, r) = (test(16, 8), reference(16, 8));
    let text = |e: Result<f64, MetricsError>| e.unwrap_err().to_string();
    assert_eq!(
        text(mse(&x, &reference(8, 8))),
        "the sizes differ: the image is 16x8, the reference 8x8"
    );
    assert_eq!(
        text(ssim(&x, &r)),
        "SSIM needs an image of at least 11x11; this one is 16x8"
    );
    let mut nan = r.clone();
    nan.data[16 + 3][1] = f32::NAN;
    nan.data[20][0] = f32::INFINITY;
    assert_eq!(
        text(mse(&x, &nan)),
        "the reference has NaN in channel 1 at x 3, y 1, and 2 such values in all"
    );
    assert!(matches!(
        relmse(&nan, &r),
        Err(MetricsError::NotFinite {
            role: Role::Image,
            ..
        })
    ));
    let empty = Image {
        width: 0,
        height: 4,
        data: Vec::new(),
    };
    assert_eq!(
        text(mse(&empty, &empty)),
        "the image is 0x4: it has no pixels"
    );
    let short = Image {
        width: 2,
        height: 2,
        data: vec![[0.0; 3]; 3],
    };
    assert_eq!(
        text(mse(&short, &short)),
        "2x2 pixels were promised, 3 were given"
    );
    let black = Image::from_fn(16, 16, |_, _| [0.0; 3]);
    assert_eq!(
        block_error(&black, &black).unwrap_err().to_string(),
        "the mean of the reference is 0: there is nothing to be relative to"
    );
    assert_eq!(
        x.box_downsample(3).unwrap_err().to_string(),
        "16x8 does not divide into blocks of 3x3"
    );
    assert_eq!(
        "flip"
            .parse::<scumble_metrics::Metric>()
            .unwrap_err()
            .to_string(),
        "there is no metric `flip`; there are mse, rmse, relmse, psnr, ssim"
    );
}
