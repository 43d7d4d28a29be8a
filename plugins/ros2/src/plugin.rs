//! The plugin: frames and worlds in, topics out.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use regatta_plugin::{Frame, Participant, Plugin, Rate, Result, World, tell};

use crate::desk::{Counter, Desk, Inputs};
use crate::diagnostics::Diagnostics;
use crate::floor;
use crate::link::{Link, LinkError, Output, tell_ports};
use crate::message::display::OccupancyGrid;
use crate::open_rmf::{States, Tasks};
use crate::options::Cli;
use crate::poses::Poses;
use crate::scene::Scene;
use crate::snapshot::Snapshot;

/// The time after which a frame is published again while no new one comes: for nodes that join a
/// paused fleet.
const AGAIN: Duration = Duration::from_secs(1);
/// Robots that have topics of their own at most: DDS announces each topic to each node.
const MOST_CHOSEN: usize = 50;

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, DDS can't open its sockets, or as [`regatta_plugin::run`] does.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| {
        let ros2 = Ros2::open(cli)?;
        ros2.cli.options.clone().run(ros2, "ros2")
    })
}

/// The plugin.
struct Ros2 {
    cli: Cli,
    link: Link,
    poses: Poses,
    scene: Scene,
    diagnostics: Diagnostics,
    open_rmf: Option<States>,
    /// Held for nodes that join later.
    _floor: Option<Output<OccupancyGrid>>,
    /// Until the desk has it.
    counter: Option<Counter>,
    desk: Option<Desk>,
    origin: [f64; 2],
    snapshot: Snapshot,
    published: Instant,
    /// Robots with topics of their own, from the first on.
    chosen: u32,
}

impl Ros2 {
    fn open(cli: Cli) -> Result<Self> {
        let floor = cli.map.as_deref().map(floor::read).transpose()?;
        let (domain, networks) = (cli.domain()?, cli.networks());
        let mut link = Link::open(domain, &networks, &cli.namespace)?;
        let can = if cli.read_only { "read" } else { "steer" };
        tell_ports(domain, link.number(), &networks, can);
        let poses = Poses::open(&mut link, &cli.namespace, &cli.frames)?;
        let scene = Scene::open(&mut link, &cli.namespace)?;
        let diagnostics = Diagnostics::open(&mut link, &cli.namespace)?;
        let tasks = cli.open_rmf.then(Tasks::default);
        let counter = Counter::open(&cli, &mut link, tasks.clone())?;
        let fleet = cli.options.fleet.to_string();
        let open_rmf = tasks.map(|tasks| States::open(&mut link, tasks, fleet)).transpose()?;
        let chosen = cli.robots.0.start;
        Ok(Self {
            cli,
            poses,
            scene,
            diagnostics,
            open_rmf,
            _floor: floor.map(|grid| floor::publish(grid, &mut link)).transpose()?,
            counter: Some(counter),
            desk: None,
            link,
            origin: [0.0; 2],
            snapshot: Snapshot::default(),
            published: Instant::now(),
            chosen,
        })
    }

    /// Gives the chosen robots that have come topics of their own.
    fn choose(&mut self, robots: usize) -> Result<(), LinkError> {
        let end = self.cli.robots.0.end.min(robots as u32);
        while self.chosen < end {
            if (self.chosen - self.cli.robots.0.start) as usize == MOST_CHOSEN {
                tell!("ros2: {MOST_CHOSEN} robots have topics of their own, which is the most");
                self.cli.robots.0.end = self.chosen;
                break;
            }
            self.poses.choose(self.chosen, &mut self.link)?;
            self.scene.choose(self.chosen);
            if let Some(desk) = self.desk.as_ref().filter(|_| !self.cli.read_only) {
                desk.add(Inputs::open(self.chosen, &mut self.link)?);
            }
            self.chosen += 1;
        }
        Ok(())
    }

    fn publish(&mut self) -> Result {
        self.poses.publish(&self.snapshot, &mut self.link)?;
        self.scene.publish(&self.snapshot)?;
        if let Some(open_rmf) = &mut self.open_rmf {
            open_rmf.publish(&self.snapshot)?;
        }
        self.published = Instant::now();
        Ok(())
    }
}

impl Plugin for Ros2 {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.scene.join(fleet)?;
        if let Some(open_rmf) = &mut self.open_rmf {
            open_rmf.join(fleet)?;
        }
        if let Some(counter) = self.counter.take() {
            self.desk = Some(Desk::start(fleet.fleet().clone(), counter)?);
        }
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.origin = world.origin();
        self.poses.take_world(world);
        if let Some(open_rmf) = &mut self.open_rmf {
            open_rmf.take_world(world);
        }
        Ok(self.scene.take_world(world, &mut self.link)?)
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.choose(frame.len())?;
        self.snapshot = Snapshot::of(frame, self.origin);
        self.diagnostics.publish(frame, &self.link);
        self.publish()
    }

    fn on_idle(&mut self, _: bool) -> Result {
        if self.published.elapsed() >= AGAIN && !self.snapshot.robots.is_empty() {
            self.publish()?;
        }
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        if let Some(desk) = &mut self.desk {
            desk.stop();
        }
        Ok(())
    }

    fn rate(&self) -> Rate {
        Rate::PerSecond(10.0)
    }
}
