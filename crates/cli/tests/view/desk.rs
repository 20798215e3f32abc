//! A display of its own with a window on it, keys and a mouse for it.

use scumble_metrics::Image;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest that anything may take: frames of software Vulkan on a machine that has more to do.
const PATIENCE: Duration = Duration::from_secs(120);

/// A virtual display with the program on it; both end with the value.
pub struct Desk {
    server: Child,
    program: Child,
    display: String,
}

/// Whether a program is there.
fn is_there(program: &str) -> bool {
    let asked = Command::new("which")
        .arg(program)
        .stdout(Stdio::null())
        .status();
    asked.is_ok_and(|status| status.success())
}

/// Whether windows are to be opened, which needs some programs.
pub fn is_asked_for() -> bool {
    let asked = std::env::var_os("SCUMBLE_FULL").is_some_and(|v| v == "1");
    for program in ["Xvfb", "xdotool", "import"] {
        assert!(
            !asked || is_there(program),
            "this test needs {program}: apt-get install xvfb xdotool imagemagick"
        );
    }
    asked
}

impl Desk {
    /// Starts a display, and the program in `folder` on it.
    pub fn new(folder: &Path, args: &[&str]) -> Desk {
        // It chooses a free number, and says which.
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1000x700x24",
                "-nolisten",
                "tcp",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        let told = server.stdout.take().unwrap();
        BufReader::new(told).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let program = Command::new(env!("CARGO_BIN_EXE_scumble"))
            .arg("view")
            .args(args)
            .current_dir(folder)
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .spawn()
            .unwrap();
        let desk = Desk {
            server,
            program,
            display,
        };
        desk.until("a window", || {
            let found = desk.xdotool(&["search", "--onlyvisible", "--name", "scumble view"]);
            found.lines().next().map(str::to_owned)
        });
        // There is no window manager to give it the keys.
        let window = desk.xdotool(&["search", "--name", "scumble view"]);
        desk.xdotool(&["windowfocus", "--sync", window.trim()]);
        desk
    }

    fn xdotool(&self, args: &[&str]) -> String {
        let mut command = Command::new("xdotool");
        let output = command
            .args(args)
            .env("DISPLAY", &self.display)
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    /// Waits for what comes sooner or later.
    pub fn until<T>(&self, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = look() {
                return found;
            }
            assert!(start.elapsed() < PATIENCE, "waited for {what} in vain");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    pub fn hold(&self, key: &str, how_long: Duration) {
        self.xdotool(&["keydown", key]);
        std::thread::sleep(how_long);
        self.xdotool(&["keyup", key]);
    }

    pub fn click(&self, at: [u32; 2]) {
        self.press(at, 1);
    }

    /// Clicks with a button: 1 is the left one, 3 the right one.
    pub fn press(&self, [x, y]: [u32; 2], button: u32) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        // A frame sees the pointer there before it is pressed.
        std::thread::sleep(Duration::from_secs(1));
        self.xdotool(&["click", &button.to_string()]);
    }

    /// Drags from one place to another, slowly enough for frames in between.
    pub fn drag(&self, from: [u32; 2], to: [u32; 2]) {
        let go = |[x, y]: [u32; 2]| {
            self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
            std::thread::sleep(Duration::from_secs(1));
        };
        go(from);
        self.xdotool(&["mousedown", "1"]);
        std::thread::sleep(Duration::from_secs(1));
        go([(from[0] + to[0]) / 2, (from[1] + to[1]) / 2]);
        go(to);
        self.xdotool(&["mouseup", "1"]);
    }

    /// What the display shows, kept under this name where `SCUMBLE_SEEN` names a folder.
    pub fn screen(&self, name: &str) -> Image {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("screen.png");
        let mut command = Command::new("import");
        let taken = command.args(["-window", "root"]).arg(&file);
        assert!(
            taken
                .env("DISPLAY", &self.display)
                .status()
                .unwrap()
                .success()
        );
        if let Some(seen) = std::env::var_os("SCUMBLE_SEEN") {
            std::fs::copy(&file, Path::new(&seen).join(format!("view-{name}.png"))).unwrap();
        }
        scumble_metrics::read(&file).unwrap()
    }

    /// Whether the program still runs.
    pub fn runs(&mut self) -> bool {
        self.program.try_wait().unwrap().is_none()
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        for child in [&mut self.program, &mut self.server] {
            // It may be gone already.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
