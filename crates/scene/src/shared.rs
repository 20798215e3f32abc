//! Where the test data lies: real scenes and images of other renderers, which the repository does not hold.

use std::path::{Path, PathBuf};

/// A file or folder of the shared test data, such as `scenes/kitchen.glb`: below the folder that the
/// environment variable `SCUMBLE_SHARED` names, else below a folder `shared` in the current folder or
/// in one above it. `None` where it is not there.
pub fn shared(path: impl AsRef<Path>) -> Option<PathBuf> {
    let found = match std::env::var_os("SCUMBLE_SHARED") {
        Some(folder) => PathBuf::from(folder).join(path),
        None => {
            let here = std::env::current_dir().ok()?;
            here.ancestors()
                .map(|folder| folder.join("shared").join(path.as_ref()))
                .find(|file| file.exists())?
        }
    };
    found.exists().then_some(found)
}
