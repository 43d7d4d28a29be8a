//! The desk: takes what other nodes want of the fleet, and answers.
//!
//! It has a thread of its own, as it waits for the engine and the fleet manager. It also publishes
//! `/clock`, with each tick.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use regatta_plugin::{Control, FleetName, Participant, Result, Subscriber, WorldReader, tell};
use ros2_client::Subscription;

use crate::link::{Keep, Link, LinkError, Logger, Output, taken};
use crate::map::Map;
use crate::message::geometry::{Clock, Float64, PoseStamped};
use crate::navigation::Navigation;
use crate::open_rmf::{Requests, Tasks};
use crate::options::{Cli, robot_name};
use crate::simulation::Simulation;
use crate::snapshot::Snapshot;
use crate::steering::Steering;

/// The longest time between two looks for requests.
const CYCLE: Duration = Duration::from_millis(10);
/// The shortest time between two messages of `/clock`: a fast run has thousands of ticks a second.
const CLOCK_EVERY: Duration = Duration::from_millis(4);
/// Bytes of a `/clock` message, about.
const CLOCK_BYTES: usize = 16;

/// The fleet, as a request sees it.
pub(crate) struct Fleet<'desk> {
    pub map: &'desk Map,
    pub snapshot: &'desk Snapshot,
    pub steering: &'desk mut Steering,
}

/// The subscriptions and the action server of a robot.
pub(crate) struct Inputs {
    robot: u32,
    goals: Subscription<PoseStamped>,
    navigation: Navigation,
}

impl Inputs {
    pub fn open(robot: u32, link: &mut Link) -> std::result::Result<Self, LinkError> {
        let name = robot_name(robot);
        Ok(Self {
            robot,
            goals: link.input(&format!("{name}/goal_pose"))?,
            navigation: Navigation::open(robot, link)?,
        })
    }
}

/// The handle of the desk's thread.
pub(crate) struct Desk {
    inputs: Sender<Inputs>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// The topics and services of the whole fleet.
pub(crate) struct Counter {
    clock: Output<Clock>,
    logger: Logger,
    requests: Option<FleetRequests>,
}

/// The subscriptions and services of the whole fleet.
struct FleetRequests {
    speed: Subscription<Float64>,
    simulation: Simulation,
    open_rmf: Option<Requests>,
}

impl Counter {
    /// Opens the topics and services; `tasks` are those of Open-RMF, if it takes part.
    pub fn open(
        cli: &Cli,
        link: &mut Link,
        tasks: Option<Tasks>,
    ) -> std::result::Result<Self, LinkError> {
        let clock = link.output("/clock", Keep::Nothing, CLOCK_BYTES)?;
        let logger = link.logger()?;
        if cli.read_only {
            return Ok(Self { clock, logger, requests: None });
        }
        let requests = FleetRequests {
            speed: link.input("speed")?,
            simulation: Simulation::open(link)?,
            open_rmf: tasks
                .map(|tasks| Requests::open(link, tasks, cli.options.fleet.to_string()))
                .transpose()?,
        };
        Ok(Self { clock, logger, requests: Some(requests) })
    }
}

impl Desk {
    /// Starts the thread.
    pub fn start(fleet: FleetName, counter: Counter) -> Result<Self> {
        let (inputs, taken) = channel();
        let is_over = Arc::new(AtomicBool::new(false));
        let is_over_too = Arc::clone(&is_over);
        let thread = std::thread::Builder::new().name("desk".to_owned()).spawn(move || {
            let outcome = Attendant::join(&fleet, counter)
                .and_then(|attendant| attendant.serve(&taken, &is_over_too));
            if let Err(error) = outcome {
                tell!("ros2: requests are no longer accepted: {error}");
            }
        })?;
        Ok(Self { inputs, is_over, thread: Some(thread) })
    }

    /// Takes goals of one more robot.
    pub fn add(&self, inputs: Inputs) {
        // Without a thread, which has told why, nobody takes them.
        let _ = self.inputs.send(inputs);
    }

    /// Ends the thread.
    pub fn stop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // Its panic has been printed.
            let _ = thread.join();
        }
    }
}

/// The state of the desk's thread.
struct Attendant {
    clock: Output<Clock>,
    /// The last message of `/clock`: when it was published, and its time.
    clock_published: (Instant, Option<Duration>),
    requests: Option<FleetRequests>,
    robots: Vec<Inputs>,
    frames: Subscriber,
    worlds: WorldReader,
    control: Control,
    map: Map,
    snapshot: Snapshot,
    steering: Steering,
}

impl Attendant {
    fn join(fleet: &FleetName, counter: Counter) -> Result<Self> {
        let participant = Participant::join(fleet, "ros2-desk")?;
        Ok(Self {
            clock: counter.clock,
            clock_published: (Instant::now(), None),
            requests: counter.requests,
            robots: Vec::new(),
            frames: Subscriber::open_on(&participant)?,
            worlds: WorldReader::open_on(&participant)?,
            control: Control::open_on(&participant)?,
            map: Map::default(),
            snapshot: Snapshot::default(),
            steering: Steering::join(fleet, counter.logger)?,
        })
    }

    fn serve(mut self, inputs: &Receiver<Inputs>, is_over: &AtomicBool) -> Result {
        while !is_over.load(Ordering::Relaxed) {
            self.robots.extend(inputs.try_iter());
            self.look()?;
            self.take_answers()?;
            self.take_goals();
            self.serve_requests();
        }
        Ok(())
    }

    fn serve_requests(&mut self) {
        let Self { map, snapshot, steering, robots, requests, control, .. } = self;
        let mut fleet = Fleet { map, snapshot, steering };
        for robot in robots {
            robot.navigation.serve(&mut fleet);
        }
        if let Some(requests) = requests {
            requests.serve(control, &mut fleet);
        }
    }

    /// Waits for the next frame, and publishes its time.
    fn look(&mut self) -> Result {
        if let Some(world) = self.worlds.latest()? {
            self.map = Map::of(&world);
        }
        if let Some(frame) = self.frames.wait(CYCLE)? {
            self.snapshot = Snapshot::of(&frame, self.map.origin());
        }
        let (published, time) = self.clock_published;
        if time != Some(self.snapshot.sim_time) && published.elapsed() >= CLOCK_EVERY {
            self.clock_published = (Instant::now(), Some(self.snapshot.sim_time));
            self.clock.publish(Clock { clock: self.snapshot.stamp() });
        }
        Ok(())
    }

    /// Takes what the engine says to commands.
    fn take_answers(&mut self) -> Result {
        for answer in self.steering.answers()? {
            let refusal = self.steering.note(&answer);
            if let Some(requests) = &mut self.requests
                && requests.simulation.note(&answer, refusal.as_ref())
            {
                continue;
            }
            let Some(refusal) = refusal else { continue };
            self.steering.log_refusal("command", refusal.robot, &refusal.reason);
            for robot in &mut self.robots {
                robot.navigation.refuse(&refusal);
            }
        }
        Ok(())
    }

    fn take_goals(&mut self) {
        for inputs in &self.robots {
            // Those before the last one are outdated.
            let Some(goal) = taken(&inputs.goals).pop() else { continue };
            let sent = match self.map.goal(&goal) {
                Ok(place) => {
                    let sent = self.steering.send(inputs.robot, place.node);
                    sent.map_err(|error| error.to_string())
                }
                Err(error) => Err(error.to_string()),
            };
            if let Err(reason) = sent {
                self.steering.log_refusal("goal", inputs.robot, &reason);
            }
        }
    }
}

impl FleetRequests {
    fn serve(&mut self, control: &mut Control, fleet: &mut Fleet<'_>) {
        for Float64 { data: speed } in taken(&self.speed) {
            if let Err(error) = control.speed(speed as f32) {
                fleet.steering.log("speed", &error.to_string());
            }
        }
        self.simulation.serve(control, fleet);
        if let Some(open_rmf) = &mut self.open_rmf {
            open_rmf.serve(fleet);
        }
    }
}
