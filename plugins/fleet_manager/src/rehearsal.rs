//! A rehearsal: a manager steers a model of its fleet for some minutes, to see how much the robots
//! carry under a planner.
//!
//! Robots of the model start where those of the fleet stand, and get orders of the same load. They
//! drive at the speeds of edges and types, and brake and turn at once. A rehearsal is a function
//! of the roads, the load and the robots alone, so that runs in lockstep stay equal.

mod body;

use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::vec2;
use regatta_orders::OrderPool;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};
use regatta_plugin::tell;

use self::body::{Body, Pose};
use crate::manager::Manager;
use crate::planner::{Candidate, PlannerKind, Rate};
use crate::roads::{Leg, Roads};
use crate::steering::Settings;
use crate::traffic::BaseEnds;

/// Simulated seconds of a cycle.
const CYCLE_SECS: f64 = 0.2;
/// The number of rehearsals with each planner, with orders of their own: some jams are rare.
const REHEARSALS: usize = 3;
/// The longest rehearsal, and the shortest that tells planners apart, in simulated seconds.
const MOST_SECS: f64 = 750.0;
const LEAST_SECS: f64 = 60.0;
/// The cycles of all rehearsals with a planner times the robots: half a second of work at most.
const MOST_ROBOT_CYCLES: f64 = 80e3;
/// The same for committed ways, whose searches look at all nodes: cycles times robots times nodes,
/// and a few seconds of work on dense plants, where these ways carry the most.
const MOST_COMMITTED_WORK: f64 = 12e6;
/// The simulated seconds for which a robot may stand with an order, away from its stop, until it
/// counts as stalled.
const STALL_SECS: f64 = 200.0;
/// The weight of a rehearsal in which robots stalled.
const STALLED_WEIGHT: f32 = 0.25;
/// The part of the best score from which on the first planner, which jams the least, is as good as
/// the best.
const AS_GOOD: f32 = 0.92;
/// The standard deviations by which the best score has to be above that of a planner without
/// stalls: counts of some stops vary by about their square root.
const LEAST_DEVIATIONS: f32 = 2.0;
/// The part of the best score so far below which a planner isn't rehearsed any more.
const HOPELESS: f32 = 0.6;

/// The time after which the user is told that the robots stand for rehearsals.
const TELL_AFTER: Duration = Duration::from_millis(1500);

/// A fleet before its first cycle, to rehearse with.
pub struct Rehearsal<'a> {
    roads: &'a Arc<Roads>,
    /// Makes the orders of each rehearsal.
    orders: &'a dyn Fn(u64) -> OrderPool,
    /// By robot; `None` if it is absent, or at no road.
    bodies: Vec<Option<Body>>,
    robot_types: &'a [f32],
    /// The time at which rehearsals begin, in simulated seconds: orders come from then on.
    begin_secs: f64,
    /// The places where bases may end.
    ends: BaseEnds,
    /// Tells the user of rehearsals that take long.
    notice: Option<Notice>,
}

/// A message for the user about rehearsals that take long.
struct Notice {
    since: Instant,
    is_told: Cell<bool>,
}

impl<'a> Rehearsal<'a> {
    /// Takes the places of robots from a frame. `robot_types` has an index for each robot, or is
    /// empty if all are of the first type.
    pub fn new(
        roads: &'a Arc<Roads>,
        orders: &'a dyn Fn(u64) -> OrderPool,
        columns: &Columns<'_>,
        robot_types: &'a [f32],
    ) -> Self {
        let bodies = (0..columns.state.len()).map(|robot| {
            let class = robot_types.get(robot).map_or(0, |index| *index as usize);
            let class = *roads.classes().get(class)?;
            if columns.state[robot] == RobotState::Absent as u8 {
                return None;
            }
            let edge = columns.edge[robot];
            if edge == NO_EDGE {
                let position = vec2(columns.x[robot], columns.y[robot]);
                return Body::on_node(roads.nearest_node(position)?, roads, class);
            }
            let place = columns.s[robot].clamp(0.0, roads.edge(edge).length);
            Some(Body::on_leg(Leg::new(edge, false), place, class))
        });
        Self {
            roads,
            orders,
            bodies: bodies.collect(),
            robot_types,
            begin_secs: 0.0,
            ends: BaseEnds::default(),
            notice: None,
        }
    }

    /// Tells the user if the rehearsals take long: the robots stand until then.
    #[must_use]
    pub fn telling(self) -> Self {
        Self { notice: Some(Notice { since: Instant::now(), is_told: Cell::new(false) }), ..self }
    }

    /// Lets bases end at these places.
    #[must_use]
    pub fn with_ends(self, ends: BaseEnds) -> Self {
        Self { ends, ..self }
    }

    /// Begins rehearsals at a simulated time in seconds, instead of 0.
    #[must_use]
    pub fn beginning_at(self, begin_secs: f64) -> Self {
        Self { begin_secs, ..self }
    }

    /// Sorts planners by what the robots carry under them, the best first, and tells their rates.
    /// The first one stays first if it is about as good as the best. Planners that would take too
    /// long to rehearse come last, committed ways behind the others.
    pub fn sort(&self, candidates: &mut [Candidate]) {
        candidates.sort_by_key(|Candidate { kind, .. }| {
            let is_costly = self.affordable_secs(*kind) < LEAST_SECS;
            (is_costly, is_costly && *kind == PlannerKind::Committed)
        });
        let kinds = candidates.iter().map(|candidate| candidate.kind);
        let affordable = kinds.map(|kind| self.affordable_secs(kind));
        let affordable: Vec<f64> = affordable.take_while(|secs| *secs >= LEAST_SECS).collect();
        let secs = affordable.iter().copied().fold(MOST_SECS, f64::min);
        let candidates = &mut candidates[..affordable.len()];
        let scores = candidates.iter().map(|candidate| Score::of(candidate.kind));
        let scores = self.ranked(scores.collect(), secs);
        for (candidate, score) in candidates.iter_mut().zip(scores) {
            *candidate = Candidate { kind: score.kind, rate: score.rate(secs) };
        }
    }

    /// Rehearses planners for so many seconds each, and puts the best first.
    fn ranked(&self, mut scores: Vec<Score>, secs: f64) -> Vec<Score> {
        if scores.first_mut().is_some_and(|first| self.is_unhindered(first, secs)) {
            return scores;
        }
        for number in 0..REHEARSALS {
            let hopeless = HOPELESS * best(&scores, number);
            if scores.iter().filter(|score| score.stops_of(number) >= hopeless).count() == 1 {
                break;
            }
            for score in scores.iter_mut().filter(|score| score.stops_of(number) >= hopeless) {
                self.rehearse_once(score, secs, number);
            }
        }
        let best = best(&scores, REHEARSALS);
        // The sort is stable: among those as good as the best, the first stays first.
        scores.sort_by(|a, b| b.rank(best).total_cmp(&a.rank(best)));
        scores
    }

    /// Whether robots carry about as much under a planner as if they drove through each other, and
    /// none stalls: then no other planner carries clearly more. Ends with the first rehearsal that
    /// says no.
    fn is_unhindered(&self, score: &mut Score, secs: f64) -> bool {
        for number in 0..REHEARSALS {
            self.rehearse_once(score, secs, number);
            let settings = Settings { conflicts: false, ..PlannerKind::Lanes.settings() };
            let bound = self.rehearse(PlannerKind::Lanes, settings, secs, number).stops;
            let Rehearsed { stops, has_stalled } = score.rehearsals[number];
            if has_stalled || (stops as f32) < AS_GOOD * bound as f32 {
                return false;
            }
        }
        true
    }

    /// Adds a rehearsal to a score, unless it has it.
    fn rehearse_once(&self, score: &mut Score, secs: f64, number: usize) {
        if score.rehearsals.len() == number {
            let rehearsed = self.rehearse(score.kind, score.kind.settings(), secs, number);
            score.rehearsals.push(rehearsed);
        }
    }

    /// The simulated seconds for which a planner can be rehearsed several times in a second or a few.
    fn affordable_secs(&self, kind: PlannerKind) -> f64 {
        let robots = self.bodies.iter().flatten().count().max(1) as f64;
        let cycles = match kind {
            PlannerKind::Committed => MOST_COMMITTED_WORK / robots / f64::from(self.roads.nodes()),
            _ => MOST_ROBOT_CYCLES / robots,
        };
        cycles * CYCLE_SECS / REHEARSALS as f64
    }

    fn rehearse(
        &self,
        kind: PlannerKind,
        settings: Settings,
        secs: f64,
        number: usize,
    ) -> Rehearsed {
        let settings = Settings { ends: self.ends, ..settings };
        let (planner, orders) = (kind.plain(self.roads), (self.orders)(number as u64));
        let mut manager = Manager::new(Arc::clone(self.roads), planner, settings, orders);
        let mut fleet = Model { bodies: self.bodies.clone(), ..Model::default() };
        let (mut standing, mut has_stalled) = (vec![0.0; self.bodies.len()], false);
        for cycle in 0..(secs / CYCLE_SECS) as u32 {
            if is_asked_to_end() {
                break;
            }
            self.notice.iter().for_each(Notice::tell_if_late);
            let now_secs = self.begin_secs + f64::from(cycle) * CYCLE_SECS;
            fleet.cycle(&mut manager, self.roads, self.robot_types, now_secs);
            for (robot, standing_secs) in (0..).zip(&mut standing) {
                let stands = manager.is_on_its_way(robot) && !fleet.moves(robot);
                *standing_secs = if stands { *standing_secs + CYCLE_SECS } else { 0.0 };
            }
            has_stalled |= standing.iter().any(|secs| *secs > STALL_SECS);
            if standing.iter().all(|secs| *secs > STALL_SECS) {
                break;
            }
        }
        Rehearsed { stops: manager.orders().handled_stops(), has_stalled }
    }
}

impl Notice {
    fn tell_if_late(&self) {
        if self.since.elapsed() >= TELL_AFTER && !self.is_told.replace(true) {
            tell!(
                "fleet-manager: the robots stand while planners are rehearsed on this layout, to \
                 choose one; `--planner NAME` chooses it at once"
            );
        }
    }
}

/// Whether the process was asked to end: then nobody needs the rest of a rehearsal.
fn is_asked_to_end() -> bool {
    #[cfg(feature = "shared-memory")]
    return regatta_plugin::Termination::was_requested();
    #[cfg(not(feature = "shared-memory"))]
    false
}

/// The end of a rehearsal.
#[derive(Clone, Copy)]
struct Rehearsed {
    /// The stops that robots handled.
    stops: usize,
    /// Whether a robot stalled.
    has_stalled: bool,
}

/// The rehearsals with a planner.
struct Score {
    kind: PlannerKind,
    rehearsals: Vec<Rehearsed>,
}

impl Score {
    fn of(kind: PlannerKind) -> Self {
        Self { kind, rehearsals: Vec::new() }
    }

    /// The stops of its first rehearsals. Those in which robots stalled count less.
    fn stops_of(&self, rehearsals: usize) -> f32 {
        let first = self.rehearsals.iter().take(rehearsals);
        first
            .map(|Rehearsed { stops, has_stalled }| {
                *stops as f32 * if *has_stalled { STALLED_WEIGHT } else { 1.0 }
            })
            .sum()
    }

    /// The rate of all of its rehearsals, of so many seconds each.
    fn rate(&self, secs: f64) -> Rate {
        match self.rehearsals.len() {
            0 => Rate::Unknown,
            count => Rate::Rehearsed(f64::from(self.stops_of(count)) / (count as f64 * secs)),
        }
    }

    /// The number to compare it with others by; infinity if it is as good as the best.
    fn rank(&self, best: f32) -> f32 {
        let stops = self.stops_of(REHEARSALS);
        let has_stalled = self.rehearsals.iter().any(|rehearsed| rehearsed.has_stalled);
        let is_within_chance = best - stops <= LEAST_DEVIATIONS * best.sqrt();
        match stops >= AS_GOOD * best || (is_within_chance && !has_stalled) {
            true => f32::INFINITY,
            false => stops,
        }
    }
}

/// The stops under the best planner in the first rehearsals.
fn best(scores: &[Score], rehearsals: usize) -> f32 {
    scores.iter().map(|score| score.stops_of(rehearsals)).fold(0.0, f32::max)
}

/// The robots of the model, and the columns of its frames.
#[derive(Default)]
struct Model {
    bodies: Vec<Option<Body>>,
    x: Vec<f32>,
    y: Vec<f32>,
    speed: Vec<f32>,
    s: Vec<f32>,
    edge: Vec<u32>,
    state: Vec<u8>,
}

impl Model {
    /// Shows a frame to the manager, and drives as it commands.
    fn cycle(&mut self, manager: &mut Manager, roads: &Roads, robot_types: &[f32], now_secs: f64) {
        self.show(roads);
        let Self { bodies, x, y, speed, s, edge, state } = self;
        let columns = Columns { x, y, theta: x, speed, s, edge, state };
        for command in manager.cycle(now_secs, &columns, robot_types, &[]) {
            if let Some(body) = &mut bodies[command.robot() as usize] {
                body.obey(command, roads);
            }
        }
        for body in bodies.iter_mut().flatten() {
            body.drive(roads, CYCLE_SECS as f32);
        }
    }

    /// Whether a robot moved in the last cycle.
    fn moves(&self, robot: u32) -> bool {
        self.bodies[robot as usize].as_ref().is_some_and(|body| body.speed() > 0.0)
    }

    fn show(&mut self, roads: &Roads) {
        let Self { bodies, x, y, speed, s, edge, state } = self;
        for column in [&mut *x, y, speed, s] {
            column.clear();
        }
        edge.clear();
        state.clear();
        for body in bodies {
            let pose = body.as_ref().map_or_else(Pose::default, |body| body.pose(roads));
            x.push(pose.position.x);
            y.push(pose.position.y);
            speed.push(pose.speed);
            s.push(pose.s);
            edge.push(pose.edge);
            let state_now = if body.is_some() { RobotState::Idle } else { RobotState::Absent };
            state.push(state_now as u8);
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_orders::{Load, Places};
    use regatta_plugin::world::WorldData;

    use super::*;
    use crate::model::{drive, places, worlds};

    const KINDS: [PlannerKind; 3] = [PlannerKind::Committed, PlannerKind::Lanes, PlannerKind::Pibt];

    /// The planner that carries the most in a rehearsal.
    fn best(world: &WorldData, robots: usize) -> PlannerKind {
        let view = world.view(1, 1);
        let (roads, known) = (Arc::new(Roads::new(&view)), Arc::new(Places::of(&view)));
        let starts = places(world, robots, 1);
        let edge: Vec<u32> = starts.iter().map(|(leg, _)| leg.edge()).collect();
        let s: Vec<f32> = starts.iter().map(|(_, place)| *place).collect();
        let (zeros, state) = (vec![0.0; robots], vec![RobotState::Idle as u8; robots]);
        let (x, y, speed) = (&zeros, &zeros, &zeros);
        let columns = Columns { x, y, theta: &zeros, speed, s: &s, edge: &edge, state: &state };
        let orders = |number| OrderPool::new(known.clone()).for_rehearsal(number);
        let mut candidates = KINDS.map(Candidate::from);
        Rehearsal::new(&roads, &orders, &columns, &[]).sort(&mut candidates);
        candidates[0].kind
    }

    /// The other model drives to random goals, lets robots be late, and checks that they don't
    /// touch.
    #[test]
    fn the_planner_of_a_rehearsal_carries_the_most_in_another_model_too() {
        for (name, world, robots) in
            [("a single track", worlds::single_track(7), 4), ("cells", worlds::cells(5), 12)]
        {
            let goals = |kind: PlannerKind| {
                let maker = match kind {
                    PlannerKind::Lanes => |roads: &Roads| PlannerKind::Lanes.plain(roads),
                    PlannerKind::Pibt => |roads: &Roads| PlannerKind::Pibt.plain(roads),
                    _ => |roads: &Roads| PlannerKind::Committed.plain(roads),
                };
                drive(name, &world, (robots, 1), 900, maker).total()
            };
            let most = KINDS.into_iter().map(goals).max().expect("three planners");
            let best = best(&world, robots);
            let carried = goals(best);
            assert!(10 * carried >= 8 * most, "{name}: {best:?} {carried} of {most}");
        }
    }

    /// A manager that begins late has a load whose next orders come late, too.
    #[test]
    fn orders_come_from_the_time_on_at_which_a_rehearsal_begins() {
        let world = worlds::single_track(7);
        let view = world.view(1, 1);
        let (roads, known) = (Arc::new(Roads::new(&view)), Arc::new(Places::of(&view)));
        let starts = places(&world, 2, 1);
        let edge: Vec<u32> = starts.iter().map(|(leg, _)| leg.edge()).collect();
        let s: Vec<f32> = starts.iter().map(|(_, place)| *place).collect();
        let (x, state) = ([0.0; 2], [RobotState::Idle as u8; 2]);
        let columns =
            Columns { x: &x, y: &x, theta: &x, speed: &x, s: &s, edge: &edge, state: &state };
        let load = "load: {shifts: [{until: 5000, per_hour: 0}, {until: 9000, per_hour: 120}]}";
        let load = Load::parse(load, &known).expect("a load");
        let orders = |number| {
            let mut pool = OrderPool::new(known.clone());
            pool.add_load(&load);
            pool.for_rehearsal(number)
        };
        let handled = |secs: f64| {
            let rehearsal = Rehearsal::new(&roads, &orders, &columns, &[]).beginning_at(secs);
            let settings = PlannerKind::Lanes.settings();
            rehearsal.rehearse(PlannerKind::Lanes, settings, 600.0, 0).stops
        };
        assert_eq!(handled(0.0), 0);
        assert!(handled(5000.0) > 5, "{}", handled(5000.0));
    }

    #[test]
    fn a_robot_on_a_node_without_an_edge_to_it_drives_off() {
        let points = [[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]];
        let edges = [[0, 1], [1, 0], [2, 0]];
        let footprint = [0.9, 0.6];
        let orientation = regatta_plugin::world::Orientation::Tangential;
        let world = worlds::straight(&points, &edges, footprint, orientation);
        let view = world.view(1, 1);
        let (roads, known) = (Arc::new(Roads::new(&view)), Arc::new(Places::of(&view)));
        let columns = Columns {
            x: &[0.0],
            y: &[9.0],
            theta: &[0.0],
            speed: &[0.0],
            s: &[0.0],
            edge: &[NO_EDGE],
            state: &[RobotState::Idle as u8],
        };
        let orders = |number| OrderPool::new(known.clone()).for_rehearsal(number);
        let rehearsal = Rehearsal::new(&roads, &orders, &columns, &[]);
        let settings = PlannerKind::Lanes.settings();
        let Rehearsed { stops, has_stalled } =
            rehearsal.rehearse(PlannerKind::Lanes, settings, 900.0, 0);
        assert!(stops > 20 && !has_stalled, "{stops}");
    }

    #[test]
    fn some_stops_more_are_chance_and_stalls_are_not() {
        let rank = |stops: usize, has_stalled: bool, best: f32| {
            let rehearsals = vec![Rehearsed { stops, has_stalled }];
            Score { kind: PlannerKind::Lanes, rehearsals }.rank(best)
        };
        assert_eq!(rank(7, false, 11.0), f32::INFINITY);
        assert_eq!(rank(28, true, 11.0), 7.0);
        assert_eq!(rank(70, false, 110.0), 70.0);
        assert_eq!(rank(412, true, 110.0), f32::INFINITY);
    }
}
