//! Where the test data lies: real scenes and images of other renderers, which the repository does not hold.

use std::path::{Path, PathBuf};

/// A file or folder of the shared test data, such as `scenes/kitchen.glb`: below the folder that the
/// environment variable `SCUMBLE_SHARED` names, else below a folder `shared` beside the checkout that the
/// current folder is in (beside the current folder where that is in none). `None` where it is not there.
pub fn shared(path: impl AsRef<Path>) -> Option<PathBuf> {
    let folder = match std::env::var_os("SCUMBLE_SHARED") {
        Some(folder) => PathBuf::from(folder),
        None => {
            let here = std::env::current_dir().ok()?;
            let checkout = here.ancestors().find(|f| f.join("Cargo.lock").is_file());
            checkout.unwrap_or(&here).parent()?.join("shared")
        }
    };
    let found = folder.join(path);
    found.exists().then_some(found)
}
