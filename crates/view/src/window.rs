//! The window and its loop of events.

use crate::error::ViewError;
use crate::options::Options;
use scumble::Registry;
use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

/// Opens the window, and comes back when it is closed.
///
/// # Errors
/// Without a display or a graphics adapter, where the graph cannot be read or built, and when the device is lost.
pub fn run(_options: Options, _registry: &Registry) -> Result<(), ViewError> {
    let _events = EventLoop::new().map_err(no_display)?;
    Ok(())
}

fn no_display(error: EventLoopError) -> ViewError {
    match error {
        EventLoopError::Os(error) => ViewError::NoDisplay(error.to_string()),
        other => ViewError::NoDisplay(other.to_string()),
    }
}
