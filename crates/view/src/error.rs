//! Why the window cannot open, or had to close.

/// Why the window cannot open, or had to close.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// Nothing to open a window on.
    #[error("there is no display to open a window on ({0}); `scumble render` needs none")]
    NoDisplay(String),
    /// The window system refuses.
    #[error("the window cannot be opened: {0}")]
    Window(String),
}
