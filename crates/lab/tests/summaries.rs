//! Summaries of records whose numbers are worked out by hand.

use scumble_lab::{
    Allowance, Baseline, CameraDesign, Design, Estimate, FrameRecord, Record, Results,
    VariantDesign,
};

/// One run: its relMSE, and milliseconds of its frames and of a pass.
fn record(variant: &str, seed: u32, relmse: f64, milliseconds: &[f64]) -> Record {
    Record {
        key: format!("{variant}{seed}"),
        scene: "s".into(),
        camera: "c".into(),
        variant: variant.into(),
        seed,
        adapter: "a".into(),
        driver: "d".into(),
        exposure: 1.0,
        counts: [("a.samples".to_owned(), 3)].into(),
        rates: [("m.rate".to_owned(), 0.5)].into(),
        rays: vec![20.0; milliseconds.len()],
        seconds: milliseconds.iter().map(|ms| ms * 2e-3).collect(),
        passes: [("p", 1.0), ("q", 0.5)]
            .map(|(pass, share)| {
                (
                    pass.to_owned(),
                    milliseconds.iter().map(|ms| ms * share).collect(),
                )
            })
            .into(),
        memory: 7,
        frames: vec![FrameRecord {
            frame: 1,
            reference: "r".into(),
            metrics: [
                ("relmse".to_owned(), relmse),
                ("psnr".to_owned(), 30.0 - relmse),
            ]
            .into(),
        }],
        flicker: None,
    }
}

fn results(base: &[f64], other: &[(u32, f64)]) -> Results {
    let variant = |name: &str| VariantDesign {
        name: name.into(),
        about: String::new(),
        changes: Vec::new(),
        options: Vec::new(),
        paths: 1.0,
    };
    let design = Design {
        scenes: vec!["s".into()],
        cameras: vec![CameraDesign {
            name: "c".into(),
            frames: 5,
            references: vec![1],
        }],
        variants: vec![variant("base"), variant("other")],
        metrics: vec!["relmse".into(), "psnr".into()],
        seeds: vec![1, 2, 3],
        size: [5, 2],
        ..Design::default()
    };
    let times = [900.0, 90.0, 1.0, 2.0, 4.0];
    let seeds = base.iter().zip(1..);
    let base = seeds.map(|(value, seed)| record("base", seed, *value, &times));
    let other = other
        .iter()
        .map(|(seed, value)| record("other", *seed, *value, &times[..2]));
    // Records come in any order.
    let mut records: Vec<Record> = base.chain(other).collect();
    records.reverse();
    Results::of(design, records, Vec::new())
}

/// Six digits are what the tables of t have.
#[track_caller]
fn near(found: Option<f64>, expected: f64) {
    assert!(
        (found.unwrap() / expected - 1.0).abs() < 1e-6,
        "{found:?} is not {expected}"
    );
}

#[test]
fn means_and_differences_have_the_intervals_of_the_table() {
    let found = results(&[1.0, 2.0, 4.0], &[(1, 2.0), (2, 2.5), (3, 5.5)]);
    let [base, other] = found.summaries.as_slice() else {
        panic!("{:?}", found.summaries);
    };
    assert_eq!(
        (base.variant.as_str(), base.seeds.as_slice()),
        ("base", &[1, 2, 3][..])
    );
    assert_eq!(base.metrics["relmse"].values, [1.0, 2.0, 4.0]);
    // s^2 = (16 + 1 + 25) / 9 / 2 = 7/3, and t(2) = 4.302653.
    let estimate = base.metrics["relmse"].estimate;
    near(Some(estimate.mean), 7.0 / 3.0);
    near(estimate.half, 4.302653 * (7.0f64 / 9.0).sqrt());
    // Differences 1, 1/2, 3/2: s = 1/2.
    let difference = other.metrics["relmse"].against["base"];
    near(Some(difference.mean), 1.0);
    near(difference.half, 4.302653 * 0.5 / 3f64.sqrt());
    assert!(!difference.is_significant());
    let back = base.metrics["relmse"].against["other"];
    assert_eq!((back.mean, back.half), (-difference.mean, difference.half));
    assert_eq!(base.rays_per_pixel, 2.0);
    assert_eq!(
        base.budget,
        [("a.samples".to_owned(), 3.0), ("m.rate".to_owned(), 0.5)].into()
    );
}

/// A seed that gave nothing takes away its pair, not the comparison.
#[test]
fn pairs_are_of_the_seeds_that_both_have() {
    let found = results(&[1.0, 2.0, 4.0], &[(1, 2.0), (3, 5.5)]);
    let difference = found.summaries[1].metrics["relmse"].against["base"];
    // Differences 1 and 3/2: s = sqrt(1/8), t(1) = 12.706205.
    assert_eq!((difference.mean, difference.count), (1.25, 2));
    near(difference.half, 12.706205 * 0.25);
}

#[test]
fn times_leave_the_warm_up_out_and_keep_the_last_frame() {
    let found = results(&[1.0], &[(1, 2.0)]);
    let [base, other] = found.summaries.as_slice() else {
        panic!("{:?}", found.summaries);
    };
    // 1, 2, 4 are left: the 5th percentile is a tenth of the way from the first to the second.
    let close = |found: [f64; 3], expected: [f64; 3]| {
        found
            .iter()
            .zip(expected)
            .for_each(|(f, e)| near(Some(*f), e));
    };
    close(base.pass_ms["p"], [1.1, 2.0, 3.8]);
    close(base.pass_ms["q"], [0.55, 1.0, 1.9]);
    close(base.gpu_ms.unwrap(), [1.65, 3.0, 5.7]);
    close(base.frame_ms.unwrap(), [2.2, 4.0, 7.6]);
    // A run of two frames has the second.
    close(other.pass_ms["p"], [90.0; 3]);
}

#[test]
fn a_rise_is_paired_where_the_seeds_are_the_same() {
    let allowed = |text: &str| [text.parse::<Allowance>().unwrap()];
    let baseline = Baseline::of(results(&[1.0, 2.0, 4.0], &[(1, 1.0)]));
    let now = results(&[1.2, 2.2, 4.2], &[(1, 0.9)]);
    let rises = baseline.rises(&now, &allowed("relmse=5%")).unwrap();
    assert_eq!(rises.len(), 2);
    near(Some(rises[0].rise.mean), 0.2);
    near(Some(rises[0].allowed), 0.05 * 7.0 / 3.0);
    assert!(rises[0].fails() && !rises[1].fails(), "{rises:?}");
    // The same means of other seeds could be chance.
    let mut elsewhere = now.clone();
    elsewhere.summaries[0].seeds = vec![4, 5, 6];
    let rises = baseline.rises(&elsewhere, &allowed("relmse=5%")).unwrap();
    assert!(!rises[0].fails(), "{:?}", rises[0]);
    // Of a similarity less is worse, and costs have no interval.
    let rises = baseline.rises(&now, &allowed("psnr=0.1")).unwrap();
    near(Some(rises[0].rise.mean), 0.2);
    assert!(rises[0].fails());
    let rises = baseline.rises(&now, &allowed("gpu_ms=0")).unwrap();
    assert_eq!(
        rises[0].rise,
        Estimate {
            mean: 0.0,
            half: None,
            count: 1
        }
    );
    assert!(!rises[0].fails());
    assert!(baseline.rises(&now, &allowed("flip=0")).is_err());
}
