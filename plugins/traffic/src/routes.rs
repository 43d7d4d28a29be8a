//! The routes that lead over each edge. A thread asks for the routes of all robots under way, some
//! at a time, round after round, so that no frame waits for it.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{FleetName, Frame, Participant, Result, RouteClient, Subscriber, WorldReader};

/// The largest number of robots whose routes are requested in a round: an answer takes a kilobyte,
/// and the engine answers eight per tick. Of more robots, each of a sample counts for several.
const MAX_SAMPLE: usize = 16_384;
/// The number of concurrent requests.
const AT_ONCE: usize = 8;
/// The longest wait for an answer.
const TIMEOUT: Duration = Duration::from_millis(200);
/// The least time between the ends of two rounds.
const ROUND_EVERY: Duration = Duration::from_secs(1);

/// The robots whose routes lead over an edge. In fleets with more than 16,384 robots under way,
/// these are estimates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeRoutes {
    /// Robots whose released route leads over it.
    pub released: u32,
    /// Others whose planned route does.
    pub planned: u32,
}

/// The result of a round.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reservations {
    /// The run.
    pub run_id: u64,
    /// By edge.
    pub edges: Vec<EdgeRoutes>,
}

impl Reservations {
    /// Counts a robot, which represents `weight` robots, once on each edge of its route. Edges that
    /// the world doesn't have are left out.
    fn count(&mut self, route: &RouteResponse, weight: u32) {
        let mut legs: Vec<(u32, bool)> =
            route.legs().map(|leg| (leg.edge, !leg.released)).collect();
        // If the route leads over an edge twice, the released leg comes first.
        legs.sort_unstable();
        legs.dedup_by_key(|(edge, _)| *edge);
        for (edge, is_planned) in legs {
            if let Some(counts) = self.edges.get_mut(edge as usize) {
                *(if is_planned { &mut counts.planned } else { &mut counts.released }) += weight;
            }
        }
    }
}

/// The handle of the thread that asks. The thread ends when this is dropped.
#[derive(Debug)]
pub struct RouteWatch {
    /// The result of each round; `None` without answers.
    rounds: Receiver<Option<Reservations>>,
    newest: Option<Reservations>,
    stop: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RouteWatch {
    /// Starts the thread. If it can't be started, or the fleet can't be joined, it prints the
    /// error, and there are no reservations.
    pub fn start(fleet: &FleetName) -> Self {
        let (stop, stopped) = mpsc::sync_channel(1);
        let (found, rounds) = mpsc::channel();
        let fleet = fleet.clone();
        let thread = std::thread::Builder::new()
            .name("routes".into())
            .spawn(move || _ = run(&fleet, &found, &stopped).inspect_err(report))
            .inspect_err(report)
            .ok();
        Self { rounds, newest: None, stop: Some(stop), thread }
    }

    /// Returns the result of the newest round, if it belongs to this run.
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
        if let Some(thread) = self.thread.take() {
            // The panic of a thread has already been printed.
            let _ = thread.join();
        }
    }
}

fn report(error: &impl std::fmt::Display) {
    regatta_plugin::tell!("traffic: the routes of robots are unknown: {error}");
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
            let newest = if client.has_routes() {
                round(&mut client, &frame, world.edges().len(), stopped)
            } else {
                None
            };
            // It fails only if the plugin has ended.
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
    let mut found =
        Reservations { run_id: frame.run_id(), edges: vec![EdgeRoutes::default(); edges] };
    let mut robots: Vec<u32> = (0..frame.len() as u32)
        .filter(|robot| {
            !matches!(frame.state_of(*robot as usize), RobotState::Absent | RobotState::Idle)
        })
        .collect();
    let weight = thin_out(&mut robots, MAX_SAMPLE);
    for batch in robots.chunks(AT_ONCE) {
        if !matches!(stopped.try_recv(), Err(mpsc::TryRecvError::Empty)) {
            return None;
        }
        for route in &client.routes(batch, TIMEOUT).ok()? {
            if route.is_found() && route.run_id == found.run_id {
                found.count(route, weight);
            }
        }
    }
    Some(found)
}

/// Keeps every n-th robot, so that at most `max` remain. Returns n. Robots of one type, or of one
/// start, have consecutive ids, so each of these groups keeps its share.
fn thin_out(robots: &mut Vec<u32>, max: usize) -> u32 {
    let step = robots.len().div_ceil(max).max(1);
    *robots = robots.iter().copied().step_by(step).collect();
    step as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_counts_once_on_each_edge_and_as_released_if_it_may_drive_there_now() {
        let mut found = Reservations { run_id: 1, edges: vec![EdgeRoutes::default(); 4] };
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
        let counts: Vec<_> =
            found.edges.iter().map(|routes| (routes.released, routes.planned)).collect();
        assert_eq!(counts, [(1, 0), (1, 0), (3, 1), (0, 3)]);
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
