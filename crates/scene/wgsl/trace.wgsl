// The one trace(): the nearest triangle a ray meets, or any.
//
// Compressed wide BVHs (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs
// Through Compressed Wide BVHs", sections 3 and 4): children are 8-bit boxes q in the grid
// p + 2^e q of their node; a node is met where the slab test
//   max_axis t_lo <= min_axis t_hi,  t = (p - o) / d + q 2^e / d
// holds, and its children are visited by ray octant. What stands still is one tree of world-space
// triangles, walked first; then comes the tree over the instances that move. These are entered
// by transforming the ray, unnormalised, so that t means the same in both spaces. Triangles:
// Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", in the form with
// n = (v0 - v1) x (v2 - v0).
// Every call inlines into its kernel: have one call site, in a loop where more rays are needed.
#include "scene/bindings.wgsl"
#include "scene/geometry.wgsl"

struct Ray {
    origin: vec3f,
    t_min: f32,
    direction: vec3f,   // unit
    t_max: f32,
}

struct Hit {
    t: f32,             // NO_HIT on a miss
    instance: u32,
    triangle: u32,      // scene-wide
    uv: vec2f,          // barycentric weights of the second and third corner
    front: bool,
}

const NO_HIT = 1e30;
const RAY_CAMERA = 0u;    // nearest; the backs of single-sided surfaces are invisible
const RAY_CLOSEST = 1u;   // nearest
const RAY_ANY = 2u;       // any, for shadows: only whether t < NO_HIT means something
const FIRST_INSTANCE = 0x80000000u; // primitives from here on are instances, those before are triangles
const TRACE_STACK = 32u;  // entries; deeper scenes are refused when they are built

// Rays traced by this invocation; a pass that counts rays writes it out.
var<private> rays_traced: u32 = 0u;

// 1 / d, finite where d is zero.
fn inverse_direction(d: vec3f) -> vec3f {
    let tiny = select(vec3f(1e-20), vec3f(-1e-20), d < vec3f(0.0));
    return 1.0 / select(d, tiny, abs(d) < vec3f(1e-20));
}

// The octant whose children come first, in each byte.
fn inverse_octant(inverse: vec3f) -> u32 {
    return select(0x04040404u, 0u, inverse.x < 0.0) | select(0x02020202u, 0u, inverse.y < 0.0)
        | select(0x01010101u, 0u, inverse.z < 0.0);
}

fn bytes_to_floats(bytes: u32) -> vec4f {
    return vec4f(unpack4xU8(bytes));
}

// Bits of the met children of one half of a node: inner ones in the high byte by visiting order,
// triangles below.
fn half_node_hits(meta_bytes: u32, near_x: u32, near_y: u32, near_z: u32, far_x: u32, far_y: u32, far_z: u32,
                  scale: vec3f, shift: vec3f, octant: u32, t_min: f32, t_max: f32) -> u32 {
    // Inner nodes are marked by both bits of 0b11000.
    let inner = (meta_bytes & (meta_bytes << 1u)) & 0x10101010u;
    let index = (meta_bytes ^ (octant & ((inner >> 4u) * 0xffu))) & 0x1f1f1f1fu;
    let bits = (meta_bytes >> 5u) & 0x07070707u;

    let x0 = bytes_to_floats(near_x) * scale.x + shift.x;
    let y0 = bytes_to_floats(near_y) * scale.y + shift.y;
    let z0 = bytes_to_floats(near_z) * scale.z + shift.z;
    let x1 = bytes_to_floats(far_x) * scale.x + shift.x;
    let y1 = bytes_to_floats(far_y) * scale.y + shift.y;
    let z1 = bytes_to_floats(far_z) * scale.z + shift.z;
    let enter = max(max(x0, y0), max(z0, vec4f(t_min)));
    let leave = min(min(x1, y1), min(z1, vec4f(t_max)));
    // The factor covers the rounding of t (Ize 2013, "Robust BVH Ray Traversal").
    let met = enter <= leave * 1.0000004;
    let shifted = unpack4xU8(bits) << unpack4xU8(index);
    let hits = select(vec4u(0u), shifted, met);
    return hits.x | hits.y | hits.z | hits.w;
}

fn trace(ray: Ray, mode: u32) -> Hit {
    rays_traced += 1u;
    var hit = Hit(NO_HIT, NONE, NONE, vec2f(0.0), true);
    var nearest = min(ray.t_max, NO_HIT);
    var stack: array<vec2u, TRACE_STACK>;
    var depth = 0u;
    var ground = 0u;            // of the stack in this level of the BVH
    // Groups are (base index, bits). Nodes have bits in the high byte and which children are
    // nodes in the low one; primitives have only the 24 low bits.
    var nodes = vec2u(scene_info.still_root, select(0x80000000u, 0u, scene_info.still_root == NONE));
    var primitives = vec2u(0u);
    if scene_info.tlas_root != NONE {
        stack[0] = vec2u(scene_info.tlas_root, 0x80000000u);
        depth = 1u;
    }
    var instance = NONE;        // NONE in world space
    var origin = ray.origin;
    var direction = ray.direction;
    var inverse = inverse_direction(direction);
    var octant = inverse_octant(inverse);

    // Rare work stands in outer loops: where a machine runs both sides of a branch, it would
    // otherwise be done at every step.
    loop {
        var masked = Hit(NO_HIT, NONE, NONE, vec2f(0.0), true);
        loop {
            loop {
                if primitives.y != 0u {
                    break;
                }
                if nodes.y <= 0x00ffffffu {
                    if depth == ground {
                        break;
                    }
                    depth -= 1u;
                    nodes = stack[depth];
                    if nodes.y <= 0x00ffffffu {
                        primitives = nodes;
                        nodes = vec2u(0u);
                        break;
                    }
                }
                let bit = firstLeadingBit(nodes.y);
                let slot = (bit - 24u) ^ (octant & 7u);
                let child = nodes.x + countOneBits(nodes.y & ~(NONE << slot) & 0xffu);
                nodes.y &= ~(1u << bit);
                if nodes.y > 0x00ffffffu {
                    stack[depth] = nodes;
                    depth += 1u;
                }

                let at = 5u * child;
                let n0 = scene_nodes[at];
                let n1 = scene_nodes[at + 1u];
                let n2 = scene_nodes[at + 2u];
                let n3 = scene_nodes[at + 3u];
                let n4 = scene_nodes[at + 4u];
                let exponents = vec3u(n0.w & 0xffu, (n0.w >> 8u) & 0xffu, (n0.w >> 16u) & 0xffu);
                let scale = bitcast<vec3f>(exponents << vec3u(23u)) * inverse;
                let shift = (bitcast<vec3f>(n0.xyz) - origin) * inverse;
                let x = select(n2, n2.zwxy, inverse.x < 0.0);
                let y = select(n3, n3.zwxy, inverse.y < 0.0);
                let z = select(n4, n4.zwxy, inverse.z < 0.0);
                let hits = half_node_hits(n1.z, x.x, y.x, z.x, x.z, y.z, z.z, scale, shift, octant, ray.t_min, nearest)
                    | half_node_hits(n1.w, x.y, y.y, z.y, x.w, y.w, z.w, scale, shift, octant, ray.t_min, nearest);
                nodes = vec2u(n1.x, (hits & 0xff000000u) | (n0.w >> 24u));
                primitives = vec2u(n1.y, hits & 0x00ffffffu);
            }

            while primitives.y != 0u && primitives.x < FIRST_INSTANCE && masked.instance == NONE {
                let bit = firstLeadingBit(primitives.y);
                primitives.y &= ~(1u << bit);
                let leaf = 3u * (primitives.x + bit);
                let t0 = scene_triangles[leaf];
                let t1 = scene_triangles[leaf + 1u];
                let t2 = scene_triangles[leaf + 2u];
                let e1 = bitcast<vec3f>(t1.xyz);
                let e2 = bitcast<vec3f>(t2.xyz);
                let flags = t2.w;
                let n = cross(e1, e2);
                let c = bitcast<vec3f>(t0.xyz) - origin;
                let r = cross(direction, c);
                let det = dot(n, direction);
                // Positive from the front, also where the ray was carried into a mirrored instance.
                let front = (det > 0.0) == ((flags & TRIANGLE_MIRRORED) == 0u);
                if abs(det) > 1e-36 && (front || mode != RAY_CAMERA || (flags & INSTANCE_DOUBLE_SIDED) != 0u) {
                    let inverse_det = 1.0 / det;
                    let uv = vec2f(dot(r, e2), dot(r, e1)) * inverse_det;
                    let t = dot(n, c) * inverse_det;
                    if uv.x >= 0.0 && uv.y >= 0.0 && uv.x + uv.y <= 1.0 && t >= ray.t_min && t < nearest {
                        let owner = select(t1.w, instance, t1.w == NONE);
                        if (flags & INSTANCE_ALPHA_MASK) == 0u {
                            nearest = t;
                            hit = Hit(t, owner, t0.w, uv, front);
                        } else {
                            masked = Hit(t, owner, t0.w, uv, front);
                        }
                    }
                }
            }
            if masked.instance != NONE || (mode == RAY_ANY && hit.instance != NONE) {
                break;
            }

            if primitives.y != 0u {
                // Enter an instance; what else is to be visited up here waits on the stack.
                let bit = firstLeadingBit(primitives.y);
                primitives.y &= ~(1u << bit);
                instance = scene_instances[primitives.x + bit - FIRST_INSTANCE].tlas_instance;
                if primitives.y != 0u {
                    stack[depth] = primitives;
                    depth += 1u;
                }
                if nodes.y > 0x00ffffffu {
                    stack[depth] = nodes;
                    depth += 1u;
                }
                ground = depth;
                origin = transform_point(scene_instances[instance].object_from_world, ray.origin);
                direction = transform_direction(scene_instances[instance].object_from_world, ray.direction);
                primitives = vec2u(0u);
                nodes = vec2u(scene_instances[instance].root, 0x80000000u);
            } else if instance != NONE && nodes.y <= 0x00ffffffu && depth == ground {
                instance = NONE;
                ground = 0u;
                origin = ray.origin;
                direction = ray.direction;
            } else if nodes.y <= 0x00ffffffu && depth == ground {
                break;
            } else {
                continue;
            }
            inverse = inverse_direction(direction);
            octant = inverse_octant(inverse);
        }
        if masked.instance == NONE {
            break;
        }
        if alpha_passes(scene_instances[masked.instance].material, masked.triangle, masked.uv) {
            nearest = masked.t;
            hit = masked;
            if mode == RAY_ANY {
                break;
            }
        }
    }
    return hit;
}
