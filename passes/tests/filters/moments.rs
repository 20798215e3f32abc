//! m = (L, L^2), of what has a value.

use crate::common::{
    Image, Input, Random, Run, SIZES, Storage, assert_close, is_finite, luminance,
};
use scumble::signal;

#[test]
fn agrees_with_its_twin() {
    let mut random = Random(81);
    for size in SIZES {
        let light = random.light_with_a_bad_texel(size);
        // A third of the texels have no value.
        let value = Image::new(size, |p| {
            let mut texel = light.at(p);
            texel[3] = f64::from(random.range(0.0, 3.0) >= 1.0);
            texel
        });
        let there = |p| is_finite(value.at(p)) && value.at(p)[3] > 0.0;
        let moments = value.map(|p| {
            let l = if there(p) {
                luminance(value.at(p))
            } else {
                0.0
            };
            Some([l, l * l, 0.0, 1.0])
        });
        let age = value.map(|p| Some([f64::from(there(p)), 0.0, 0.0, 1.0]));
        let got = Run::new("moments", "", size)
            .input("value", Input::any(signal::IRRADIANCE, &value))
            .outputs(&["moments", "age"]);
        assert_close("moments", &got[0], &moments, Storage::F32);
        assert_close("age", &got[1], &age, Storage::F32);
    }
}
