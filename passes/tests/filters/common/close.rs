//! Comparison with a twin.

/// How a result is stored, and so how near it must be.
#[derive(Clone, Copy, Debug)]
pub enum Storage {
    F32,
    F16,
}

impl Storage {
    /// Arithmetic: 1e-4 relative, f32 with `exp` of arguments up to some tens (Vulkan allows an error of 3 + 2|x| ulp each).
    /// f16: one ulp more, 2^-10 relative for normal numbers and 2^-24 below them. Vulkan leaves it to the driver whether a
    /// store rounds to nearest (half of that) or towards zero, as Mesa's lavapipe does.
    pub fn tolerance(self, want: f64) -> f64 {
        let arithmetic = 1e-4 * want.abs() + 1e-30;
        match self {
            Storage::F32 => arithmetic,
            Storage::F16 => arithmetic + want.abs() / 1024.0 + 2f64.powi(-24),
        }
    }
}

/// Every texel as wanted; `None` is a texel whose f64 value sits on a threshold, within rounding: either side is right. There
/// may be few of those.
pub fn assert_close(what: &str, got: &[[f32; 4]], want: &[Option<[f64; 4]>], storage: Storage) {
    assert_eq!(got.len(), want.len(), "{what}");
    let decided = want.iter().flatten().count();
    assert!(
        want.len() - decided <= want.len() / 50,
        "{what}: {decided} of {} texels decided",
        want.len()
    );
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let Some(want) = want else { continue };
        for (g, w) in got.iter().zip(want) {
            let error = (f64::from(*g) - w).abs();
            assert!(
                error <= storage.tolerance(*w),
                "{what}: texel {i}: {got:?} instead of {want:?} in {storage:?}"
            );
        }
    }
}
