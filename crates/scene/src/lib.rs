//! See README.md.

pub mod animation;
mod camera;
mod deform;
mod model;
mod pose;
mod sample;
mod stats;

pub use animation::Animation;
pub use model::{
    Aabb, Camera, Deformed, Instance, Light, Material, Mesh, Pose, Scene, Sky, Stats, TextureImage,
    TextureRef, Wrap,
};
