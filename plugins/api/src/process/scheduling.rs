//! The processors and the priority of this process.

use core::fmt;
use core::str::FromStr;
use std::io;

use clap::Args;

/// The command-line options of a process that is to be on time.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Processor")]
pub struct SchedulingOptions {
    /// Priority of this process: a nice value from -20 (highest) to 19, or real time: 'fifo', or
    /// 'fifo:N' with N from 1 to 99
    #[arg(long, value_name = "NICE", allow_negative_numbers = true)]
    pub priority: Option<Priority>,
    /// Run this process only on these processors, numbered from 0, separated by commas
    #[arg(long, value_name = "CPU", value_delimiter = ',')]
    pub pin: Vec<usize>,
}

impl SchedulingOptions {
    /// Schedules this thread, and the threads that it starts from here on, in this way.
    ///
    /// # Errors
    /// [`SchedulingError`] if the system refuses.
    pub fn apply(&self) -> Result<(), SchedulingError> {
        if !self.pin.is_empty() {
            pin(&self.pin)?;
        }
        self.priority.map_or(Ok(()), Priority::apply)
    }
}

/// The priority of this process over others.
///
/// ```
/// use regatta_plugin::Priority;
///
/// assert_eq!("-5".parse::<Priority>().unwrap(), Priority::Nice(-5));
/// assert_eq!("fifo:80".parse::<Priority>().unwrap(), Priority::Fifo(80));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Priority {
    /// A nice value, -20 (preferred) to 19. Below 0, the system may require a right to it
    /// (`CAP_SYS_NICE` or `ulimit -e`).
    Nice(i32),
    /// Real time (`SCHED_FIFO`), 1 to 99: nothing of lower priority runs while it wants to. The
    /// system may require a right to it (`CAP_SYS_NICE` or `ulimit -r`).
    Fifo(i32),
}

/// The error of parsing a [`Priority`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid priority '{0}'; give a nice value, -20 to 19, or 'fifo' or 'fifo:N' with N 1 to 99"
)]
pub struct ParsePriorityError(String);

/// The error of changing how this process is scheduled.
#[derive(Debug, thiserror::Error)]
pub enum SchedulingError {
    /// The priority can't be changed.
    #[error(
        "can't set the priority ({0}); the right to it comes with CAP_SYS_NICE, `ulimit -e` or \
         `ulimit -r`"
    )]
    Priority(io::Error),
    /// The process can't be kept on these processors.
    #[error(
        "can't keep the process on processors {cores:?} ({error}); the system has processors 0 to \
         {last}"
    )]
    Pin {
        /// The processors that were asked for.
        cores: Vec<usize>,
        /// The last processor.
        last: usize,
        /// The reason.
        error: io::Error,
    },
}

impl Priority {
    /// The real-time priority of `fifo` without a number: low, so that the kernel's own threads go
    /// first.
    const FIFO: i32 = 10;

    /// Gives this process, and the threads that it starts from here on, this priority.
    ///
    /// # Errors
    /// [`SchedulingError::Priority`], if this user has no right to it, for example.
    pub fn apply(self) -> Result<(), SchedulingError> {
        match self {
            Self::Nice(nice) => set_nice(nice),
            Self::Fifo(priority) => set_fifo(priority),
        }
        .map_err(SchedulingError::Priority)
    }
}

impl fmt::Display for Priority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nice(nice) => write!(f, "{nice}"),
            Self::Fifo(priority) => write!(f, "fifo:{priority}"),
        }
    }
}

impl FromStr for Priority {
    type Err = ParsePriorityError;

    fn from_str(text: &str) -> Result<Self, ParsePriorityError> {
        let fifo = match text.strip_prefix("fifo") {
            Some("") => Some(Ok(Self::FIFO)),
            Some(rest) => rest.strip_prefix(':').map(str::parse),
            None => None,
        };
        match (fifo, text.parse()) {
            (Some(Ok(priority)), _) if (1..=99).contains(&priority) => Ok(Self::Fifo(priority)),
            (None, Ok(nice)) if (-20..=19).contains(&nice) => Ok(Self::Nice(nice)),
            _ => Err(ParsePriorityError(text.to_owned())),
        }
    }
}

#[cfg(unix)]
fn set_nice(nice: i32) -> io::Result<()> {
    Ok(rustix::process::setpriority_process(None, nice)?)
}

#[cfg(not(unix))]
fn set_nice(_nice: i32) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "the standard library and rustix set no policy of scheduling")]
fn set_fifo(priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: the parameters are valid for the call, which changes the calling thread only.
    match unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameters) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

#[cfg(not(target_os = "linux"))]
fn set_fifo(_priority: i32) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Keeps this process, and the threads that it starts from here on, on some processors, numbered
/// from 0.
///
/// # Errors
/// [`SchedulingError::Pin`] if the system has none of them, or can't do that.
#[cfg(target_os = "linux")]
pub fn pin(cores: &[usize]) -> Result<(), SchedulingError> {
    use rustix::thread::{CpuSet, sched_setaffinity};
    let mut set = CpuSet::new();
    for core in cores {
        if *core >= CpuSet::MAX_CPU {
            return Err(pin_error(cores, io::ErrorKind::InvalidInput.into()));
        }
        set.set(*core);
    }
    sched_setaffinity(None, &set).map_err(|error| pin_error(cores, error.into()))
}

#[cfg(target_os = "linux")]
fn pin_error(cores: &[usize], error: io::Error) -> SchedulingError {
    let present = std::fs::read_to_string("/sys/devices/system/cpu/present").unwrap_or_default();
    let last = present.trim().rsplit(['-', ',']).next().and_then(|last| last.parse().ok());
    SchedulingError::Pin { cores: cores.to_vec(), last: last.unwrap_or(0), error }
}

/// Keeps this process on some processors.
///
/// # Errors
/// [`SchedulingError::Pin`]: this system can't do that.
#[cfg(not(target_os = "linux"))]
pub fn pin(cores: &[usize]) -> Result<(), SchedulingError> {
    Err(SchedulingError::Pin {
        cores: cores.to_vec(),
        last: 0,
        error: io::ErrorKind::Unsupported.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priorities_are_parsed() {
        assert_eq!("-5".parse(), Ok(Priority::Nice(-5)));
        assert_eq!("fifo".parse(), Ok(Priority::Fifo(10)));
        assert_eq!("fifo:80".parse(), Ok(Priority::Fifo(80)));
        for bad in ["", "20", "-21", "fifo:0", "fifo:100", "fifo:", "fifo80", "high"] {
            assert_eq!(bad.parse::<Priority>(), Err(ParsePriorityError(bad.to_owned())));
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_thread_stays_where_it_is_pinned() {
        std::thread::spawn(|| {
            pin(&[0]).expect("every machine has it");
            let set = rustix::thread::sched_getaffinity(None).expect("known");
            assert_eq!((set.count(), set.is_set(0)), (1, true));
            let error = pin(&[1000]).expect_err("no such processor").to_string();
            assert!(error.contains("[1000]") && error.contains("0 to "), "{error}");
            assert!(pin(&[usize::MAX]).is_err());
        })
        .join()
        .expect("passed");
    }
}
