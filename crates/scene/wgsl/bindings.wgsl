// The scene as shaders see it: bind group 1, the same for every pass that traces or rasterises.
//
// Everything but the nodes' layout is plain: offsets into `scene_data` count vec4u, indices are
// scene-wide (a triangle's corner indexes `scene_vertices` directly), transforms are the three
// rows of an affine 3x4 matrix. Node layout: Ylitie, Karras, Laine 2017, "Efficient
// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.

struct SceneInfo {
    tlas_root: u32,          // index of a node of the BVH over the instances that move, or NONE
    still_root: u32,         // index of a node of the BVH of what stands still, or NONE
    materials: u32,          // offset into scene_data, 5 each
    texture_slots: u32,      // offset, 3 each
    lights: u32,             // offset, 5 each: emissive triangles, then punctual lights
    light_count: u32,
    sky_cells: u32,          // offset, 1 each
    sky_probability: f32,    // that light_sample chooses the sky
    sky_grid: vec2u,         // cells of the sky's distribution; 0 for a constant sky
    sky_turn: vec2f,         // cosine and sine of the sky's rotation about +Y
    sky_factor: vec3f,       // radiance of a constant sky, factor on the texels of an image
    bounds_radius: f32,      // of a sphere about the scene, metres
}

struct SceneInstance {
    object_from_world: array<vec4f, 3>,
    world_from_object: array<vec4f, 3>,
    previous_world_from_object: array<vec4f, 3>,
    root: u32,               // node
    first_triangle: u32,
    triangle_count: u32,
    material: u32,
    flags: u32,              // INSTANCE_*
    first_light: u32,        // light of its first triangle when it emits
    first_vertex: u32,
    previous_vertices: u32,  // offset of its previous positions when it deforms, else NONE
    tangents: u32,           // offset of its tangents, NONE when it has none
    tlas_instance: u32,      // of the k-th leaf of the TLAS, the instance there
    padding: vec2u,
}

const NONE = 0xffffffffu;
const INSTANCE_DOUBLE_SIDED = 1u;
const INSTANCE_ALPHA_MASK = 2u;
const INSTANCE_EMISSIVE = 4u;
const TRIANGLE_MIRRORED = 8u;   // beside its instance's flags: carried to the world by a transform that mirrors

@group(1) @binding(0) var<uniform> scene_info: SceneInfo;
@group(1) @binding(1) var<storage, read> scene_nodes: array<vec4u>;          // 5 each
@group(1) @binding(2) var<storage, read> scene_triangles: array<vec4u>;      // 3 each, leaf order: v0 and its scene-wide triangle; v0 - v1 and its instance or NONE; v2 - v0 and its flags
@group(1) @binding(3) var<storage, read> scene_indices: array<u32>;          // 3 a triangle
@group(1) @binding(4) var<storage, read> scene_vertices: array<vec4f>;       // 2 each: position and normal.x, normal.yz and uv
@group(1) @binding(5) var<storage, read> scene_instances: array<SceneInstance>;
@group(1) @binding(6) var<storage, read> scene_data: array<vec4u>;
@group(1) @binding(7) var scene_atlas: texture_2d_array<f32>;
@group(1) @binding(8) var scene_sky: texture_2d<f32>;
