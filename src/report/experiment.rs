//! One engine process with a reader attached: what every report measures.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::RobotState;
use regatta_plugin::{Control, FleetName, Frame, Subscriber};

use crate::Failure;
use crate::supervisor::Supervisor;

const START_PATIENCE: Duration = Duration::from_secs(60);

/// An engine process, its control and its reader.
pub struct Experiment {
    supervisor: Supervisor,
    pub control: Control,
    pub reader: Subscriber,
}

impl Experiment {
    /// Starts `regatta engine SCENARIO ARGS` under a fleet name of its own and waits until it can be read.
    pub fn start(name: &str, scenario: &Path, args: &[String]) -> Result<Self, Failure> {
        let fleet: FleetName = format!("report-{name}-{}", std::process::id()).parse()?;
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("engine").arg(scenario).args(["--fleet", &fleet.to_string()]).args(args);
        let mut supervisor = Supervisor::default();
        supervisor.start("engine", command.stderr(Stdio::null()))?;
        let (control, reader) = (Control::open(&fleet)?, Subscriber::open(&fleet)?);
        let started = Instant::now();
        loop {
            if control.has_engine() && reader.has_producer() {
                return Ok(Self { supervisor, control, reader });
            }
            if !supervisor.ended().is_empty() || started.elapsed() > START_PATIENCE {
                return Err(format!("the engine of experiment '{name}' did not start; run `regatta doctor`").into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn status(&mut self) -> Result<ControlResponse, Failure> {
        Ok(self.control.status()?)
    }

    /// Hands each frame to `watch`, woken as they come, until it says that it has seen enough.
    pub fn watch(&mut self, patience: Duration, mut watch: impl FnMut(&Frame<'_>) -> bool) -> Result<(), Failure> {
        let started = Instant::now();
        while started.elapsed() < patience {
            if let Some(frame) = self.reader.wait(Duration::from_millis(200))?
                && watch(&frame)
            {
                return Ok(());
            }
            if let Some(ended) = self.supervisor.ended().first() {
                return Err(ended.failure().unwrap_or_else(|| "the engine ended early".into()).into());
            }
        }
        Err(format!("the experiment did not end within {} s", patience.as_secs()).into())
    }

    /// Ends the engine, which must end well.
    pub fn finish(mut self) -> Result<(), Failure> {
        match self.supervisor.stop().into_iter().next() {
            Some(failure) => Err(failure.into()),
            None => Ok(()),
        }
    }
}

/// Whether every robot has come to the end of its route.
pub fn all_idle(frame: &Frame<'_>) -> bool {
    frame.state().iter().all(|&state| state == RobotState::Idle as u8)
}

/// Folder for an experiment's scenarios, with the graph beside them; removed when dropped.
pub fn folder_with_porto() -> Result<tempfile::TempDir, Failure> {
    let folder = tempfile::tempdir().map_err(|error| format!("can't make a temporary folder: {error}"))?;
    super::write(&folder.path().join("porto.yaml"), include_str!("../../graphs/porto.yaml"))?;
    Ok(folder)
}
