//! The figures of a receiver.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use regatta_plugin::frame::FrameHeader;

/// The number of ages that are kept.
const AGES: usize = 1 << 14;

/// Counts frames and their ages.
#[derive(Debug)]
pub struct Figures {
    started: Instant,
    cpu: Option<Duration>,
    /// Frames that were published.
    pub frames: u64,
    /// Frames of the sender that didn't arrive.
    pub missed: u64,
    /// Bytes of frames.
    pub bytes: u64,
    /// The run and the sequence of the last frame.
    last: Option<(u64, u64)>,
    /// The newest ages, in microseconds.
    ages: Vec<u32>,
}

impl Default for Figures {
    fn default() -> Self {
        Self {
            started: Instant::now(),
            cpu: process_time(),
            frames: 0,
            missed: 0,
            bytes: 0,
            last: None,
            ages: Vec::new(),
        }
    }
}

impl Figures {
    /// Notes a frame that was just published, with the header of its sender.
    pub fn note(&mut self, header: &FrameHeader, bytes: usize) {
        if let Some((run, sequence)) = self.last
            && run == header.run_id
        {
            self.missed += header.sequence.saturating_sub(sequence + 1);
        }
        self.last = Some((header.run_id, header.sequence));
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let age = now.saturating_sub(Duration::from_nanos(header.wall_time_nanos));
        let age = u32::try_from(age.as_micros()).unwrap_or(u32::MAX);
        let place = self.frames as usize % AGES;
        match self.ages.get_mut(place) {
            Some(old) => *old = age,
            None => self.ages.push(age),
        }
        self.frames += 1;
        self.bytes += bytes as u64;
    }

    /// The median and the 99th percentile of the age of frames, in milliseconds, by the clocks of
    /// both hosts.
    pub fn ages_ms(&self) -> [f64; 2] {
        let mut ages = self.ages.clone();
        ages.sort_unstable();
        [0.5, 0.99].map(|part| {
            let place = (part * ages.len() as f64) as usize;
            ages.get(place.min(ages.len().saturating_sub(1)))
                .map_or(0.0, |age| f64::from(*age) / 1e3)
        })
    }

    /// The share of a core that this process has used, if the system tells.
    pub fn share_of_core(&self) -> Option<f64> {
        let cpu = process_time()?.saturating_sub(self.cpu?);
        Some(cpu.as_secs_f64() / self.started.elapsed().as_secs_f64().max(1e-9))
    }

    /// The figures as one line for people.
    pub fn summary(&self) -> String {
        let [p50, p99] = self.ages_ms();
        let share = self.share_of_core().unwrap_or_default();
        format!(
            "{} frames, {} missed, age {p50:.1} ms (p99 {p99:.1} ms), {share:.2} of a core",
            self.frames, self.missed
        )
    }

    /// The figures as JSON.
    pub fn json(&self, ignored: u64) -> String {
        let [p50, p99] = self.ages_ms();
        let (seconds, share) = (self.started.elapsed().as_secs_f64(), self.share_of_core());
        let Self { frames, missed, bytes, .. } = self;
        format!(
            "{{\"frames\":{frames},\"missed\":{missed},\"bytes\":{bytes},\"age_p50_ms\":{p50:.3},\
             \"age_p99_ms\":{p99:.3},\"seconds\":{seconds:.3},\"share_of_core\":{},\
             \"messages_ignored\":{ignored}}}",
            share.map_or("null".to_owned(), |share| format!("{share:.4}"))
        )
    }
}

#[cfg(unix)]
fn process_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).ok()
}

#[cfg(not(unix))]
fn process_time() -> Option<Duration> {
    None
}
