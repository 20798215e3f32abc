//! FLIP against numbers by the authors' program (flip-evaluator 1.7, `applyMagma=False`).

mod images;

use images::{map, near, noise, noisy_pair, reference, test};
use scumble_metrics::{
    Exposures, FLIP_PIXELS_PER_DEGREE, Image, flip, flip_map, hdr_flip, hdr_flip_map,
};

/// Their program computes in f32 and prints six digits; where colours are nearly equal the exponents of
/// FLIP make 1e-7 into 1e-5.
const TOLERANCE: f64 = 1e-4;

#[test]
fn the_analytic_pair() {
    let (x, r) = (test(64, 64), reference(64, 64));
    let display = flip_map(&x, &r, FLIP_PIXELS_PER_DEGREE).unwrap();
    let (dx, dr) = (x.to_display(), r.to_display());
    let linear = flip_map(&dx, &dr, FLIP_PIXELS_PER_DEGREE).unwrap();
    let radiance = |image: &Image| map(image, |v| 8.0 * v.powf(2.2));
    let (hx, hr) = (radiance(&x), radiance(&r));
    let exposures = Exposures::of(&hr).unwrap();
    near(exposures.start, -1.835_231, TOLERANCE);
    near(exposures.stop, -0.048_922, TOLERANCE);
    assert_eq!(exposures.count, 2);
    let hdr = hdr_flip_map(&hx, &hr, FLIP_PIXELS_PER_DEGREE, exposures).unwrap();
    for (map, [mean, max, corner, middle]) in [
        (display, [0.339_512, 0.613_170, 0.035_395, 0.256_452]),
        (linear, [0.217_560, 0.445_125, 0.288_103, 0.133_860]),
        (hdr, [0.268_418, 0.606_835, 0.027_772, 0.254_562]),
    ] {
        near(map.mean(), mean, TOLERANCE);
        near(map.statistics().max, max, TOLERANCE);
        near(map.get(0, 0).unwrap(), corner, TOLERANCE);
        near(map.get(17, 31).unwrap(), middle, TOLERANCE);
    }
}

#[test]
fn extremes() {
    let plain = |color: [f32; 3]| Image::from_fn(24, 24, |_, _| color);
    let [black, white] = [[0.0; 3], [1.0; 3]].map(plain);
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(plain);
    near(flip(&black, &white).unwrap(), 0.967_345, TOLERANCE);
    near(flip(&white, &black).unwrap(), 0.967_345, TOLERANCE);
    near(flip(&green, &blue).unwrap(), 1.0, TOLERANCE);
    let grains = noise(40, 30, 1);
    assert_eq!(flip(&grains, &grains).unwrap(), 0.0);
    assert_eq!(hdr_flip(&grains, &grains).unwrap(), 0.0);
    near(
        flip(&grains, &noise(40, 30, 2)).unwrap(),
        0.434_983,
        TOLERANCE,
    );
}

#[test]
fn any_size() {
    // Mean, largest and middle of LDR-FLIP, then of HDR-FLIP of 8 v² + 1/64, then its exposures.
    let expected: [(u32, u32, [f64; 8], u32); 7] = [
        (
            1,
            1,
            [
                0.521_859, 0.521_859, 0.521_859, 0.204_464, 0.204_464, 0.204_464, 7.083_297,
                7.083_297,
            ],
            2,
        ),
        (
            2,
            1,
            [
                0.554_592, 0.560_830, 0.560_830, 0.576_528, 0.611_261, 0.541_795, 5.549_634,
                5.549_634,
            ],
            2,
        ),
        (
            1,
            7,
            [
                0.377_701, 0.518_879, 0.254_282, 0.637_198, 0.976_174, 0.594_653, 0.773_394,
                2.719_846,
            ],
            2,
        ),
        (
            33,
            17,
            [
                0.309_317, 0.666_719, 0.188_585, 0.366_740, 0.907_588, 0.195_913, -1.754_767,
                0.158_247,
            ],
            2,
        ),
        (
            64,
            64,
            [
                0.307_415, 0.664_826, 0.292_889, 0.361_382, 0.898_283, 0.354_467, -1.754_767,
                0.016_536,
            ],
            2,
        ),
        (
            101,
            63,
            [
                0.305_188, 0.664_826, 0.355_903, 0.359_930, 0.898_283, 0.636_297, -1.754_767,
                0.016_536,
            ],
            2,
        ),
        (
            161,
            164,
            [
                0.308_862, 0.664_826, 0.338_651, 0.362_794, 0.900_312, 0.620_964, -1.754_767,
                0.045_599,
            ],
            2,
        ),
    ];
    for (width, height, numbers, count) in expected {
        let [x, r] = noisy_pair(width, height);
        let ldr = flip_map(&x, &r, FLIP_PIXELS_PER_DEGREE).unwrap();
        let radiance = |image: &Image| map(image, |v| v * v * 8.0 + 1.0 / 64.0);
        let (x, r) = (radiance(&x), radiance(&r));
        let exposures = Exposures::of(&r).unwrap();
        let hdr = hdr_flip_map(&x, &r, FLIP_PIXELS_PER_DEGREE, exposures).unwrap();
        let found = [ldr, hdr].map(|map| {
            let middle = map.get(width / 2, height / 2).unwrap();
            [map.mean(), map.statistics().max, middle]
        });
        let found = [&found[0][..], &found[1], &[exposures.start, exposures.stop]].concat();
        for (found, expected) in found.iter().zip(numbers) {
            near(*found, expected, TOLERANCE);
        }
        assert_eq!(exposures.count, count);
    }
}

#[test]
fn weighted_quartiles() {
    let [x, r] = noisy_pair(101, 63);
    let statistics = flip_map(&x, &r, FLIP_PIXELS_PER_DEGREE)
        .unwrap()
        .statistics();
    for (found, expected) in statistics
        .weighted_quartiles
        .iter()
        .zip([0.269_309, 0.322_900, 0.380_647])
    {
        near(*found, expected, TOLERANCE);
    }
    near(statistics.min, 0.067_213, TOLERANCE);
}

#[test]
fn other_distances() {
    let [x, r] = noisy_pair(33, 17);
    for (pixels_per_degree, mean, max) in
        [(20.0, 0.432_982, 0.889_569), (100.0, 0.255_316, 0.548_171)]
    {
        let map = flip_map(&x, &r, pixels_per_degree).unwrap();
        near(map.mean(), mean, TOLERANCE);
        near(map.statistics().max, max, TOLERANCE);
    }
    for bad in [0.0, -67.0, f64::NAN, f64::INFINITY] {
        let message = flip_map(&x, &r, bad).unwrap_err().to_string();
        assert!(
            message.ends_with("pixels per degree of visual angle: give 1 to 1000"),
            "{message}"
        );
    }
}

#[test]
fn exposures_of_other_references() {
    // Start, stop and count by the authors' program; the second has a black median.
    for (values, start, stop, count) in [
        (&[1.0, 2.0, 4.0, 8.0][..], -1.916_703, -0.916_703, 2),
        (&[0.0, 0.0, 4.0], -0.916_703, 24.083_298, 25),
        (&[1.0, 2.0, 4.0], -0.916_703, 0.083_297, 2),
    ] {
        let image = Image::from_fn(values.len() as u32, 1, |x, _| [values[x as usize]; 3]);
        let exposures = Exposures::of(&image).unwrap();
        near(exposures.start, start, TOLERANCE);
        near(exposures.stop, stop, TOLERANCE);
        assert_eq!(exposures.count, count);
    }
    // Theirs stops at a black reference; here it has exposures, and an error can be seen.
    let [black, grey] = [0.0, 0.5].map(|v| Image::from_fn(3, 3, |_, _| [v; 3]));
    assert_eq!(hdr_flip(&black, &black).unwrap(), 0.0);
    assert!(hdr_flip(&grey, &black).unwrap() > 0.9);
    // Below zero there is no light.
    let below = Image::from_fn(3, 3, |_, _| [-1.0; 3]);
    assert_eq!(hdr_flip(&below, &black).unwrap(), 0.0);
}
