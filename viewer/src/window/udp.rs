//! The UDP programs that the user starts from the interface. They are child processes.

use std::ffi::OsString;
use std::process::Child;
use std::time::{Duration, Instant};

use regatta_interface::view_model::{Action, RunningUdp};
use regatta_plugin::FleetName;

use super::child::ChildProcess;

/// The time that child processes have to end when the viewer ends.
const GRACE: Duration = Duration::from_secs(2);

/// The UDP source, the UDP sender, and former ones that were asked to end.
#[derive(Debug, Default)]
pub struct UdpProcesses {
    source: Option<ChildProcess>,
    sender: Option<ChildProcess>,
    ending: Vec<ChildProcess>,
}

impl UdpProcesses {
    /// Starts or stops a program; ignores all other actions. Returns an error message for the user.
    pub fn carry_out(&mut self, action: &Action, fleet: &FleetName) -> Option<String> {
        let started = match action {
            Action::StartUdpSource { listen, echo_to, offset } => {
                let mut args = vec!["--listen", listen];
                // The answers contain positions as shown, so they need the offset.
                let offset = format!("--offset={},{}", offset.x, offset.y);
                args.extend(echo_to.iter().flat_map(|echo_to| ["--echo-to", echo_to, &offset]));
                self.stop(|udp| &mut udp.source);
                start("udp-source", &args, fleet).map(|process| self.source = Some(process))
            }
            Action::StartUdpSender { to } => {
                self.stop(|udp| &mut udp.sender);
                start("udp", &["--to", to], fleet).map(|process| self.sender = Some(process))
            }
            Action::StopUdpSource => return self.stop(|udp| &mut udp.source),
            Action::StopUdpSender => return self.stop(|udp| &mut udp.sender),
            _ => return None,
        };
        started.err().map(|error| format!("can't start UDP: {error}"))
    }

    fn stop(&mut self, which: impl Fn(&mut Self) -> &mut Option<ChildProcess>) -> Option<String> {
        let mut process = which(self).take()?;
        ask_to_end(&mut process.child);
        self.ending.push(process);
        None
    }

    /// Returns the programs that are running.
    pub fn running(&self) -> RunningUdp {
        RunningUdp { receives: self.source.is_some(), sends: self.sender.is_some() }
    }

    /// Removes the processes that have ended, and returns the messages of those that have failed.
    pub fn remove_ended(&mut self) -> Vec<String> {
        self.ending.retain_mut(ChildProcess::is_running);
        [&mut self.source, &mut self.sender].into_iter().filter_map(remove_ended).collect()
    }
}

impl Drop for UdpProcesses {
    fn drop(&mut self) {
        self.stop(|udp| &mut udp.source);
        self.stop(|udp| &mut udp.sender);
        let deadline = Instant::now() + GRACE;
        while !self.ending.is_empty() && Instant::now() < deadline {
            self.ending.retain_mut(ChildProcess::is_running);
            std::thread::sleep(Duration::from_millis(5));
        }
        for process in &mut self.ending {
            // Errors mean that it has ended.
            let _ = process.child.kill();
            let _ = process.child.wait();
        }
    }
}

fn start(plugin: &str, args: &[&str], fleet: &FleetName) -> std::io::Result<ChildProcess> {
    let fleet = fleet.to_string();
    let words = [&["plugin", plugin], args, &["--fleet", &fleet]].concat();
    ChildProcess::start(plugin, words.into_iter().map(OsString::from))
}

#[cfg(unix)]
fn ask_to_end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = Pid::from_raw(child.id() as i32) {
        // An error means that it has just ended by itself.
        let _ = kill_process(pid, Signal::TERM);
    }
}

/// Other systems have no signal for it.
#[cfg(not(unix))]
fn ask_to_end(child: &mut Child) {
    // An error means that it has just ended by itself.
    let _ = child.kill();
}

/// Removes a process that has ended by itself, and returns its message if it has failed.
fn remove_ended(process: &mut Option<ChildProcess>) -> Option<String> {
    let outcome = process.as_mut()?.outcome()?;
    *process = None;
    outcome.map(|message| format!("UDP: {message}"))
}
