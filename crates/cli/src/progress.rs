//! The bar that shows how many frames are done.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar of this many frames; none where nothing is to be said.
pub fn bar(frames: u32, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(frames));
    // The template is a constant; were it wrong, the default would do.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {wide_bar} {pos}/{len} {eta}")
    {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
