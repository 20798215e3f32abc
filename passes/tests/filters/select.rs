//! out = mask and a sample ? other : value.

use crate::common::{Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite};
use scumble::signal;

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(41);
    for size in SIZES {
        let value = Image::new(size, |_| random.light());
        let mut other = random.light_with_a_bad_texel(size);
        let mask = Image::new(size, |_| [random.range(0.0, 2.0).floor(), 0.0, 0.0, 1.0]);
        // A third of the texels have no sample.
        other = Image::new(size, |p| {
            let mut texel = other.at(p);
            texel[3] = f64::from(random.range(0.0, 3.0) >= 1.0);
            texel
        });
        let want = value.map(|p| {
            let o = other.at(p);
            let taken = mask.x(p) != 0.0 && o[3] > 0.0 && is_finite(o);
            Some(if taken { o } else { value.at(p) })
        });
        let got = Run::new("select", "", size)
            .input("value", Input::any(signal::IRRADIANCE, &value))
            .input("other", Input::any(signal::IRRADIANCE, &other))
            .input("mask", Input::any(signal::MASK, &mask))
            .output("value");
        assert_close("select", &got, &want, Storage::F16);
    }
}
