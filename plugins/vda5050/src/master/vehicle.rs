//! A vehicle of somebody else, as a robot: what it says makes a row of a frame, and commands make
//! orders. It knows neither brokers nor clocks.

use regatta_plugin::event::{BreakdownCause, EventKind, EventRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::StopAction;

use super::course::Course;
use super::roads::Roads;
use super::talk::{After, News, Saying, Talk};
use super::trouble::Trouble;
use crate::message::{
    ActionParameter, Connection, ConnectionState, Factsheet, Position, State, Velocity,
};

/// The time after a robot has come to a charger until it begins to charge, in seconds.
const CHARGE_AFTER: f64 = 1.0;
/// The charge up to which a robot that stands at a charger begins to charge, in per cent.
const CHARGE_BELOW: f64 = 95.0;
/// The distance from a node at which a vehicle that names it is there in any case, in metres.
const AT_NODE: f64 = 0.5;

/// The action that begins to charge.
const CHARGE: &str = "startCharging";

/// The limits by which vehicles are watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Metres by which a vehicle may be off its way.
    pub tolerance: f64,
    /// Seconds without a message after which a vehicle counts as gone.
    pub silence: f64,
}

/// A vehicle.
#[derive(Debug)]
pub struct Vehicle {
    connection: ConnectionState,
    state: Option<State>,
    /// The time of its last message, in seconds.
    heard: f64,
    position: Option<Position>,
    velocity: Option<Velocity>,
    /// Metres between the vehicle and its way.
    off_way: f64,
    course: Option<Course>,
    talk: Talk,
    trouble: Option<Trouble>,
    /// Whether it may be elsewhere than on its way since its last trouble.
    is_loose: bool,
    size: Size,
    /// Whether a command has taken it out of the fleet, until something comes from it.
    is_removed: bool,
    /// The time from which on it is asked for what it hasn't told.
    ask_at: f64,
    is_held: bool,
    /// Whether the next edge of its base is closed.
    is_barred: bool,
    /// Since when it has stood at a charger without work, in seconds.
    rests_since: Option<f64>,
    /// The state in the last frame.
    shown: RobotState,
    /// Events since they were last taken; tokens and robots are filled in later.
    events: Vec<EventRecord>,
    /// Lines for people.
    lines: Vec<String>,
}

/// The size of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Size {
    /// It hasn't told it.
    Untold,
    /// It is at most that of a robot type, by its index.
    Type(usize),
    /// It is more than those of all types: metres of length and width.
    TooLarge([f64; 2]),
}

/// A vehicle in a frame. Positions are metres on the map of the layout's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Metres.
    pub position: [f64; 2],
    /// Radians.
    pub theta: f64,
    /// Metres per second.
    pub speed: f64,
    /// The index of the edge, and the metres from its origin.
    pub place: Option<(u32, f64)>,
    /// The state.
    pub state: RobotState,
}

impl Vehicle {
    /// Makes a vehicle of which nothing is known. The ids of its orders begin with `prefix`.
    pub fn new(prefix: String) -> Self {
        Self {
            connection: ConnectionState::Online,
            state: None,
            heard: 0.0,
            position: None,
            velocity: None,
            off_way: 0.0,
            course: None,
            talk: Talk::new(prefix),
            trouble: None,
            is_loose: true,
            size: Size::Untold,
            is_removed: false,
            ask_at: f64::NEG_INFINITY,
            is_held: false,
            is_barred: false,
            rests_since: None,
            shown: RobotState::Idle,
            events: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// Whether it has told its state.
    pub fn is_known(&self) -> bool {
        self.state.is_some()
    }

    /// The state in the last frame.
    pub fn shown(&self) -> RobotState {
        self.shown
    }

    /// Its course; `None` if it is at no place of the roads.
    pub fn course(&self) -> Option<&Course> {
        self.course.as_ref()
    }

    /// The charge of its battery, in per cent.
    pub fn charge(&self) -> Option<f64> {
        self.state.as_ref().map(|state| state.power_supply.state_of_charge)
    }

    /// Takes the events since the last call.
    pub fn take_events(&mut self) -> Vec<EventRecord> {
        std::mem::take(&mut self.events)
    }

    /// Takes the lines for people since the last call.
    pub fn take_lines(&mut self) -> Vec<String> {
        std::mem::take(&mut self.lines)
    }

    /// The index of its robot type.
    pub fn robot_type(&self) -> usize {
        match self.size {
            Size::Type(index) => index,
            Size::Untold | Size::TooLarge(_) => 0,
        }
    }

    /// Whether it is connected.
    pub fn is_online(&self) -> bool {
        self.connection == ConnectionState::Online
    }

    /// Takes it out of the fleet, until something comes from it. Returns whether that is possible:
    /// whether it isn't connected.
    pub fn remove(&mut self) -> bool {
        self.is_removed = !self.is_online();
        self.is_removed
    }

    /// Takes a message about its connection.
    pub fn take_connection(&mut self, connection: &Connection, now: f64) {
        self.connection = connection.connection_state;
        self.hear(now);
    }

    /// Notes that it may have been heard by now, as far as the broker is there.
    pub fn hear(&mut self, now: f64) {
        self.heard = now;
        if self.is_removed && self.is_online() {
            (self.is_removed, self.course) = (false, None);
        }
    }

    /// Takes its factsheet. `find_type` finds a robot type that is as large as some metres of
    /// length and width.
    pub fn take_factsheet(
        &mut self,
        factsheet: &Factsheet,
        find_type: impl Fn(f64, f64) -> Option<usize>,
    ) {
        let size = &factsheet.physical_parameters;
        let (length, width) = (size.length, size.width);
        self.size = match find_type(length, width) {
            Some(index) => Size::Type(index),
            None => Size::TooLarge([length, width]),
        };
    }

    /// Returns what to ask of it that it hasn't told: its state and its factsheet.
    pub fn ask(&mut self, now: f64) -> Option<Saying> {
        /// The time between two questions, in seconds.
        const PATIENCE: f64 = 10.0;
        let question = match (self.is_known(), self.size) {
            (false, _) => "stateRequest",
            (true, Size::Untold) => "factsheetRequest",
            _ => return None,
        };
        if !self.is_online() || now < self.ask_at {
            return None;
        }
        // A vehicle may have no factsheet: it is asked for it once.
        self.ask_at = if self.is_known() { f64::INFINITY } else { now + PATIENCE };
        Some(Saying::Instant(self.talk.instant(question)))
    }

    /// Takes its position.
    pub fn take_position(
        &mut self,
        position: Option<Position>,
        velocity: Option<Velocity>,
        roads: &Roads,
        now: f64,
    ) {
        self.hear(now);
        self.velocity = velocity;
        if position.is_some() {
            self.position = position;
        }
        self.follow(roads);
    }

    /// Takes its state.
    pub fn take_state(&mut self, state: State, roads: &Roads, limits: Limits, now: f64) {
        // A vehicle that tells its state is there, whatever was told of its connection.
        self.connection = ConnectionState::Online;
        if self.state.is_none() {
            self.ask_at = now;
        }
        for news in self.talk.take(&state, now) {
            self.take_news(news);
        }
        if let (Some(course), Some(number)) = (&mut self.course, self.talk.number(&state)) {
            let events = &mut self.events;
            course.finish(number, roads, |node| {
                events.push(event(EventKind::ReachedNode, roads.node(node).number));
            });
        }
        let (position, velocity) = (state.mobile_robot_position.clone(), state.velocity);
        self.state = Some(state);
        self.take_position(position, velocity, roads, now);
        self.find_place(roads, limits);
    }

    fn take_news(&mut self, news: News) {
        match news {
            News::Rejected(_) => {}
            News::OrderLost => {
                self.lines.push("it no longer has its order, and gets it again".to_owned());
            }
            News::Cancelled(After::GoOn) => {}
            News::Cancelled(After::End) => {
                if let Some(course) = &mut self.course {
                    course.drop_base();
                }
            }
            News::ActionFailed(kind, result) => {
                self.lines.push(format!("its action {kind} has failed: {result}"));
            }
        }
    }

    /// Moves the robot along its course to where the vehicle is.
    fn follow(&mut self, roads: &Roads) {
        let (Some(course), Some(state)) = (&mut self.course, &self.state) else { return };
        // What a person drives isn't on its way, even if it is near it.
        if Trouble::of_state(state).is_some_and(|trouble| trouble.is_loose()) {
            return;
        }
        let Some(position) = &self.position else {
            self.off_way = 0.0;
            let told = self.talk.number(state).zip(state.distance_since_last_node);
            if let Some((number, metres)) = told {
                course.drive(number, metres, roads);
            }
            return;
        };
        let position = [position.x, position.y];
        let number = self.talk.number(state).unwrap_or_else(|| course.first(roads));
        if let Some(leg) = course.leg(number) {
            /// The metres from a node up to which a vehicle counts as standing there.
            const STILL_AT_NODE: f64 = 0.05;
            let travelled = roads.nearest_on(leg, position).travelled;
            if travelled > STILL_AT_NODE && course.base_end(roads) > number {
                course.drive(number, travelled, roads);
            }
        }
        self.off_way = off_way(course, position, roads);
    }

    /// Finds the place of a vehicle that isn't where its course says.
    fn find_place(&mut self, roads: &Roads, limits: Limits) {
        let Some(state) = &self.state else { return };
        let is_fine = Trouble::of_state(state).is_none();
        let is_away = self.off_way > limits.tolerance || self.stands_elsewhere(roads, limits);
        if !is_fine || !is_away || state.driving || self.talk.is_cancelling() {
            self.is_loose &= is_away || !is_fine;
            return;
        }
        let Some((leg, travelled)) = self.place(roads, limits) else { return };
        self.course = Some(Course::at(leg, travelled));
        self.talk.forget();
        (self.off_way, self.is_loose) = (0.0, false);
    }

    /// Whether a vehicle without an order stands elsewhere than where its course has it.
    fn stands_elsewhere(&self, roads: &Roads, limits: Limits) -> bool {
        let (Some(course), Some(position)) = (&self.course, &self.position) else {
            return self.course.is_none();
        };
        let (leg, travelled) = course.place();
        let found = roads.nearest_on(leg, [position.x, position.y]).travelled;
        !self.talk.has_order() && (found - travelled).abs() > AT_NODE.max(limits.tolerance)
    }

    /// The leg on which the vehicle is, and the metres from its start.
    fn place(&self, roads: &Roads, limits: Limits) -> Option<(regatta_base::graph::Leg, f64)> {
        let state = self.state.as_ref()?;
        let node = roads.map().find_node(&state.last_node_id);
        let Some(position) = &self.position else { return roads.stance(node?) };
        let position = [position.x, position.y];
        let far = |node: u32| {
            let place = roads.node(node);
            super::roads::distance([place.x, place.y], position)
        };
        if let Some(node) = node.filter(|node| far(*node) <= AT_NODE.max(limits.tolerance)) {
            return roads.stance(node);
        }
        let (leg, found) = roads.nearest_leg(position)?;
        (found.distance <= limits.tolerance).then_some((leg, found.travelled))
    }

    /// Looks after the vehicle: notes and tells troubles that begin and end.
    pub fn look(&mut self, limits: Limits, now: f64) {
        let trouble = self.find_trouble(limits, now);
        let is_same = match (&self.trouble, &trouble) {
            (None, None) => true,
            (Some(before), Some(after)) => before.is_like(after),
            _ => false,
        };
        if !is_same {
            self.tell(trouble.as_ref());
        }
        self.is_loose |= trouble.as_ref().is_some_and(Trouble::is_loose);
        self.trouble = trouble;
    }

    fn tell(&mut self, trouble: Option<&Trouble>) {
        match trouble {
            Some(trouble) => {
                let measure = match trouble.is_loose() {
                    true => "the edges around it are closed",
                    false => "its way is kept free",
                };
                self.lines.push(format!("{trouble}; {measure}"));
                if self.trouble.is_none() {
                    let detail = BreakdownCause::Unknown as u32;
                    self.events.push(EventRecord { detail, ..event(EventKind::BrokenDown, 0) });
                }
            }
            None => {
                self.lines.push("it can be steered again".to_owned());
                self.events.push(event(EventKind::Repaired, 0));
            }
        }
    }

    fn find_trouble(&self, limits: Limits, now: f64) -> Option<Trouble> {
        if self.connection != ConnectionState::Online {
            return Some(Trouble::Gone(self.connection));
        }
        let state = self.state.as_ref()?;
        let silence = now - self.heard;
        if silence > limits.silence {
            return Some(Trouble::Silent(silence as u64));
        }
        if let Some(trouble) = Trouble::of_state(state) {
            return Some(trouble);
        }
        if let Size::TooLarge(size) = self.size {
            return Some(Trouble::TooLarge(size));
        }
        if self.course.is_none() {
            return Some(Trouble::OffRoads);
        }
        if self.off_way > limits.tolerance {
            return Some(Trouble::Astray(self.off_way));
        }
        if let Some(reason) = self.talk.rejection() {
            return Some(Trouble::Rejects(reason.to_owned()));
        }
        self.talk.is_unanswered().then_some(Trouble::Mute)
    }

    /// The position of a vehicle around which no robot may drive.
    pub fn loose_at(&self) -> Option<[f64; 2]> {
        let is_loose = self.is_loose && self.is_known() && !self.is_removed;
        let position = self.position.as_ref().filter(|_| is_loose)?;
        Some([position.x, position.y])
    }

    /// Returns what to tell it now. `is_closed` says whether an edge is closed.
    pub fn say(
        &mut self,
        roads: &Roads,
        is_closed: impl Fn(u32) -> bool,
        now: f64,
    ) -> Option<Saying> {
        if self.trouble.as_ref().is_some_and(|trouble| !trouble.may_be_told()) {
            return None;
        }
        self.charge_at_rest(roads, now);
        let (Some(state), Some(course)) = (&self.state, &self.course) else { return None };
        let next = course.ahead().front().filter(|step| step.released);
        self.is_barred = next.is_some_and(|step| is_closed(step.leg.edge.0));
        self.talk.say(state, course, roads, self.is_held || self.is_barred, now)
    }

    /// Lets a vehicle without work charge that stands at a charger.
    fn charge_at_rest(&mut self, roads: &Roads, now: f64) {
        let (Some(state), Some(course)) = (&self.state, &self.course) else { return };
        let rests = course.is_at_end(roads)
            && course.ahead().is_empty()
            && !self.talk.has_jobs()
            && roads.node(roads.end(course.place().0)).is_charger
            && !state.power_supply.charging
            && state.power_supply.state_of_charge < CHARGE_BELOW;
        if !rests {
            self.rests_since = None;
        } else if now - *self.rests_since.get_or_insert(now) >= CHARGE_AFTER {
            // Until then it may have been sent elsewhere, or it refuses to charge.
            self.rests_since = Some(f64::INFINITY);
            self.talk.add_job(CHARGE, Vec::new());
        }
    }

    /// Lets it carry out the action of a stop where it stands. `parameters` has those of a kind of
    /// action.
    pub fn handle(
        &mut self,
        action: StopAction,
        parameters: impl FnOnce(&str) -> Vec<ActionParameter>,
    ) {
        let kind = match action {
            StopAction::Pick => "pick",
            StopAction::Drop => "drop",
            StopAction::Charge => CHARGE,
            StopAction::None | StopAction::Park => return,
        };
        self.talk.add_job(kind, parameters(kind));
    }

    /// Holds it, or lets it go on.
    pub fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    /// Changes its course. `None` if it is at no place of the roads.
    pub fn course_mut(&mut self) -> Option<&mut Course> {
        self.course.as_mut()
    }

    /// Drops its route beyond the edge that it is on.
    pub fn cancel(&mut self, roads: &Roads) {
        let Some(course) = &mut self.course else { return };
        course.drop_horizon();
        if course.base_end(roads) > course.first(roads) && !course.ahead().is_empty() {
            self.talk.cancel(After::End);
        }
    }

    /// Returns the vehicle as a row of a frame.
    pub fn row(&mut self, roads: &Roads) -> Option<Row> {
        let state = self.state.as_ref().filter(|_| !self.is_removed)?;
        let shown = self.robot_state(state, roads);
        let driving = matches!(shown, RobotState::Driving | RobotState::Held | RobotState::Stalled);
        let speed = self.speed(state, roads);
        let place = self.course.as_ref().map(|course| {
            let (leg, travelled) = course.place();
            let is_reverse = leg.gear == regatta_base::graph::Gear::Reverse;
            let s = if is_reverse { roads.length(leg) - travelled } else { travelled };
            (leg.edge.0, s)
        });
        let node = roads.map().find_node(&state.last_node_id).map(|node| roads.node(node));
        let position = match (&self.position, node) {
            (Some(position), _) => [position.x, position.y],
            (None, Some(node)) => [node.x, node.y],
            (None, None) => [0.0; 2],
        };
        let row = Row {
            position,
            theta: self.position.as_ref().map_or(0.0, |position| position.theta),
            speed: if driving { speed } else { 0.0 },
            place,
            state: shown,
        };
        self.note_change(shown);
        Some(row)
    }

    fn speed(&self, state: &State, roads: &Roads) -> f64 {
        if !state.driving {
            return 0.0;
        }
        let told = self.velocity.and_then(|velocity| {
            let [vx, vy] = [velocity.vx?, velocity.vy.unwrap_or(0.0)];
            Some(vx.hypot(vy).copysign(vx))
        });
        let leg = self.course.as_ref().map(|course| course.place().0);
        told.unwrap_or_else(|| leg.map_or(0.0, |leg| roads.map().speed(leg)))
    }

    fn robot_state(&self, state: &State, roads: &Roads) -> RobotState {
        if self.trouble.is_some() {
            return RobotState::Broken;
        }
        let Some(course) = &self.course else { return RobotState::Faulted };
        if self.is_held {
            RobotState::Held
        } else if self.talk.has_jobs() {
            RobotState::Stalled
        } else if state.driving || course.may_drive(roads) || self.talk.is_cancelling() {
            RobotState::Driving
        } else if course.ahead().is_empty() {
            RobotState::Idle
        } else {
            RobotState::Waiting
        }
    }

    /// Notes the events of a change of state.
    fn note_change(&mut self, shown: RobotState) {
        let before = std::mem::replace(&mut self.shown, shown);
        let kind = match (before, shown) {
            (RobotState::Driving, RobotState::Idle) => EventKind::RouteDone,
            (RobotState::Driving, RobotState::Waiting) => EventKind::WaitingForRelease,
            (RobotState::Held, RobotState::Driving | RobotState::Waiting) => EventKind::Resumed,
            (RobotState::Driving | RobotState::Waiting, RobotState::Held) => EventKind::Held,
            _ => return,
        };
        self.events.push(event(kind, 0));
    }
}

/// An event without a robot and a token.
fn event(kind: EventKind, id: u32) -> EventRecord {
    EventRecord { kind: kind as u32, id, ..EventRecord::default() }
}

/// Metres between a position and the way of a course near by: the leg that the robot is on, and the
/// next ones of its base.
fn off_way(course: &Course, position: [f64; 2], roads: &Roads) -> f64 {
    /// The legs after the first that a vehicle may have come to since its last state.
    const LEGS: usize = 3;
    let ahead = course.ahead().iter().take_while(|step| step.released).take(LEGS);
    let legs = core::iter::once(course.place().0).chain(ahead.map(|step| step.leg));
    legs.map(|leg| roads.nearest_on(leg, position).distance).fold(f64::INFINITY, f64::min)
}
