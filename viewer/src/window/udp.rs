//! The UDP programs that a person starts from the interface: children of this process.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use regatta_plugin::{FleetName, PARENT_VARIABLE};

use crate::interface::facts::Action;

/// How long children may take to end when the viewer ends.
const GRACE: Duration = Duration::from_secs(2);

/// The source, the sender, and those that were asked to end.
#[derive(Debug, Default)]
pub struct Udp {
    source: Option<Program>,
    sender: Option<Program>,
    leaving: Vec<Program>,
}

#[derive(Debug)]
struct Program {
    child: Child,
    /// The last line of what it said.
    said: Arc<Mutex<String>>,
}

impl Udp {
    /// Does what a person asks for; gives what to tell.
    pub fn act(&mut self, action: &Action, fleet: &FleetName) -> Option<String> {
        let started = match action {
            Action::StartUdpSource { listen, echo_to, offset } => {
                let mut args = vec!["--listen", listen];
                // What answers is what is seen, so the offset goes with it.
                let offset = format!("--offset={},{}", offset.x, offset.y);
                args.extend(echo_to.iter().flat_map(|echo_to| ["--echo-to", echo_to, &offset]));
                self.leave(|udp| &mut udp.source);
                start("udp-source", &args, fleet).map(|program| self.source = Some(program))
            }
            Action::StartUdpSender { to } => {
                self.leave(|udp| &mut udp.sender);
                start("udp", &["--to", to], fleet).map(|program| self.sender = Some(program))
            }
            Action::StopUdpSource => return self.leave(|udp| &mut udp.source),
            Action::StopUdpSender => return self.leave(|udp| &mut udp.sender),
            _ => return None,
        };
        started.err().map(|error| format!("UDP can't be started: {error}"))
    }

    fn leave(&mut self, which: impl Fn(&mut Self) -> &mut Option<Program>) -> Option<String> {
        let mut program = which(self).take()?;
        ask_to_end(&mut program.child);
        self.leaving.push(program);
        None
    }

    /// Whether they run.
    pub fn runs(&self) -> [bool; 2] {
        [self.source.is_some(), self.sender.is_some()]
    }

    /// What to tell of those that have ended by themselves.
    pub fn ended(&mut self) -> Vec<String> {
        self.leaving.retain_mut(|program| matches!(program.child.try_wait(), Ok(None)));
        [&mut self.source, &mut self.sender].into_iter().filter_map(ended).collect()
    }
}

impl Drop for Udp {
    fn drop(&mut self) {
        self.leave(|udp| &mut udp.source);
        self.leave(|udp| &mut udp.sender);
        let patience = Instant::now() + GRACE;
        while !self.leaving.is_empty() && Instant::now() < patience {
            self.leaving.retain_mut(|program| matches!(program.child.try_wait(), Ok(None)));
            std::thread::sleep(Duration::from_millis(5));
        }
        for program in &mut self.leaving {
            // Errors mean that it has ended.
            let _ = program.child.kill();
            let _ = program.child.wait();
        }
    }
}

fn start(plugin: &str, args: &[&str], fleet: &FleetName) -> std::io::Result<Program> {
    let mut child = Command::new(std::env::current_exe()?)
        .args(["plugin", plugin])
        .args(args)
        .args(["--fleet", &fleet.to_string()])
        .env(PARENT_VARIABLE, std::process::id().to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()?;
    let said = Arc::new(Mutex::new(String::new()));
    if let Some(stderr) = child.stderr.take() {
        let last = Arc::clone(&said);
        // Ends with the child.
        std::thread::Builder::new().name(plugin.into()).spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if let Ok(mut last) = last.lock() {
                    *last = line;
                }
            }
        })?;
    }
    Ok(Program { child, said })
}

#[cfg(unix)]
fn ask_to_end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process};
    if let Some(pid) = Pid::from_raw(child.id() as i32) {
        // An error means that it has just ended by itself.
        let _ = kill_process(pid, Signal::TERM);
    }
}

/// Elsewhere there is no gentle way.
#[cfg(not(unix))]
fn ask_to_end(child: &mut Child) {
    // An error means that it has just ended by itself.
    let _ = child.kill();
}

fn ended(place: &mut Option<Program>) -> Option<String> {
    let program = place.as_mut()?;
    let status = program.child.try_wait().ok()??;
    let said = program.said.lock().map_or(String::new(), |said| said.clone());
    *place = None;
    let said = said.trim_start_matches("regatta: ");
    (!status.success()).then(|| format!("UDP: {said} ({status})"))
}
