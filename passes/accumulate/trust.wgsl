// How many samples of a history count beside n new ones, where it is trusted by k: N = min(N, n k / (1 - k)), so that it weighs k at
// most. Derived here for what L. Dundr, "Progressive Spatiotemporal Variance-Based Path Tracing Filtering", 2018, section 6.1, says in words.

fn trusted_age(age: f32, n: f32, k: f32, has_confidence: bool) -> f32 {
    if !has_confidence || !is_finite(k) || k >= 1.0 {
        return age;
    }
    return min(age, n * max(k, 0.0) / (1.0 - k));
}
