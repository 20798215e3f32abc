//! The frame graph's levers, which the environment sets.

use crate::failure::Failure;
use framegraph::Debug;

/// What `--help` says of them.
pub const HELP: &str = "\
Environment:
  FRAMEGRAPH_DEBUG  Levers of the frame graph, separated by commas: no_cull, no_group, no_reuse, no_batch,
                    no_cache, clobber, labels, timestamps. The image stays the same";

/// The levers that `FRAMEGRAPH_DEBUG` names.
pub fn read() -> Result<Debug, Failure> {
    let levers = Debug::from_env()?;
    match levers.capture.first() {
        // A lever that does nothing would be a lie.
        Some(capture) => Err(Failure::Capture(capture.clone())),
        None => Ok(levers),
    }
}
