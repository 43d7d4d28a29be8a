//! A whole run in one process: the engine and its plugins call each other in turn, without shared
//! memory, wake-ups or threads between them.
//!
//! A run of processes in lockstep and a run in one process have the same frames, events, columns,
//! commands and orders, bit for bit. Plugins are the same: they see a
//! [`Participant`](regatta_plugin::Participant), ports and frames, and can't tell the difference.
//!
//! ```
//! use std::path::Path;
//! use std::time::Duration;
//!
//! use regatta_plugin::{Frame, Plugin, Result};
//! use regatta_run::Run;
//! use regatta_scenario::{Overrides, Scenario};
//!
//! /// The longest way that a robot drove in a tick, in metres.
//! #[derive(Default)]
//! struct Fastest(f32);
//!
//! impl Plugin for Fastest {
//!     fn on_frame(&mut self, frame: &Frame) -> Result {
//!         self.0 = frame.speed().iter().copied().fold(self.0, f32::max);
//!         Ok(())
//!     }
//! }
//!
//! # fn main() -> Result {
//! # let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs/thirty.yaml"));
//! let scenario = Scenario::read(path, &Overrides::default())?;
//! let mut fastest = Fastest::default();
//! let summary = Run::new(scenario).with(&mut fastest).for_simulated(Duration::from_secs(60))?;
//! assert_eq!(summary.sim_time, Duration::from_secs(60));
//! assert!(fastest.0 > 0.5);
//! # Ok(())
//! # }
//! ```

use std::time::Duration;

pub use regatta_engine::engine::Summary;
use regatta_engine::engine::{Engine, EngineError, Options};
use regatta_plugin::{Error, FleetName, LocalFleet, LocalPlugin, OpenError, Plugin};
use regatta_scenario::Scenario;

/// The error that ends a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The engine has failed.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A plugin has failed.
    #[error("{name}: {error}")]
    Plugin {
        /// The name of the plugin.
        name: String,
        /// Its error.
        error: Error,
    },
    /// The fleet can't be published.
    #[error(transparent)]
    Publish(#[from] OpenError),
    /// Two plugins have the same name.
    #[error("two plugins of a run are called '{0}'; give one of them another name")]
    SameName(String),
    /// Plugins come after each other in a circle.
    #[error("these plugins come after each other in a circle: {}", .0.join(", "))]
    Circle(Vec<String>),
    /// The run has come to its end, and a plugin has failed then: it has findings, for example.
    #[error("{name}: {error}")]
    AtEnd {
        /// The figures of the run.
        summary: Summary,
        /// The name of the plugin.
        name: String,
        /// Its error.
        error: Error,
    },
    /// The run was [stopped](Run::stopped_by).
    #[error("the run was stopped after {} ticks", .0.ticks)]
    Stopped(Summary),
}

/// A run that is about to begin: a scenario, and the plugins that take part.
pub struct Run<'a> {
    scenario: Scenario,
    options: Options,
    members: Vec<Member<'a>>,
    is_published: bool,
    is_stopped: Box<dyn Fn() -> bool + 'a>,
}

/// A plugin of a run.
struct Member<'a> {
    name: String,
    /// The plugins that it comes after, besides those that it names itself.
    after: Vec<String>,
    plugin: Box<dyn Plugin + 'a>,
}

impl<'a> Run<'a> {
    /// Creates a run of a scenario. Its own list of plugins isn't started: those are programs.
    pub fn new(scenario: Scenario) -> Self {
        Self {
            scenario,
            options: Options::default(),
            members: Vec::new(),
            is_published: false,
            is_stopped: Box::new(|| false),
        }
    }

    /// Adds a plugin. Its name is that of its type, in small letters. To read its results after
    /// the run, pass a mutable reference.
    ///
    /// After each frame plugins are called in the order in which they were added, except that a
    /// plugin that [comes after](Plugin::after) others is called after them.
    #[must_use]
    pub fn with<P: Plugin + 'a>(self, plugin: P) -> Self {
        let path = core::any::type_name::<P>();
        let path = path.split('<').next().unwrap_or(path);
        let name = path.rsplit("::").next().unwrap_or(path).trim_start_matches("&mut ");
        self.with_named(&name.to_lowercase(), &[], plugin)
    }

    /// Adds a plugin under a name, by which others come after it. It comes after the plugins with
    /// the names `after`. The tokens of a plugin's commands depend on its name.
    #[must_use]
    pub fn with_named(mut self, name: &str, after: &[&str], plugin: impl Plugin + 'a) -> Self {
        self.members.push(Member {
            name: name.to_owned(),
            after: after.iter().map(|&name| name.to_owned()).collect(),
            plugin: Box::new(plugin),
        });
        self
    }

    /// Sets the number of robots, instead of the scenario's.
    #[must_use]
    pub fn robots(mut self, robots: u32) -> Self {
        self.options.robots = Some(robots);
        self
    }

    /// Computes a digest of all frames, for the [`Summary`].
    #[must_use]
    pub fn digested(mut self) -> Self {
        self.options.digest = true;
        self
    }

    /// Publishes the run in shared memory as the fleet of a name, so that other processes can watch
    /// it: a viewer, for example. The run doesn't wait for them.
    #[must_use]
    pub fn published(mut self, fleet: FleetName) -> Self {
        self.options.fleet = fleet;
        self.is_published = true;
        self
    }

    /// Stops the run as soon as `is_stopped` returns `true`. It is asked after each tick.
    #[must_use]
    pub fn stopped_by(mut self, is_stopped: impl Fn() -> bool + 'a) -> Self {
        self.is_stopped = Box::new(is_stopped);
        self
    }

    /// Runs for a simulated time, rounded up to whole ticks, as fast as possible.
    ///
    /// # Errors
    /// [`RunError`]. Plugins are [stopped](Plugin::on_stop) in any case.
    pub fn for_simulated(self, duration: Duration) -> Result<Summary, RunError> {
        let period_nanos = self.scenario.tick_period.as_nanos().max(1);
        let ticks = duration.as_nanos().div_ceil(period_nanos);
        self.for_ticks(u64::try_from(ticks).unwrap_or(u64::MAX))
    }

    /// Runs for a number of ticks, as fast as possible.
    ///
    /// # Errors
    /// [`RunError`]. Plugins are [stopped](Plugin::on_stop) in any case.
    pub fn for_ticks(mut self, ticks: u64) -> Result<Summary, RunError> {
        self.options.ticks = Some(ticks);
        let order = order(&self.members)?;
        let fleet = self.fleet()?;
        let mut engine = Engine::driven(self.scenario, &self.options, &fleet)?;
        let mut members: Vec<_> = self.members.into_iter().map(Some).collect();
        let mut plugins = Vec::new();
        for Member { name, plugin, .. } in order.into_iter().filter_map(|at| members[at].take()) {
            match LocalPlugin::start(&fleet.join(&name), plugin) {
                Ok(plugin) => plugins.push(Running { name, plugin }),
                Err(error) => return Err(RunError::Plugin { name, error }),
            }
        }
        let outcome = drive(&mut engine, &mut plugins, &*self.is_stopped);
        let failure = stop(plugins);
        let summary = outcome?;
        match failure {
            None => Ok(summary),
            Some((name, error)) => Err(RunError::AtEnd { summary, name, error }),
        }
    }

    fn fleet(&self) -> Result<LocalFleet, OpenError> {
        #[cfg(feature = "shared-memory")]
        if self.is_published {
            return LocalFleet::published(self.options.fleet.clone());
        }
        Ok(LocalFleet::new(self.options.fleet.clone()))
    }
}

/// A plugin at work.
struct Running<'a> {
    name: String,
    plugin: LocalPlugin<Box<dyn Plugin + 'a>>,
}

/// Runs the engine to its end, and the plugins after each of its frames.
fn drive(
    engine: &mut Engine,
    plugins: &mut [Running<'_>],
    is_stopped: &dyn Fn() -> bool,
) -> Result<Summary, RunError> {
    engine.begin()?;
    turn(plugins)?;
    while engine.advance()? {
        turn(plugins)?;
        if is_stopped() {
            return Err(RunError::Stopped(engine.end()?));
        }
    }
    Ok(engine.end()?)
}

fn turn(plugins: &mut [Running<'_>]) -> Result<(), RunError> {
    for Running { name, plugin } in plugins {
        plugin.turn().map_err(|error| RunError::Plugin { name: name.clone(), error })?;
    }
    Ok(())
}

/// Stops all plugins, and returns the first error with the name of its plugin.
fn stop(plugins: Vec<Running<'_>>) -> Option<(String, Error)> {
    let mut first = None;
    for Running { name, plugin } in plugins {
        if let Err(error) = plugin.stop() {
            first.get_or_insert((name, error));
        }
    }
    first
}

/// Returns the order in which plugins are called after a frame, as indices.
fn order(members: &[Member<'_>]) -> Result<Vec<usize>, RunError> {
    for (index, member) in members.iter().enumerate() {
        if members[..index].iter().any(|other| other.name == member.name) {
            return Err(RunError::SameName(member.name.clone()));
        }
    }
    let mut order: Vec<usize> = Vec::with_capacity(members.len());
    let mut left: Vec<usize> = (0..members.len()).collect();
    while !left.is_empty() {
        let next = left.iter().position(|&at| {
            let Member { after, plugin, .. } = &members[at];
            let mut waits_for = after.iter().cloned().chain(plugin.after());
            !waits_for.any(|name| left.iter().any(|&other| members[other].name == name))
        });
        let Some(next) = next else {
            let names = left.iter().map(|&at| members[at].name.clone());
            return Err(RunError::Circle(names.collect()));
        };
        order.push(left.remove(next));
    }
    Ok(order)
}
