//! Why the window cannot open, or had to close.

use crate::running::StartError;

/// Why the window cannot open, or had to close.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// Nothing to open a window on.
    #[error("there is no display to open a window on ({0}); `scumble render` needs none")]
    NoDisplay(String),
    /// The window system refuses.
    #[error("the window cannot be opened: {0}")]
    Window(String),
    /// No adapter can draw to this window; there are these.
    #[error("none of {0} can draw to a window here; `scumble render` needs none")]
    NoSurface(String),
    /// No device, or what went wrong on it.
    #[error(transparent)]
    Device(#[from] scumble_lab::DeviceError),
    /// The device went away.
    #[error("the graphics device is lost ({0}); nothing is left to draw with, start again")]
    Lost(String),
    /// The graph, at the start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A frame of a graph that ran before.
    #[error(transparent)]
    Render(#[from] scumble::RenderError),
    /// What its passes need.
    #[error(transparent)]
    Pipeline(#[from] scumble::PipelineError),
    /// What paints ports.
    #[error(transparent)]
    Display(#[from] crate::display::DisplayError),
    /// The scene does not fit the device.
    #[error(transparent)]
    Scene(#[from] scumble_scene::GpuSceneError),
    /// The scene has no such camera.
    #[error(transparent)]
    NoCamera(#[from] scumble_lab::NoCamera),
}
