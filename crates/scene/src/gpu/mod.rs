//! A scene on the GPU: bind group 1 of every pass that traces or rasterises it.
//!
//! [`GpuScene`] owns six storage buffers, the texture atlas and the sky; the WGSL library
//! ([`wgsl_modules`]) reads them.

mod alias;
mod atlas;
mod check;
mod error;
mod geometry;
mod layout;
mod lights;
mod materials;
mod sky;
mod still;
mod store;
mod update;
mod wgsl;

pub use crate::bvh::BuildQuality;
pub use error::GpuSceneError;
pub use wgsl::wgsl_modules;

use crate::{Camera, Deformed, Light, Scene};
use atlas::Atlas;
use geometry::MeshPlace;
use glam::{Affine3A, Vec3};
use lights::LIGHT_WORDS;
use materials::Word;
use sky::SkyData;
use std::sync::Arc;
use still::Still;
use store::Store;

/// What to draw of one instance with `scene/vertex.wgsl`.
///
/// `pass.draw(0..vertex_count, instance..instance + 1)`, without vertex buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// Index of the instance.
    pub instance: u32,
    /// Three for each triangle.
    pub vertex_count: u32,
    /// The first of its corners in the scene-wide list of indices.
    pub first_index: u32,
    /// Whether its back is seen too.
    pub double_sided: bool,
    /// Whether its transform mirrors: its front faces are clockwise then.
    pub mirrored: bool,
}

/// How a scene is put on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuSceneOptions {
    /// How much time the BVH of a mesh may take, once.
    pub quality: BuildQuality,
    /// How many triangles of meshes placed more than once may be copied, of 48 bytes each, so
    /// that rays walk one BVH of all that stands still; the device may have room for fewer. 0
    /// keeps a two-level BVH throughout.
    pub still_triangles: u32,
}

impl Default for GpuSceneOptions {
    fn default() -> Self {
        Self {
            quality: BuildQuality::default(),
            still_triangles: 1 << 21,
        }
    }
}

/// A scene on the GPU.
///
/// ```no_run
/// # fn f(device: &wgpu::Device, queue: &wgpu::Queue, scene: scumble_scene::Scene) -> Result<(), scumble_scene::GpuSceneError> {
/// let mut gpu = scumble_scene::GpuScene::new(device, queue, std::sync::Arc::new(scene))?;
/// gpu.update(0.5)?; // pose it half a second in; what moved is known to the motion vectors
/// let group = gpu.bind_group(); // @group(1)
/// # let _ = group; Ok(()) }
/// ```
pub struct GpuScene {
    device: wgpu::Device,
    queue: wgpu::Queue,
    scene: Arc<Scene>,
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    info: wgpu::Buffer,
    nodes: Store,
    triangles: Store,
    indices: Store,
    vertices: Store,
    instances: Store,
    data: Store,
    atlas: wgpu::Texture,
    sky: wgpu::Texture,
    texture_bytes: u64,
    /// Nodes that are built once; the others follow them.
    still_nodes: u32,
    /// Root of the BVH of what stands still, or `NONE`.
    still_root: u32,
    /// Of each instance, whether it is in that BVH.
    still: Vec<bool>,
    places: Vec<MeshPlace>,
    sections: Sections,
    sky_data: SkyData,
    /// Mean linear colour of each texture an emissive material uses.
    emissive_means: Vec<Vec3>,
    radius: f32,
    draws: Vec<Draw>,
    warnings: Vec<String>,
    state: State,
    revision: u64,
}

/// Offsets into `scene_data`, in words.
#[derive(Clone, Copy, Debug, Default)]
struct Sections {
    materials: u32,
    slots: u32,
    sky_cells: u32,
    tangents: u32,
    previous: u32,
    lights: u32,
}

/// What of the scene is on the GPU right now.
#[derive(Default)]
struct State {
    time: f32,
    /// Whether `update` was never called.
    fresh: bool,
    /// Whether anything is elsewhere than in the previous frame.
    moving: bool,
    transforms: Vec<Affine3A>,
    previous_transforms: Vec<Affine3A>,
    deformed: Vec<Deformed>,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
}

impl GpuScene {
    /// Puts a scene on the GPU, posed at time 0.
    ///
    /// # Errors
    /// When the scene does not fit this device, or its indices lead out of its lists.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: Arc<Scene>,
    ) -> Result<Self, GpuSceneError> {
        Self::with_options(device, queue, scene, GpuSceneOptions::default())
    }

    /// As [`new`](Self::new), with options.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_options(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: Arc<Scene>,
        options: GpuSceneOptions,
    ) -> Result<Self, GpuSceneError> {
        check::check(&scene)?;
        layout::check_device(device)?;
        let atlas = Atlas::new(device, queue, &scene)?;
        let largest = device.limits().max_texture_dimension_2d;
        let mut sky_data = SkyData::new(&scene.sky, largest);
        let mut warnings = atlas.warnings.clone();
        warnings.append(&mut sky_data.warnings);
        let pose = scene.pose(0.0);
        let budget = options.still_triangles.min(room_for_copies(device, &scene));
        let still = Still::new(&scene, &pose.instances, budget, options.quality)?;
        let (places, lists, still_root) = geometry::flatten(&scene, &still, options.quality)?;
        let (sections, words) = data_words(&scene, &atlas, &sky_data, &places, &lists);

        let still_nodes = (lists.nodes.len() * 4) as u64 / crate::bvh::NODE_BYTES;
        // The top level has fewer nodes than instances, a mesh far fewer than triangles.
        let deforming: u64 = places
            .iter()
            .filter(|place| place.previous != layout::NONE)
            .map(|place| u64::from(place.triangle_count))
            .sum();
        let node_room = still_nodes + scene.instances.len() as u64 + deforming / 4 + 1;
        let store =
            |what, contents: &[u8], capacity| Store::new(device, queue, what, contents, capacity);
        let bytes = bytemuck::cast_slice::<u32, u8>;
        let nodes = store(
            "nodes",
            bytes(&lists.nodes),
            node_room * crate::bvh::NODE_BYTES,
        )?;
        let triangles = store("triangles", bytemuck::cast_slice(&lists.triangles), 0)?;
        let indices = store("indices", bytes(&lists.indices), 0)?;
        let vertices = store("vertices", bytemuck::cast_slice(&lists.vertices), 0)?;
        let instance_bytes = size_of::<layout::InstanceRecord>() * scene.instances.len();
        let instances = store("instances", &[], instance_bytes as u64)?;
        let data = store("materials and lights", bytemuck::cast_slice(&words), 0)?;
        let info = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene info"),
            size: size_of::<layout::Info>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sky = sky_texture(device, queue, &sky_data);
        let layout = layout::bind_group_layout(device);
        let group = layout::Group {
            layout: &layout,
            info: &info,
            stores: [&nodes, &triangles, &indices, &vertices, &instances, &data],
            atlas: &atlas.texture,
            sky: &sky,
        };
        let bind_group = group.bind(device);
        let texture_bytes = atlas.bytes() + 8 * sky_data.texels.len() as u64;
        let emissive_means = emissive_means(&scene);
        let radius = bounding_radius(&scene);
        let mut gpu = Self {
            device: device.clone(),
            queue: queue.clone(),
            scene,
            layout,
            bind_group,
            info,
            nodes,
            triangles,
            indices,
            vertices,
            instances,
            data,
            atlas: atlas.texture,
            sky,
            texture_bytes,
            still_nodes: still_nodes as u32,
            still_root,
            still: still.instances,
            places,
            sections,
            sky_data,
            emissive_means,
            radius,
            draws: Vec::new(),
            warnings,
            state: State::default(),
            revision: 0,
        };
        gpu.pose_first(pose)?;
        Ok(gpu)
    }

    /// The layout of bind group 1, visible to vertex, fragment and compute stages.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Bind group 1. An [`update`](Self::update) may replace it.
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.bind_group
    }

    /// What to draw, one entry for each instance that has triangles and extent.
    pub fn draws(&self) -> &[Draw] {
        &self.draws
    }

    /// A number that changes whenever geometry, lights, materials or time change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The cameras at the current time.
    pub fn cameras(&self) -> &[Camera] {
        &self.state.cameras
    }

    /// The scene as it was given.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The time it is posed at, seconds.
    pub fn time(&self) -> f32 {
        self.state.time
    }

    /// Bytes of GPU memory.
    pub fn memory(&self) -> u64 {
        let stores: u64 = self.stores().iter().map(|s| s.bytes()).sum();
        stores + self.texture_bytes + size_of::<layout::Info>() as u64
    }

    /// What had to be reduced to fit the device, one sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn stores(&self) -> [&Store; 6] {
        [
            &self.nodes,
            &self.triangles,
            &self.indices,
            &self.vertices,
            &self.instances,
            &self.data,
        ]
    }

    fn rebind(&mut self) {
        let group = layout::Group {
            layout: &self.layout,
            info: &self.info,
            stores: self.stores(),
            atlas: &self.atlas,
            sky: &self.sky,
        };
        self.bind_group = group.bind(&self.device);
    }
}

/// `scene_data` with its sections; tangents of deforming meshes, previous positions and lights
/// are filled in by each pose.
fn data_words(
    scene: &Scene,
    atlas: &Atlas,
    sky: &SkyData,
    places: &[MeshPlace],
    lists: &geometry::Lists,
) -> (Sections, Vec<Word>) {
    let mut words: Vec<Word> = Vec::new();
    let mut sections = Sections::default();
    let materials = materials::materials(scene, &atlas.places);
    words.extend(materials.materials);
    sections.slots = words.len() as u32;
    words.extend(materials.slots);
    sections.sky_cells = words.len() as u32;
    words.extend(
        sky.cells
            .iter()
            .map(|c| [c.keep.to_bits(), c.alias, c.probability.to_bits(), 0]),
    );
    sections.tangents = words.len() as u32;
    for mesh in &scene.meshes {
        words.extend(mesh.tangents.iter().map(|t| t.to_array().map(f32::to_bits)));
    }
    sections.previous = words.len() as u32;
    sections.lights = sections.previous + lists.previous;
    let emissive: usize = scene
        .instances
        .iter()
        .map(|instance| &scene.meshes[instance.mesh as usize])
        .filter(|mesh| scene.materials[mesh.material as usize].is_emissive())
        .map(|mesh| mesh.indices.len())
        .sum();
    let lights = (emissive + scene.lights.len()) * LIGHT_WORDS;
    words.resize(sections.lights as usize + lights, [0; 4]);
    debug_assert_eq!(places.len(), scene.meshes.len());
    (sections, words)
}

/// How many triangles can be bound beside one copy of each.
fn room_for_copies(device: &wgpu::Device, scene: &Scene) -> u32 {
    let triangles: u64 = scene.meshes.iter().map(|m| m.indices.len() as u64).sum();
    let room = store::limit_of(device).0 / geometry::TRIANGLE_BYTES;
    u32::try_from(room.saturating_sub(triangles)).unwrap_or(u32::MAX)
}

fn sky_texture(device: &wgpu::Device, queue: &wgpu::Queue, sky: &SkyData) -> wgpu::Texture {
    let size = wgpu::Extent3d {
        width: sky.size[0],
        height: sky.size[1],
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("scene sky"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&sky.texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * sky.size[0]),
            rows_per_image: None,
        },
        size,
    );
    texture
}

/// Mean linear colour of each texture, computed only where an emissive material uses it.
fn emissive_means(scene: &Scene) -> Vec<Vec3> {
    let mut means = vec![Vec3::ONE; scene.textures.len()];
    let emissive = scene.materials.iter().filter(|m| m.is_emissive());
    for reference in emissive.filter_map(|m| m.emissive_texture.as_ref()) {
        let image = &scene.textures[reference.texture as usize];
        let mut sum = glam::DVec3::ZERO;
        for y in 0..image.height {
            for x in 0..image.width {
                let [r, g, b, _] = atlas::linear_texel(image, x, y);
                sum += Vec3::new(r, g, b).as_dvec3();
            }
        }
        let texels = f64::from(image.width) * f64::from(image.height);
        means[reference.texture as usize] = (sum / texels).as_vec3();
    }
    means
}

fn bounding_radius(scene: &Scene) -> f32 {
    let bounds = scene.bounds();
    let radius = 0.5 * bounds.size().length();
    if bounds.is_empty() || !radius.is_finite() || radius <= 0.0 {
        1.0
    } else {
        radius
    }
}

/// Rec.709 luminance.
fn luminance(c: Vec3) -> f64 {
    let c = c.as_dvec3();
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}
