//! A correct conversation of a master with a vehicle, in any version.

use serde_json::Value;

use crate::judge::{Delivery, Finding, Judge, Protocol, Seen, clock};
use crate::message::*;

/// The time when the conversation begins, in seconds since 1970.
const START: f64 = 1_700_000_000.0;

/// Messages as they come from a broker.
#[derive(Clone)]
pub struct Conversation {
    pub version: Version,
    pub messages: Vec<Sent>,
    header_ids: [u32; 6],
    serial: &'static str,
}

/// A message, whose content a test may change.
#[derive(Clone)]
pub struct Sent {
    pub time: f64,
    pub topic: String,
    pub content: Value,
    /// Bytes in place of the content.
    pub bytes: Option<Vec<u8>>,
    pub delivery: Option<Delivery>,
}

/// A state of the vehicle, in short.
pub struct Shown<'a> {
    pub order: (&'a str, u32),
    pub last: (&'a str, u32),
    /// The nodes that are left, with their sequence ids; those of the horizon have a minus.
    pub nodes: &'a [(&'a str, i32)],
    pub x: f64,
    pub driving: bool,
    pub paused: bool,
    pub actions: &'a [(&'a str, ActionStatus)],
    pub instant: &'a [(&'a str, ActionStatus)],
}

pub const IDLE: Shown<'_> = Shown {
    order: ("", 0),
    last: ("", 0),
    nodes: &[],
    x: 0.0,
    driving: false,
    paused: false,
    actions: &[],
    instant: &[],
};

/// The x of a node, 4 m from the next.
fn x(node: &str) -> f64 {
    node.trim_start_matches('n').parse::<f64>().unwrap_or_default() * 4.0
}

pub fn node(name: &str, sequence_id: u32, released: bool) -> Node {
    let position = NodePosition {
        x: x(name),
        map_id: "m".to_owned(),
        theta: Some(0.0),
        allowed_deviation: Some(AllowedDeviation::Radius(0.5)),
        ..NodePosition::default()
    };
    Node {
        node_id: name.to_owned(),
        sequence_id,
        released,
        node_position: Some(position),
        ..Node::default()
    }
}

pub fn edge(sequence_id: u32, released: bool) -> Edge {
    Edge {
        edge_id: format!("e{sequence_id}"),
        sequence_id,
        released,
        maximum_speed: Some(2.0),
        ..Edge::default()
    }
}

pub fn action(id: &str, kind: &str, blocking_type: BlockingType) -> Action {
    Action {
        action_id: id.to_owned(),
        action_type: kind.to_owned(),
        blocking_type,
        ..Action::default()
    }
}

impl Conversation {
    /// A conversation without messages.
    pub fn empty(version: Version, serial: &'static str) -> Self {
        Self { version, messages: Vec::new(), header_ids: [0; 6], serial }
    }

    /// A vehicle comes, has an order with an update and a pause, a second order that is cancelled,
    /// and goes.
    pub fn correct(version: Version) -> Self {
        let mut talk = Self::empty(version, "0001");
        talk.arrive(0.0);
        talk.first_order();
        talk.second_order();
        talk.connection(12.0, ConnectionState::Offline);
        talk
    }

    pub fn arrive(&mut self, time: f64) {
        self.connection(time, ConnectionState::Online);
        let physical_parameters =
            PhysicalParameters { length: 1.0, width: 0.5, ..PhysicalParameters::default() };
        let type_specification = TypeSpecification {
            mobile_robot_kinematics: "DIFF".to_owned(),
            mobile_robot_class: "CARRIER".to_owned(),
            ..TypeSpecification::default()
        };
        self.send(
            time + 0.1,
            Factsheet { physical_parameters, type_specification, ..Factsheet::default() },
        );
        self.state(time + 0.2, &IDLE);
    }

    fn first_order(&mut self) {
        use ActionStatus::{Finished, Running, Waiting};
        let mut first = node("n1", 2, true);
        first.actions.push(action("a1", "pick", BlockingType::Hard));
        let nodes = [node("n0", 0, true), first.clone(), node("n2", 4, false)];
        self.order(1.0, ("o1", 0), &nodes, &[edge(1, true), edge(3, false)]);
        let begun = Shown {
            order: ("o1", 0),
            last: ("n0", 0),
            nodes: &[("n1", 2), ("n2", -4)],
            driving: true,
            actions: &[("a1", Waiting)],
            ..IDLE
        };
        self.state(1.2, &begun);
        self.state(2.0, &Shown { x: 2.0, ..begun });
        self.visualization(2.1, 2.1);
        self.order(3.0, ("o1", 1), &[first, node("n2", 4, true)], &[edge(3, true)]);
        let updated = Shown { order: ("o1", 1), nodes: &[("n1", 2), ("n2", 4)], ..begun };
        self.state(3.2, &Shown { x: 3.0, ..updated });
        let working = Shown {
            last: ("n1", 2),
            nodes: &[("n2", 4)],
            x: 4.0,
            driving: false,
            actions: &[("a1", Running)],
            ..updated
        };
        self.state(4.0, &working);
        self.instant(4.5, "i1", "startPause");
        let paused = Shown { paused: true, instant: &[("i1", Finished)], ..working };
        self.state(4.7, &paused);
        self.instant(5.0, "i2", "stopPause");
        let resumed = Shown {
            driving: true,
            actions: &[("a1", Finished)],
            instant: &[("i1", Finished), ("i2", Finished)],
            ..working
        };
        self.state(5.2, &resumed);
        self.state(6.0, &Shown { x: 6.0, ..resumed });
        let done = Shown { last: ("n2", 4), nodes: &[], driving: false, x: 8.0, ..resumed };
        self.state(7.0, &done);
    }

    fn second_order(&mut self) {
        use ActionStatus::Finished;
        let nodes = [node("n2", 0, true), node("n3", 2, true)];
        self.order(8.0, ("o2", 0), &nodes, &[edge(1, true)]);
        let begun = Shown {
            order: ("o2", 0),
            last: ("n2", 0),
            nodes: &[("n3", 2)],
            x: 8.0,
            driving: true,
            ..IDLE
        };
        self.state(8.2, &begun);
        self.instant(9.0, "i3", "cancelOrder");
        let cancelled =
            Shown { nodes: &[], driving: false, x: 8.8, instant: &[("i3", Finished)], ..begun };
        self.state(9.2, &cancelled);
        self.state(10.0, &cancelled);
    }

    pub fn order(&mut self, time: f64, order: (&str, u32), nodes: &[Node], edges: &[Edge]) {
        self.send(
            time,
            Order {
                order_id: order.0.to_owned(),
                order_update_id: order.1,
                nodes: nodes.to_vec(),
                edges: edges.to_vec(),
                ..Order::default()
            },
        );
    }

    pub fn instant(&mut self, time: f64, id: &str, kind: &str) {
        let actions = vec![action(id, kind, BlockingType::None)];
        self.send(time, InstantActions { actions, ..InstantActions::default() });
    }

    pub fn connection(&mut self, time: f64, connection_state: ConnectionState) {
        self.send(time, Connection { header: Header::default(), connection_state });
    }

    pub fn visualization(&mut self, time: f64, x: f64) {
        let mobile_robot_position = Some(position(x));
        self.send(time, Visualization { mobile_robot_position, ..Visualization::default() });
    }

    pub fn state(&mut self, time: f64, shown: &Shown<'_>) {
        let nodes = shown.nodes.iter().map(|(name, id)| NodeState {
            node_id: (*name).to_owned(),
            sequence_id: id.unsigned_abs(),
            released: *id > 0,
            ..NodeState::default()
        });
        let edges = shown.nodes.iter().map(|(_, id)| EdgeState {
            edge_id: format!("e{}", id.unsigned_abs() - 1),
            sequence_id: id.unsigned_abs() - 1,
            released: *id > 0,
            ..EdgeState::default()
        });
        let speed = if shown.driving { 1.0 } else { 0.0 };
        self.send(
            time,
            State {
                order_id: shown.order.0.to_owned(),
                order_update_id: shown.order.1,
                last_node_id: shown.last.0.to_owned(),
                last_node_sequence_id: shown.last.1,
                node_states: nodes.collect(),
                edge_states: edges.collect(),
                mobile_robot_position: Some(position(shown.x)),
                velocity: Some(Velocity { vx: Some(speed), ..Velocity::default() }),
                driving: shown.driving,
                paused: Some(shown.paused),
                action_states: action_states(shown.actions),
                instant_action_states: Some(action_states(shown.instant)),
                ..State::default()
            },
        );
    }

    /// Adds a message with the next header of its topic.
    pub fn send<M: Message>(&mut self, time: f64, mut message: M) {
        message.adapt(self.version);
        let json = encode(&message, self.version);
        let mut content: Value = serde_json::from_slice(&json).expect("JSON");
        let place = Topic::ALL.iter().position(|topic| *topic == M::TOPIC).expect("a topic");
        content["headerId"] = self.header_ids[place].into();
        content["timestamp"] = clock::text(START + time).into();
        content["version"] = self.version.number().into();
        content["manufacturer"] = "KIT".into();
        content["serialNumber"] = self.serial.into();
        self.header_ids[place] += 1;
        let is_kept = matches!(M::TOPIC, Topic::Connection | Topic::Factsheet);
        let quality = u8::from(M::TOPIC == Topic::Connection);
        self.messages.push(Sent {
            time: START + time,
            topic: format!("{}/{}", self.prefix(), M::TOPIC.name()),
            content,
            bytes: None,
            delivery: Some(Delivery { quality, retained: is_kept }),
        });
    }

    fn prefix(&self) -> String {
        let (interface, level) = (self.version.interface(), self.version.level());
        format!("{interface}/{level}/KIT/{}", self.serial)
    }

    /// A message of a topic, counted from 0.
    pub fn sent(&mut self, topic: &str, number: usize) -> &mut Sent {
        let mut of_topic =
            self.messages.iter_mut().filter(|sent| sent.topic.rsplit('/').next() == Some(topic));
        of_topic.nth(number).expect("a message")
    }

    /// The content of a message of a topic, counted from 0.
    pub fn at(&mut self, topic: &str, number: usize) -> &mut Value {
        &mut self.sent(topic, number).content
    }

    /// Leaves out a message of a topic, and counts the others without a gap.
    pub fn remove(&mut self, topic: &str, number: usize) {
        let mut seen = 0;
        self.messages.retain(|sent| {
            let is_of_topic = sent.topic.rsplit('/').next() == Some(topic);
            seen += usize::from(is_of_topic);
            !is_of_topic || seen != number + 1
        });
        let of_topic =
            self.messages.iter_mut().filter(|sent| sent.topic.rsplit('/').next() == Some(topic));
        for (number, sent) in of_topic.enumerate() {
            sent.content["headerId"] = number.into();
        }
    }

    /// Changes all messages from a time on.
    pub fn cut(&mut self, time: f64) {
        self.messages.retain(|sent| sent.time - START < time);
        for (place, topic) in Topic::ALL.iter().enumerate() {
            let count = self
                .messages
                .iter()
                .filter(|sent| sent.topic.rsplit('/').next() == Some(topic.name()))
                .count();
            self.header_ids[place] = count as u32;
        }
    }

    /// Judges the conversation, and lets some seconds pass after it.
    pub fn judged(&self, seconds: f64) -> Vec<Finding> {
        judged(&[self], seconds)
    }
}

/// Judges conversations side by side.
pub fn judged(talks: &[&Conversation], seconds: f64) -> Vec<Finding> {
    let mut messages: Vec<_> = talks.iter().flat_map(|talk| &talk.messages).collect();
    messages.sort_by(|one, other| one.time.total_cmp(&other.time));
    let mut judge = Judge::new(Protocol::Auto);
    let mut findings = Vec::new();
    for sent in &messages {
        let json = sent.bytes.clone().unwrap_or_else(|| sent.content.to_string().into_bytes());
        findings.extend(judge.take(&Seen {
            time: Some(sent.time),
            topic: &sent.topic,
            payload: &json,
            delivery: sent.delivery,
        }));
    }
    let end = messages.last().map_or(0.0, |sent| sent.time) + seconds;
    findings.extend(judge.pass(end));
    findings
}

fn position(x: f64) -> Position {
    Position { x, map_id: "m".to_owned(), localized: true, ..Position::default() }
}

fn action_states(shown: &[(&str, ActionStatus)]) -> Vec<ActionState> {
    let states = shown.iter().map(|(id, status)| ActionState {
        action_id: (*id).to_owned(),
        action_type: None,
        action_descriptor: None,
        action_status: *status,
        action_result: None,
    });
    states.collect()
}
