//! Between Bevy's numbers and the scene's: both are right-handed with Y up and metres, but their vectors are of two versions
//! of glam; light is in cd m^-2, and in units in which it is about 1.

use bevy::camera::Exposure;
use bevy::color::LinearRgba;

/// Luminance in cd m^-2 times this is radiance in the scene.
///
/// It is Bevy's own default exposure, so that what is seen well is about 1 and far from the limits of 16-bit floats.
pub(crate) fn unit() -> f32 {
    Exposure::default().exposure()
}

/// A vector.
pub(crate) fn vec3(v: impl Into<[f32; 3]>) -> glam::Vec3 {
    v.into().into()
}

/// A colour, negative parts cut off.
pub(crate) fn rgb(color: impl Into<LinearRgba>) -> glam::Vec3 {
    let color = color.into();
    glam::Vec3::new(color.red, color.green, color.blue).max(glam::Vec3::ZERO)
}

/// A transform.
pub(crate) fn affine(a: bevy::math::Affine3A) -> glam::Affine3A {
    glam::Affine3A::from_cols_array(&a.to_cols_array())
}
