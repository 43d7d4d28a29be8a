//! Whose routes lead over which edge. A thread asks for the routes of all robots under way, some at
//! a time, round after round, so that no frame waits for it.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{FleetName, Frame, Participant, Result, RouteClient, Subscriber, WorldReader};

/// The most robots whose routes are asked for in a round: an answer takes a kilobyte, and the
/// engine answers eight per tick. Of more robots, a sample is asked for, and each of it counts for
/// several.
const MAX_SAMPLE: usize = 16_384;
/// The number of routes that are asked for at once.
const AT_ONCE: usize = 8;
/// How long an answer is awaited.
const TIMEOUT: Duration = Duration::from_millis(200);
/// The time between the ends of two rounds, at least.
const ROUND_EVERY: Duration = Duration::from_secs(1);

/// What a round has found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reservations {
    /// The run.
    pub run_id: u64,
    /// By edge: the robots whose released route leads over it, and the others whose planned one
    /// does. Of fleets with more than 16,384 robots under way, these are estimates.
    pub edges: Vec<[u32; 2]>,
}

impl Reservations {
    /// Counts a robot, which stands for `weight` robots, once on each edge of its route. Edges that
    /// the world doesn't have are left out.
    fn count(&mut self, route: &RouteResponse, weight: u32) {
        let mut legs: Vec<(u32, bool)> =
            route.legs().map(|leg| (leg.edge, !leg.released)).collect();
        // Of an edge that the route leads over twice, the released time comes first.
        legs.sort_unstable();
        legs.dedup_by_key(|(edge, _)| *edge);
        for (edge, is_planned) in legs {
            if let Some(counts) = self.edges.get_mut(edge as usize) {
                counts[usize::from(is_planned)] += weight;
            }
        }
    }
}

/// The thread that asks. It ends when this is dropped.
#[derive(Debug)]
pub struct RouteWatch {
    /// Each round, or `None` if there are no answers any more.
    rounds: Receiver<Option<Reservations>>,
    newest: Option<Reservations>,
    stop: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RouteWatch {
    /// Starts to ask. If the thread can't be started, or the fleet can't be joined, there are no
    /// reservations, which is told.
    pub fn start(fleet: &FleetName) -> Self {
        let (stop, stopped) = mpsc::sync_channel(1);
        let (found, rounds) = mpsc::channel();
        let fleet = fleet.clone();
        let thread = std::thread::Builder::new().name("routes".into()).spawn(move || {
            if let Err(error) = run(&fleet, &found, &stopped) {
                regatta_plugin::tell!("traffic: routes aren't known: {error}");
            }
        });
        let thread = thread
            .inspect_err(|error| regatta_plugin::tell!("traffic: routes aren't known: {error}"))
            .ok();
        Self { rounds, newest: None, stop: Some(stop), thread }
    }

    /// The newest round through a run, if there is one.
    pub fn newest(&mut self, run_id: u64) -> Option<&Reservations> {
        if let Some(newest) = self.rounds.try_iter().last() {
            self.newest = newest;
        }
        self.newest.as_ref().filter(|found| found.run_id == run_id)
    }
}

impl Drop for RouteWatch {
    fn drop(&mut self) {
        self.stop = None;
        self.thread.take().into_iter().for_each(|thread| _ = thread.join());
    }
}

fn run(fleet: &FleetName, found: &Sender<Option<Reservations>>, stopped: &Receiver<()>) -> Result {
    let participant = Participant::join(fleet, "traffic-routes")?;
    let (mut frames, mut worlds) =
        (Subscriber::open_on(&participant)?, WorldReader::open_on(&participant)?);
    let mut client = RouteClient::open_on(&participant)?;
    loop {
        let start = Instant::now();
        frames.latest()?;
        worlds.latest()?;
        if let (Some(frame), Some(world)) = (frames.current()?, worlds.current()?) {
            let newest = match client.has_routes() {
                true => round(&mut client, &frame, world.edges().len(), stopped),
                false => None,
            };
            // Whoever doesn't take it any more has ended.
            let _ = found.send(newest);
        }
        match stopped.recv_timeout(ROUND_EVERY.saturating_sub(start.elapsed())) {
            Err(RecvTimeoutError::Timeout) => {}
            Ok(()) | Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

/// Asks for the routes of the robots that are under way in a frame, or of a sample of them. `None`
/// if there are no answers now, or the plugin ends.
fn round(
    client: &mut RouteClient,
    frame: &Frame<'_>,
    edges: usize,
    stopped: &Receiver<()>,
) -> Option<Reservations> {
    let mut found = Reservations { run_id: frame.run_id(), edges: vec![[0; 2]; edges] };
    let is_under_way = |robot: &u32| {
        !matches!(frame.state_of(*robot as usize), RobotState::Absent | RobotState::Idle)
    };
    let mut robots: Vec<u32> = (0..frame.len() as u32).filter(is_under_way).collect();
    let weight = thin_out(&mut robots, MAX_SAMPLE);
    for batch in robots.chunks(AT_ONCE) {
        if !matches!(stopped.try_recv(), Err(mpsc::TryRecvError::Empty)) {
            return None;
        }
        let answers = client.routes(batch, TIMEOUT).ok()?;
        let run_id = found.run_id;
        let current = answers.iter().filter(|route| route.is_found() && route.run_id == run_id);
        current.for_each(|route| found.count(route, weight));
    }
    Some(found)
}

/// Leaves every n-th robot, so that at most `max` are left, and returns n. Robots of one type, or
/// of one place at the start, have numbers in a row, so each of these groups keeps its share.
fn thin_out(robots: &mut Vec<u32>, max: usize) -> u32 {
    let step = robots.len().div_ceil(max).max(1);
    let mut place = 0..;
    robots.retain(|_| place.next().is_some_and(|place: usize| place.is_multiple_of(step)));
    step as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_counts_once_on_each_edge_and_as_released_if_it_may_drive_there_now() {
        let mut found = Reservations { run_id: 1, edges: vec![[0; 2]; 4] };
        let route = |released, edges: &[u32]| {
            RouteResponse::default().with_legs(
                released,
                edges.len(),
                edges.iter().map(|edge| (*edge, false)),
            )
        };
        found.count(&route(2, &[0, 1, 2, 0, 2]), 1);
        found.count(&route(1, &[2, 3, 77]), 3);
        found.count(&RouteResponse::unknown(1, 1, 5), 1);
        assert_eq!(found.edges, [[1, 0], [1, 0], [3, 1], [0, 3]]);
    }

    #[test]
    fn a_sample_of_a_large_fleet_is_spread_evenly_and_stands_for_all() {
        for (len, max) in [(0, 4), (1, 4), (4, 4), (5, 4), (9, 4), (1000, 7)] {
            let mut robots: Vec<u32> = (0..len).collect();
            let weight = thin_out(&mut robots, max);
            assert!(robots.len() <= max, "{} of {len}", robots.len());
            assert!(robots.iter().copied().eq((0..len).step_by(weight as usize)));
            assert!((robots.len() as u32 * weight).abs_diff(len) < weight);
        }
    }
}
