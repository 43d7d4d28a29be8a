//! A screen in memory: an X server of its own, whose pixels lie in a file, and hands.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::fleet::eventually;

/// Pixels of the screen.
pub const SIZE: (usize, usize) = (1280, 720);

pub struct Screen {
    server: Child,
    display: String,
    folder: TempDir,
}

/// One look at the screen: rows of pixels, blue, green and red.
#[derive(Clone, PartialEq, Eq)]
pub struct Look(Vec<[u8; 3]>);

impl Screen {
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let geometry = format!("{}x{}x24", SIZE.0, SIZE.1);
        // A server that begins anew after its last client turns away who comes meanwhile: hence -noreset.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &geometry, "-nolisten", "tcp", "-noreset", "-fbdir"])
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

    /// Makes a program show its windows here, and keep its settings here.
    pub fn dress(&self, command: &mut Command) {
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env("XDG_CONFIG_HOME", self.folder.path());
    }

    /// The settings that the viewer has kept.
    pub fn settings(&self) -> Option<serde_json::Value> {
        serde_json::from_slice(&std::fs::read(self.settings_path()).ok()?).ok()
    }

    pub fn settings_path(&self) -> PathBuf {
        self.folder.path().join("regatta").join("viewer.json")
    }

    /// What xdotool prints.
    pub fn hand(&self, args: &[&str]) -> Option<String> {
        let output = Command::new("xdotool").args(args).env("DISPLAY", &self.display).output().expect("xdotool starts");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Does something with mouse or keyboard.
    pub fn must(&self, args: &[&str]) {
        assert!(self.hand(args).is_some(), "xdotool {args:?}");
    }

    /// The window of that title, which then gets the keys.
    pub fn window(&self, title: &str) -> String {
        let id = eventually("the window opens", || {
            let found = self.hand(&["search", "--name", title])?;
            found.lines().next().map(str::to_owned)
        });
        eventually("the window takes the keys", || self.hand(&["windowfocus", &id]));
        id
    }

    /// Goes from one place to another with a button down, in steps as a hand does.
    pub fn drag(&self, button: &str, from: (i32, i32), to: (i32, i32)) {
        let go = |part: i32| {
            let at = [(from.0, to.0), (from.1, to.1)].map(|(from, to)| (from + (to - from) * part / 10).to_string());
            self.must(&["mousemove", &at[0], &at[1]]);
        };
        go(0);
        self.must(&["mousedown", button]);
        (1..=10).for_each(go);
        self.must(&["mouseup", button]);
    }

    /// The pixels now. Xvfb keeps them in a file of xwd's format.
    pub fn look(&self) -> Look {
        let bytes = std::fs::read(self.folder.path().join("Xvfb_screen0")).expect("the screen's file");
        let word = |i: usize| u32::from_be_bytes(bytes[i * 4..][..4].try_into().expect("a word")) as usize;
        let (header, width, height, row, colours) = (word(0), word(4), word(5), word(12), word(19));
        let pixels = &bytes[header + colours * 12..];
        let pixel = |x: usize, y: usize| pixels[y * row + x * 4..][..3].try_into().expect("a pixel");
        Look((0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect())
    }

    /// Waits until the screen stands still, and gives its look.
    pub fn still(&self) -> Look {
        let mut last = self.look();
        eventually("the picture stands still", || {
            std::thread::sleep(std::time::Duration::from_millis(700));
            let now = self.look();
            let same = now == last;
            last = now;
            same.then(|| last.clone())
        })
    }
}

impl Look {
    /// Pixels that differ within a rectangle.
    pub fn differing(&self, other: &Self, x: std::ops::Range<usize>, y: std::ops::Range<usize>) -> usize {
        let places = y.flat_map(|y| x.clone().map(move |x| y * SIZE.0 + x));
        places.filter(|place| self.0[*place] != other.0[*place]).count()
    }

    /// Different colours.
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
