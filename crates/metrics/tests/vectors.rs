//! Known numbers: an analytic 64x64 pair whose metrics were computed by NumPy and
//! scikit-image, and images of other sizes.

mod images;

use images::{map, near, noise, noisy_pair, reference, test};
use scumble_metrics::{
    Image, Metric, MetricsError, Role, block_error, energy, error_map, flip, hdr_flip, mape,
    ms_ssim, mse, psnr, relmse, relmse_trimmed, rmse, smape, ssim, ssim_luma,
};

/// The expected numbers have nine or more digits; the images are equal to those they were computed
/// from but for the last bit of a few f32 values (6e-8), which moves a mean by far less than this.
const TOLERANCE: f64 = 1e-8;

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

/// Numbers by a NumPy transcription of the definitions, in f64 from the same f32 values.
#[test]
fn relative_errors_of_any_size() {
    for (width, height, numbers) in [
        (
            101,
            63,
            [
                0.230_667_979_170,
                1.588_224_607_422,
                0.918_840_499_766,
                1.457_844_086_484,
                1.439_914_662_179,
                0.992_436_354_271,
            ],
        ),
        (
            7,
            2,
            [
                0.403_616_050_611,
                4.435_375_486_190,
                1.438_958_700_418,
                4.885_690_849_245,
                4.885_690_849_245,
                4.885_690_849_245,
            ],
        ),
    ] {
        let [x, r] = noisy_pair(width, height).map(|image| map(&image, |v| v * v * 8.0));
        let trimmed = |fraction| relmse_trimmed(&x, &r, fraction);
        let found = [
            smape(&x, &r),
            mape(&x, &r),
            energy(&x, &r),
            relmse(&x, &r),
            trimmed(0.001),
            trimmed(0.05),
        ];
        for (found, expected) in found.into_iter().zip(numbers) {
            near(found.unwrap(), expected, TOLERANCE);
        }
    }
    let [x, r] = noisy_pair(1, 1).map(|image| map(&image, |v| v * v * 8.0));
    near(smape(&x, &r).unwrap(), 0.969_158_831_637, TOLERANCE);
    near(mape(&x, &r).unwrap(), 32.488_664_487_998, TOLERANCE);
    // The one pixel of the reference is black.
    assert!(matches!(
        energy(&x, &r),
        Err(MetricsError::BlackReference { .. })
    ));
    for fraction in [-0.1, 1.0, f64::NAN] {
        assert!(matches!(
            relmse_trimmed(&x, &r, fraction),
            Err(MetricsError::Fraction { .. })
        ));
    }
}

/// Numbers by a NumPy transcription of the definition, in f64 from the same f32 values.
#[test]
fn five_scales() {
    for (width, height, expected, one_scale) in [
        (161, 161, 0.951_564_831_690, 0.869_692_951_596),
        (163, 178, 0.951_588_318_646, 0.869_864_608_048),
    ] {
        let [x, r] = noisy_pair(width, height);
        near(ms_ssim(&x, &r).unwrap(), expected, TOLERANCE);
        near(ssim(&x, &r).unwrap(), one_scale, TOLERANCE);
    }
    let r = noise(170, 165, 3);
    // Each scale's quotients have equal numerators and denominators up to f64 rounding.
    near(ms_ssim(&r, &r).unwrap(), 1.0, 1e-12);
    // What is inverted has a negative structure, which counts as none.
    assert_eq!(ms_ssim(&map(&r, |v| 1.0 - v), &r).unwrap(), 0.0);
}

#[test]
fn maps_have_the_mean_of_their_metric() {
    let [x, r] = noisy_pair(45, 31);
    for metric in Metric::ALL.into_iter().filter(|m| m.has_map()) {
        let error = error_map(metric, &x, &r).unwrap();
        assert_eq!(error.data.len(), 45 * 31);
        let value = metric.evaluate(&x, &r);
        match metric {
            Metric::Rmse => near(
                error.data.iter().map(|v| v * v).sum::<f64>() / (45.0 * 31.0),
                mse(&x, &r).unwrap(),
                TOLERANCE,
            ),
            // The mean over what is not border.
            Metric::Ssim => {
                let inner = (5..26).flat_map(|y| (5..40).map(move |x| (x, y)));
                let sum: f64 = inner.map(|(x, y)| error.get(x, y).unwrap()).sum();
                near(1.0 - sum / (35.0 * 21.0), value.unwrap(), TOLERANCE);
                assert_eq!(error.get(0, 30), error.get(5, 25));
            }
            _ => near(error.mean(), value.unwrap(), TOLERANCE),
        }
    }
    assert_eq!(
        error_map(Metric::Psnr, &x, &r).unwrap_err().to_string(),
        "psnr is of a whole image and has no map; \
         there are maps of mse, rmse, relmse, ssim, flip, hdr_flip, smape, mape"
    );
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
        let metrics = [
            mse, relmse, psnr, ssim, ssim_luma, smape, energy, flip, hdr_flip,
        ];
        let values = metrics.map(|f| f(&x, &r).unwrap().to_bits());
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
        "lpips".parse::<Metric>().unwrap_err().to_string(),
        "there is no metric `lpips`; \
         there are mse, rmse, relmse, psnr, ssim, ms_ssim, flip, hdr_flip, smape, mape, energy"
    );
}
