// Random numbers as a pure function of (pixel, sample, dimension, frame, seed).
//
// PCG4D of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3), section 4:
// a linear congruential step, then two rounds of x += y * w, y += z * x, z += x * y, w += y * z
// with x ^= x >> 16 between them. Each step is a bijection of 128 bits, so two streams of one
// seed never share a state; two applications hide the order in which the numbers entered.

struct Rng {
    key: vec4u,
    dimension: u32,   // the next one to be drawn
}

fn pcg4d(input: vec4u) -> vec4u {
    var v = input * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4u(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// The 24 high bits as a float in [0, 1): every value is exact, 1 cannot come out.
fn unit_float(bits: u32) -> f32 {
    return f32(bits >> 8u) * 5.9604644775390625e-8;
}

fn rng_new(pixel: vec2u, sample: u32, frame: u32, seed: u32) -> Rng {
    let stream = pcg4d(vec4u(pixel, sample, frame));
    return Rng(pcg4d(stream ^ vec4u(seed, seed * 0x9e3779b9u, ~seed, seed * 0x85ebca6bu)), 0u);
}

fn rng_bits(rng: ptr<function, Rng>) -> vec4u {
    let dimension = (*rng).dimension;
    (*rng).dimension = dimension + 1u;
    return pcg4d((*rng).key + vec4u(dimension, 0u, 0u, dimension * 0x9e3779b9u));
}

// One number in [0, 1); takes one dimension.
fn rng_1(rng: ptr<function, Rng>) -> f32 {
    return unit_float(rng_bits(rng).x);
}

// Two independent numbers in [0, 1); takes one dimension.
fn rng_2(rng: ptr<function, Rng>) -> vec2f {
    let bits = rng_bits(rng);
    return vec2f(unit_float(bits.x), unit_float(bits.y));
}

// Three independent numbers in [0, 1); takes one dimension.
fn rng_3(rng: ptr<function, Rng>) -> vec3f {
    let bits = rng_bits(rng);
    return vec3f(unit_float(bits.x), unit_float(bits.y), unit_float(bits.z));
}
