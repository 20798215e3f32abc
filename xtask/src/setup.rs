//! A graphics adapter for machines that have none: Mesa's software Vulkan driver, from the system's
//! own package manager.

use crate::command::{Done, Failure, command, run as run_command, scumble};
use std::process::Stdio;

/// A package manager and what a software Vulkan driver and the Vulkan loader are called in it.
struct Manager {
    program: &'static str,
    /// Run first; a fresh system has no package lists.
    refresh: Option<&'static [&'static str]>,
    install: &'static [&'static str],
}

const MANAGERS: [Manager; 5] = [
    Manager {
        program: "apt-get",
        refresh: Some(&["apt-get", "update"]),
        install: &[
            "apt-get",
            "install",
            "--yes",
            "mesa-vulkan-drivers",
            "libvulkan1",
        ],
    },
    Manager {
        program: "dnf",
        refresh: None,
        install: &[
            "dnf",
            "install",
            "--assumeyes",
            "mesa-vulkan-drivers",
            "vulkan-loader",
        ],
    },
    Manager {
        program: "pacman",
        refresh: None,
        install: &[
            "pacman",
            "-S",
            "--needed",
            "--noconfirm",
            "vulkan-swrast",
            "vulkan-icd-loader",
        ],
    },
    Manager {
        program: "zypper",
        refresh: None,
        install: &[
            "zypper",
            "--non-interactive",
            "install",
            "libvulkan_lvp",
            "libvulkan1",
        ],
    },
    Manager {
        program: "apk",
        refresh: None,
        install: &["apk", "add", "mesa-vulkan-swrast", "vulkan-loader"],
    },
];

const BY_HAND: &str = "install a Vulkan driver (Mesa's lavapipe runs without a GPU; most systems \
                       call its package mesa-vulkan-drivers or vulkan-swrast), then try again";

/// Nothing, if the program finds an adapter; otherwise installs the driver and looks again.
pub fn run() -> Done {
    run_command(crate::command::cargo(&[
        "build",
        "--quiet",
        "--package",
        "scumble-cli",
    ]))?;
    if has_adapter()? {
        return Ok(());
    }
    if !cfg!(target_os = "linux") {
        return Err(impossible(
            "this system offers no graphics adapter to wgpu".into(),
        ));
    }
    let root = id_of_user() == Some(0);
    let plan = plan(&|program| on_path(program), root).map_err(impossible)?;
    eprintln!("There is no Vulkan driver here. Installing Mesa's software driver:");
    let mut done = Ok(());
    for words in plan {
        done = run_command(command(&words[0], &words[1..]));
    }
    // The last step decides: stale package lists may be good enough.
    done.map_err(|e| impossible(format!("{}; {BY_HAND}", e.message)))?;
    if has_adapter()? {
        return Ok(());
    }
    Err(impossible(format!(
        "the driver was installed, but no adapter is found; {BY_HAND}"
    )))
}

fn impossible(message: String) -> Failure {
    Failure { message, code: 2 }
}

/// Whether the program itself finds an adapter: the only answer that counts.
fn has_adapter() -> Done<bool> {
    let mut look = scumble(&["adapters"]);
    let status = look.stdout(Stdio::null()).stderr(Stdio::null()).status();
    match status {
        Ok(status) => Ok(status.success()),
        Err(e) => Err(impossible(format!("cannot run scumble: {e}"))),
    }
}

/// The commands that install the driver, given which programs there are.
fn plan(has: &dyn Fn(&str) -> bool, root: bool) -> Result<Vec<Vec<String>>, String> {
    let Some(manager) = MANAGERS.iter().find(|m| has(m.program)) else {
        let known = MANAGERS.map(|m| m.program).join(", ");
        return Err(format!(
            "there is no Vulkan driver, and none of {known} is here; {BY_HAND}"
        ));
    };
    if !root && !has("sudo") {
        let typed = manager.install.join(" ");
        return Err(format!(
            "there is no Vulkan driver, and installing one needs root: {typed}"
        ));
    }
    let sudo = if root { None } else { Some("sudo") };
    let steps = manager.refresh.into_iter().chain([manager.install]);
    Ok(steps
        .map(|step| sudo.iter().chain(step).map(|w| w.to_string()).collect())
        .collect())
}

fn id_of_user() -> Option<u32> {
    let output = command("id", &["-u"]).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

#[cfg(test)]
mod tests {
    use super::plan;

    fn typed(programs: &[&str], root: bool) -> Result<Vec<String>, String> {
        let steps = plan(&|program| programs.contains(&program), root)?;
        Ok(steps.iter().map(|words| words.join(" ")).collect())
    }

    #[test]
    fn debian_as_root_refreshes_its_lists_first() {
        assert_eq!(
            typed(&["apt-get"], true).unwrap(),
            [
                "apt-get update",
                "apt-get install --yes mesa-vulkan-drivers libvulkan1"
            ]
        );
    }

    #[test]
    fn a_user_needs_sudo() {
        assert_eq!(
            typed(&["apk", "sudo"], false).unwrap(),
            ["sudo apk add mesa-vulkan-swrast vulkan-loader"]
        );
        assert_eq!(
            typed(&["apk"], false).unwrap_err(),
            "there is no Vulkan driver, and installing one needs root: \
             apk add mesa-vulkan-swrast vulkan-loader"
        );
    }

    #[test]
    fn an_unknown_system_is_told_what_to_do() {
        let message = typed(&["brew"], true).unwrap_err();
        assert!(message.starts_with(
            "there is no Vulkan driver, and none of apt-get, dnf, pacman, zypper, apk is here; \
             install a Vulkan driver"
        ));
    }
}
