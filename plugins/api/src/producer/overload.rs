//! Messages to the user while ticks are late, with the processes that use the processor.

use std::collections::HashMap;
use std::fs;
use std::time::{Duration, Instant};

use crate::process::join::Participant;

/// The time between two checks.
const CHECK: Duration = Duration::from_secs(2);
/// The shortest time between two messages. It doubles with each, up to [`LONGEST_SILENCE`].
const SILENCE: Duration = Duration::from_secs(10);
/// The longest time between two messages.
const LONGEST_SILENCE: Duration = Duration::from_secs(600);
/// The part of ticks that may be late without a message.
const TOLERATED: f64 = 0.05;
/// The part of the time that the producer waits for a processor from which on others are the
/// reason.
const CROWDED: f64 = 0.05;
/// The time over which the processor times of other processes are compared.
const SAMPLE: Duration = Duration::from_millis(500);
/// The largest number of processes that a message names.
const NAMED: usize = 3;

/// The late ticks since the start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LateTicks {
    /// All of them.
    pub all: u64,
    /// Those that were given up.
    pub skipped: u64,
}

/// Watches the late ticks of a producer.
#[derive(Debug)]
pub(super) struct Overload {
    next_check: Instant,
    next_message: Instant,
    silence: Duration,
    ticks: u64,
    late_before: LateTicks,
    /// The time that this thread had waited for a processor at the last check.
    waited_before: Option<Duration>,
}

impl Overload {
    pub(super) fn new(now: Instant) -> Self {
        Self {
            next_check: now + CHECK,
            next_message: now,
            silence: SILENCE,
            ticks: 0,
            late_before: LateTicks::default(),
            waited_before: waited_for_processor(),
        }
    }

    /// Records ticks, and the late ones since the start. Costs a comparison, except every two
    /// seconds.
    pub(super) fn note(
        &mut self,
        ticks: u64,
        late: LateTicks,
        now: Instant,
        producer: &Participant,
    ) {
        self.ticks += ticks;
        if now < self.next_check {
            return;
        }
        let seconds = (now - (self.next_check - CHECK)).as_secs_f64();
        let before = std::mem::replace(&mut self.late_before, late);
        let skipped = late.skipped.saturating_sub(before.skipped);
        let late = late.all.saturating_sub(before.all);
        let waited = waited_for_processor();
        let share = match (waited, self.waited_before) {
            (Some(waited), Some(before)) => waited.saturating_sub(before).as_secs_f64() / seconds,
            _ => 0.0,
        };
        let ticks = std::mem::take(&mut self.ticks) + skipped;
        (self.waited_before, self.next_check) = (waited, now + CHECK);
        if late as f64 > ticks as f64 * TOLERATED && now >= self.next_message {
            self.next_message = now + self.silence;
            self.silence = (2 * self.silence).min(LONGEST_SILENCE);
            let begin = format!(
                "{}: fleet '{}': {late} of {ticks} ticks that were due in the last {seconds:.0} s \
                 were late",
                producer.name(),
                producer.fleet()
            );
            tell(begin, share);
        }
    }
}

/// Tells the user of late ticks. A thread of its own finds the processes that use the processor,
/// because that takes a while.
fn tell(begin: String, share: f64) {
    if share < CROWDED {
        crate::tell!(
            "{begin}: a tick takes longer than its period; try fewer robots, a lower --rate or \
             more --threads"
        );
        return;
    }
    // Without a thread there is no message.
    let _ = std::thread::Builder::new().name("overload".to_owned()).spawn(move || {
        let others = others().join(", ");
        let others = if others.is_empty() { String::new() } else { format!(": {others}") };
        crate::tell!(
            "{begin}: {:.0} % of the time it waited for a processor that others used{others}; \
             --priority and --pin may help",
            share * 100.0
        );
    });
}

/// Returns the time that this thread has waited for a processor while it could run.
fn waited_for_processor() -> Option<Duration> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().nth(1)?.parse().ok().map(Duration::from_nanos)
}

/// Returns the processes that used the processor most: `rustc 4711 (87 %)`.
fn others() -> Vec<String> {
    let before = processor_times();
    std::thread::sleep(SAMPLE);
    let mut used: Vec<_> = processor_times()
        .into_iter()
        .filter_map(|(pid, (name, ticks))| {
            let ticks = ticks.saturating_sub(before.get(&pid)?.1);
            (ticks > 0 && pid != std::process::id()).then_some((ticks, name, pid))
        })
        .collect();
    used.sort_by(|a, b| b.cmp(a));
    let all = clock_ticks_per_second() as f64 * SAMPLE.as_secs_f64();
    let worst = used
        .into_iter()
        .take(NAMED)
        .map(|(ticks, name, pid)| format!("{name} {pid} ({:.0} %)", ticks as f64 / all * 100.0));
    worst.collect()
}

#[cfg(unix)]
fn clock_ticks_per_second() -> u64 {
    rustix::param::clock_ticks_per_second()
}

/// Other systems have no `/proc`, and no times to convert.
#[cfg(not(unix))]
fn clock_ticks_per_second() -> u64 {
    1
}

/// Returns the name of each process, and the processor time that it has used, in clock ticks.
fn processor_times() -> HashMap<u32, (String, u64)> {
    let Ok(processes) = fs::read_dir("/proc") else { return HashMap::new() };
    let times = processes.flatten().filter_map(|entry| {
        let pid = entry.file_name().to_str()?.parse().ok()?;
        Some((pid, parse_stat(&fs::read_to_string(entry.path().join("stat")).ok()?)?))
    });
    times.collect()
}

/// Parses `/proc/PID/stat`: the name, in parentheses, and the sum of the fields `utime` and `stime`
/// (proc(5)).
fn parse_stat(text: &str) -> Option<(String, u64)> {
    let (before, after) = text.rsplit_once(')')?;
    let (_, name) = before.split_once('(')?;
    let mut fields = after.split_whitespace().skip(11);
    let [user, system]: [u64; 2] = [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?];
    Some((name.to_owned(), user + system))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_whose_name_has_parentheses_is_parsed() {
        let text = "4711 (a (b) c) S 1 2 3 4 5 6 7 8 9 10 100 23 0 0 20 0 1";
        assert_eq!(parse_stat(text), Some(("a (b) c".to_owned(), 123)));
        assert_eq!(parse_stat("4711 (short) S 1"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_a_processor_time() {
        assert!(processor_times().contains_key(&std::process::id()));
        assert!(waited_for_processor().is_some());
    }
}
