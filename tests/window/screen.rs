//! A virtual display: an X server whose pixels are in a file, with input from xdotool.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::fleet::eventually;

/// Width and height of the screen, in pixels.
pub const SIZE: (usize, usize) = (1280, 720);

/// A virtual display, and a folder for the settings of its programs.
pub struct Screen {
    server: Child,
    display: String,
    folder: TempDir,
}

/// A screenshot: rows of pixels, each blue, green and red.
#[derive(Clone, PartialEq, Eq)]
pub struct Screenshot(Vec<[u8; 3]>);

impl Screen {
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let geometry = format!("{}x{}x24", SIZE.0, SIZE.1);
        // Without -noreset the server resets after its last client, and meanwhile rejects new
        // clients.
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                &geometry,
                "-nolisten",
                "tcp",
                "-noreset",
                "-fbdir",
            ])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let stdout = server.stdout.take().expect("its output");
        BufReader::new(stdout).read_line(&mut number).expect("the display's number");
        Self { server, display: format!(":{}", number.trim()), folder }
    }

    /// Ends the server, as a crash does.
    pub fn kill(&mut self) {
        self.server.kill().expect("it runs");
        self.server.wait().expect("it has ended");
    }

    /// Makes a program show its windows on this display and store its settings in this folder.
    pub fn configure(&self, command: &mut Command) {
        command
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", self.folder.path());
    }

    /// Returns the settings that the viewer has stored.
    pub fn settings(&self) -> Option<serde_json::Value> {
        serde_json::from_slice(&std::fs::read(self.settings_path()).ok()?).ok()
    }

    pub fn settings_path(&self) -> PathBuf {
        self.folder.path().join("regatta").join("viewer.json")
    }

    /// Runs xdotool, and returns its output if it succeeds.
    pub fn try_xdotool(&self, args: &[&str]) -> Option<String> {
        let output = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool starts");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Runs xdotool, which must succeed.
    pub fn xdotool(&self, args: &[&str]) {
        assert!(self.try_xdotool(args).is_some(), "xdotool {args:?}");
    }

    /// Waits for the window with a title, gives it the keyboard focus and returns its id.
    pub fn window(&self, title: &str) -> String {
        let id = eventually("the window opens", || {
            let found = self.try_xdotool(&["search", "--name", title])?;
            found.lines().next().map(str::to_owned)
        });
        eventually("the window gets the focus", || self.try_xdotool(&["windowfocus", &id]));
        id
    }

    /// Moves the pointer from one place to another with a button down, in steps as a user does.
    pub fn drag(&self, button: &str, from: (i32, i32), to: (i32, i32)) {
        let move_to = |part: i32| {
            let at = [(from.0, to.0), (from.1, to.1)]
                .map(|(from, to)| (from + (to - from) * part / 10).to_string());
            self.xdotool(&["mousemove", &at[0], &at[1]]);
        };
        move_to(0);
        self.xdotool(&["mousedown", button]);
        (1..=10).for_each(move_to);
        self.xdotool(&["mouseup", button]);
    }

    /// Takes a screenshot. Xvfb keeps the pixels in a file in the format of xwd.
    pub fn screenshot(&self) -> Screenshot {
        let bytes =
            std::fs::read(self.folder.path().join("Xvfb_screen0")).expect("the screen's file");
        let word =
            |i: usize| u32::from_be_bytes(bytes[i * 4..][..4].try_into().expect("a word")) as usize;
        let (header, width, height, row, colours) = (word(0), word(4), word(5), word(12), word(19));
        let pixels = &bytes[header + colours * 12..];
        let pixel =
            |x: usize, y: usize| pixels[y * row + x * 4..][..3].try_into().expect("a pixel");
        Screenshot(
            (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| pixel(x, y))
                .collect(),
        )
    }

    /// Waits until the screen does not change any more, and returns a screenshot.
    pub fn stable_screenshot(&self) -> Screenshot {
        let mut last = self.screenshot();
        eventually("the screen is stable", || {
            std::thread::sleep(std::time::Duration::from_millis(700));
            let now = self.screenshot();
            let same = now == last;
            last = now;
            same.then(|| last.clone())
        })
    }
}

impl Screenshot {
    /// Returns the number of pixels within a rectangle that differ.
    pub fn differing(
        &self,
        other: &Self,
        x: std::ops::Range<usize>,
        y: std::ops::Range<usize>,
    ) -> usize {
        let places = y.flat_map(|y| x.clone().map(move |x| y * SIZE.0 + x));
        places.filter(|place| self.0[*place] != other.0[*place]).count()
    }

    /// Returns the number of pixels within a rectangle that are like one of some colours, each red,
    /// green and blue.
    pub fn like(
        &self,
        colours: &[[u8; 3]],
        x: std::ops::Range<usize>,
        y: std::ops::Range<usize>,
    ) -> usize {
        let pixels =
            y.flat_map(|y| x.clone().map(move |x| y * SIZE.0 + x)).map(|place| self.0[place]);
        pixels.filter(|pixel| colours.iter().any(|colour| is_near(*pixel, *colour))).count()
    }

    /// Returns the number of different colours.
    pub fn colours(&self) -> usize {
        let mut all = self.0.clone();
        all.sort_unstable();
        all.dedup();
        all.len()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Whether a pixel (blue, green and red) looks like a colour (red, green and blue).
fn is_near([b, g, r]: [u8; 3], colour: [u8; 3]) -> bool {
    [r, g, b].into_iter().zip(colour).all(|(found, wanted)| found.abs_diff(wanted) <= 3)
}
