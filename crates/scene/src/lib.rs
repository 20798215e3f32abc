//! See README.md.

pub mod animation;
mod bvh;
mod camera;
mod deform;
mod gpu;
mod model;
mod pose;
mod sample;
mod stats;

pub use animation::Animation;
pub use gpu::{BuildQuality, Draw, GpuScene, GpuSceneError, GpuSceneOptions, wgsl_modules};
pub use model::{
    Aabb, Camera, Deformed, Instance, Light, Material, Mesh, Pose, Scene, Sky, Stats, TextureImage,
    TextureRef, Wrap,
};
