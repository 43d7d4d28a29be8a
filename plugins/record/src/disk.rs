//! Reports the growth of a recording, and warns before the disk is full.

use std::collections::VecDeque;
use std::path::Path;
use std::time::Duration;

/// The time after which the rate is reported for the first time.
const FIRST_REPORT: Duration = Duration::from_secs(5);
/// The time over which the current rate is measured.
const WINDOW: Duration = Duration::from_secs(20);
/// A warning is printed when the disk lasts less than each of these.
const WARNINGS: [Duration; 2] = [Duration::from_mins(10), Duration::from_mins(1)];

/// The growth of a recording on its disk.
#[derive(Debug, Default)]
pub(crate) struct Growth {
    /// Times since the start, and the sizes then.
    samples: VecDeque<(Duration, u64)>,
    has_reported: bool,
    /// The number of warnings that were printed since there was enough room.
    warned: usize,
}

impl Growth {
    /// Takes the size of all files of the recording at a time since its start, and the free space
    /// of the disk, if it is known. Returns a line to print, if there is news.
    pub fn observe(&mut self, now: Duration, bytes: u64, free: Option<u64>) -> Option<String> {
        self.samples.push_back((now, bytes));
        while self.samples.len() > 2 && self.samples[1].0 + WINDOW <= now {
            self.samples.pop_front();
        }
        let (rate, lasts) = (self.rate(), free.and_then(|free| self.lasts(free)));
        let warnings =
            WARNINGS.iter().filter(|warning| lasts.is_some_and(|lasts| lasts < **warning)).count();
        let is_first = now >= FIRST_REPORT && !self.has_reported;
        self.has_reported |= is_first;
        let is_urgent = now >= FIRST_REPORT && warnings > self.warned;
        if lasts.is_none_or(|lasts| lasts > 2 * WARNINGS[0]) {
            // With room for twice the time, a warning may come again.
            self.warned = 0;
        } else if is_urgent {
            self.warned = warnings;
        }
        if !is_first && !is_urgent {
            return None;
        }
        let prefix = if warnings > 0 { "the disk will be full soon: " } else { "" };
        Some(format!("{prefix}it grows by {}/s{}", size(rate), room(lasts, free)))
    }

    /// Returns the growth in bytes per second.
    fn rate(&self) -> f64 {
        let (Some((from, before)), Some((to, now))) = (self.samples.front(), self.samples.back())
        else {
            return 0.0;
        };
        now.saturating_sub(*before) as f64 / (*to - *from).as_secs_f64().max(1e-3)
    }

    /// Returns the time after which the free space is used up, or `None` if it practically never
    /// is.
    fn lasts(&self, free: u64) -> Option<Duration> {
        Duration::try_from_secs_f64(free as f64 / self.rate()).ok()
    }
}

/// Describes the free space of the disk, and the time for which it lasts.
fn room(lasts: Option<Duration>, free: Option<u64>) -> String {
    match (lasts, free) {
        (Some(lasts), Some(free)) => {
            format!("; the disk has {}, enough for {}", size(free as f64), rounded(lasts))
        }
        _ => String::new(),
    }
}

/// Returns the mean growth of a recording at its end, and the time for which the disk would last.
pub(crate) fn summary(bytes: u64, time: Duration, free: Option<u64>) -> String {
    let rate = bytes as f64 / time.as_secs_f64().max(1e-3);
    let lasts = free.and_then(|free| Duration::try_from_secs_f64(free as f64 / rate).ok());
    format!("{}/s{}", size(rate), room(lasts, free))
}

/// Returns a size like `20.1 MB`.
pub(crate) fn size(bytes: f64) -> String {
    for (unit, name) in [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")] {
        if bytes >= unit {
            return format!("{:.1} {name}", bytes / unit);
        }
    }
    format!("{bytes:.0} B")
}

/// Returns a time like `29 min`.
fn rounded(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7_200 => format!("{} min", seconds / 60),
        7_200..172_800 => format!("{} h", seconds / 3_600),
        172_800..31_536_000 => format!("{} days", seconds / 86_400),
        _ => "more than a year".to_owned(),
    }
}

/// Returns the space on the disk of a file that this process may use, or `None` if it is unknown.
#[cfg(unix)]
pub(crate) fn free_space(file: &Path) -> Option<u64> {
    let folder =
        file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let disk = rustix::fs::statvfs(folder).ok()?;
    disk.f_bavail.checked_mul(disk.f_frsize)
}

/// Returns the space on the disk of a file that this process may use, or `None` if it is unknown.
#[cfg(not(unix))]
pub(crate) fn free_space(_file: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const MB: u64 = 1_000_000;

    /// Returns what is said about a recording of 20 MB/s, per second, with the free space at the
    /// start.
    fn said(seconds: u64, free: u64) -> Vec<(u64, String)> {
        let mut growth = Growth::default();
        let mut at = |second: u64| {
            let bytes = second * 20 * MB;
            growth.observe(Duration::from_secs(second), bytes, Some(free.saturating_sub(bytes)))
        };
        (0..seconds).filter_map(|second| at(second).map(|line| (second, line))).collect()
    }

    #[test]
    fn the_rate_is_said_once_if_there_is_room() {
        let line = "it grows by 20.0 MB/s; the disk has 99.9 GB, enough for 83 min".to_owned();
        assert_eq!(said(1000, 100_000 * MB), [(5, line)]);
    }

    #[test]
    fn a_full_disk_is_announced_ten_minutes_and_one_minute_before() {
        let said = said(1000, 16_000 * MB);
        let seconds: Vec<_> = said.iter().map(|(second, _)| *second).collect();
        assert_eq!(seconds, [5, 201, 741]);
        assert_eq!(
            said[2].1,
            "the disk will be full soon: it grows by 20.0 MB/s; the disk has 1.2 GB, enough for 59 \
             s"
        );
    }

    #[test]
    fn a_disk_that_is_nearly_full_at_the_start_is_announced_once() {
        let said = said(20, 5_000 * MB);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].1.starts_with("the disk will be full soon"), "{said:?}");
    }

    #[test]
    fn a_recording_that_does_not_grow_fills_no_disk() {
        let mut growth = Growth::default();
        for second in 0..100 {
            let line = growth.observe(Duration::from_secs(second), 1000, Some(5));
            assert_eq!(line, (second == 5).then(|| "it grows by 0 B/s".to_owned()));
        }
        assert!(free_space(Path::new("run.mcap")).is_none_or(|free| free > 0));
    }
}
