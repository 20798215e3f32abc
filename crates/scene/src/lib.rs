#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod animation;
mod builder;
mod builtin;
mod bvh;
mod camera;
mod check;
mod deform;
mod error;
mod export;
mod geometry;
mod gltf;
mod gpu;
mod model;
mod pose;
mod sample;
mod shared;
mod stats;

pub use animation::Animation;
pub use builder::SceneBuilder;
pub use builtin::{BUILTIN_NAMES, builtin, moving};
pub use error::SceneError;
pub use export::{export, to_glb};
pub use gltf::{LoadOptions, MaterialOverride, load, load_bytes};
pub use gpu::{BuildQuality, Draw, GpuScene, GpuSceneError, GpuSceneOptions, wgsl_modules};
pub use model::{
    Aabb, Camera, Deformed, Instance, Light, Material, Mesh, Pose, Scene, Sky, Stats, TextureImage,
    TextureRef, Wrap,
};
pub use shared::shared;
