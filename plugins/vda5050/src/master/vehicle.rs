//! A vehicle of somebody else, as a robot: what it says makes a row of a frame, and commands make
//! orders. It knows neither brokers nor clocks.

mod place;
mod row;
mod watch;
mod work;

use regatta_plugin::event::{BASE_WANTED, EventKind, EventRecord};
use regatta_plugin::frame::RobotState;

pub use row::Row;

use super::course::Course;
use super::roads::Roads;
use super::talk::{After, News, Saying, Talk};
use super::trouble::Trouble;
use crate::message::{Connection, ConnectionState, Factsheet, Position, State, Velocity};

/// The limits by which vehicles are watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Metres by which a vehicle may be off its way.
    pub tolerance: f64,
    /// Seconds without a message after which a vehicle counts as offline.
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
    /// Whether one of its actions has failed since it last had no load.
    has_failed: bool,
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
            has_failed: false,
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
        let node = roads.map().find_node(&state.last_node_id).map(|node| roads.node(node).number);
        for news in self.talk.take(&state, now) {
            self.take_news(news, node);
        }
        self.has_failed &= has_load(&state);
        if let (Some(course), Some(number)) = (&mut self.course, self.talk.number(&state)) {
            let events = &mut self.events;
            course.finish(number, roads, |node| {
                events.push(event(EventKind::ReachedNode, roads.node(node).number));
            });
        }
        self.ask_for_base(&state, roads);
        let (position, velocity) = (state.mobile_robot_position.clone(), state.velocity);
        self.state = Some(state);
        self.take_position(position, velocity, roads, now);
        self.find_place(roads, limits);
    }

    /// Passes on that the vehicle wants a longer base, unless there is one that it hasn't taken yet.
    fn ask_for_base(&mut self, state: &State, roads: &Roads) {
        let Some(course) = &self.course else { return };
        if state.new_base_request == Some(true) && self.talk.has_all(course.base_end(roads)) {
            let wanted = event(EventKind::WaitingForRelease, 0);
            self.events.push(EventRecord { detail: BASE_WANTED, ..wanted });
        }
    }

    /// Takes news from a vehicle that tells a last node; the layout may not have that node.
    fn take_news(&mut self, news: News, node: Option<u32>) {
        match news {
            News::OrderLost => {
                self.lines.push("it has lost its order, and gets it again".to_owned());
            }
            News::Rejected(_) | News::Cancelled(After::GoOn) => {}
            News::Cancelled(After::End) => {
                if let Some(course) = &mut self.course {
                    course.drop_base();
                }
            }
            News::ActionFailed(kind, result) => {
                let reason = if result.is_empty() { "it reports no result" } else { &result };
                self.lines.push(format!("its action {kind} has failed: {reason}"));
                self.has_failed = true;
                self.events.push(event(EventKind::ActionFailed, node.unwrap_or_default()));
            }
        }
    }

    /// Whether it still has the load of an order that has failed.
    fn has_stray_load(&self) -> bool {
        self.has_failed && self.state.as_ref().is_some_and(has_load)
    }

    /// Lets it work again with the load that it still has. Returns whether it had one.
    pub fn accept_load(&mut self) -> bool {
        let had_one = self.has_stray_load();
        self.has_failed = false;
        had_one
    }

    /// Holds it, or lets it go on.
    pub fn hold(&mut self, is_held: bool) {
        self.is_held = is_held;
    }

    /// Changes its course. `None` if it is at no place of the roads.
    pub fn course_mut(&mut self) -> Option<&mut Course> {
        self.course.as_mut()
    }
}

/// Whether a vehicle tells of a load.
fn has_load(state: &State) -> bool {
    state.loads.as_ref().is_some_and(|loads| !loads.is_empty())
}

/// An event without a robot and a token.
fn event(kind: EventKind, id: u32) -> EventRecord {
    EventRecord { kind: kind as u32, id, ..EventRecord::default() }
}
