//! Tests of the meter with a made-up conversation.

use serde_json::{Value, json};

use super::*;

/// A conversation of vehicles with their master.
struct Talk(Meter);

impl Talk {
    fn new() -> Self {
        Self(Meter::default())
    }

    fn say(&mut self, vehicle: &str, topic: &str, message: &Value, time: f64) {
        let topic = format!("uagv/v2/t/{vehicle}/{topic}");
        self.0.take(&topic, message.to_string().as_bytes(), time);
    }

    /// An order along nodes, of which the first ones are the base.
    fn order(&mut self, vehicle: &str, update: u32, first: u32, nodes: &[&str], base: usize) {
        self.order_at(vehicle, update, first, nodes, base, 0.0);
    }

    fn order_at(
        &mut self,
        vehicle: &str,
        update: u32,
        first: u32,
        nodes: &[&str],
        base: usize,
        time: f64,
    ) {
        let places = (first..).step_by(2);
        let list = nodes.iter().zip(places).enumerate().map(|(index, (id, place))| {
            let kind = if id.starts_with('P') { "pick" } else { "drop" };
            let is_stop = id.starts_with(['P', 'D']);
            let action = json!({"actionId": format!("{vehicle}{place}"), "actionType": kind,
                "blockingType": "HARD"});
            let actions = if is_stop { json!([action]) } else { json!([]) };
            json!({"nodeId": id, "sequenceId": place, "released": index < base,
                "actions": actions})
        });
        let edges = nodes.windows(2).zip((first + 1..).step_by(2)).enumerate();
        let edges = edges.map(|(index, (ends, place))| {
            json!({"edgeId": ends.join("-"), "sequenceId": place, "released": index + 1 < base,
                "actions": []})
        });
        let order = json!({"orderId": format!("o-{vehicle}"), "orderUpdateId": update,
            "nodes": list.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>()});
        self.say(vehicle, "order", &order, time);
    }

    /// A state at a node; the fields of `more` replace others.
    fn state(
        &mut self,
        vehicle: &str,
        update: u32,
        node: &str,
        place: u32,
        more: Value,
        time: f64,
    ) {
        let mut state = json!({"orderId": format!("o-{vehicle}"), "orderUpdateId": update,
            "lastNodeId": node, "lastNodeSequenceId": place, "nodeStates": [{"nodeId": "x",
            "sequenceId": 98, "released": false}], "edgeStates": [], "driving": false,
            "actionStates": [], "batteryState": {"batteryCharge": 100.0, "charging": false},
            "operatingMode": "AUTOMATIC", "errors": [],
            "safetyState": {"eStop": "NONE", "fieldViolation": false}});
        for (key, value) in more.as_object().into_iter().flatten() {
            state[key] = value.clone();
        }
        self.say(vehicle, "state", &state, time);
    }
}

#[test]
fn a_base_counts_from_the_state_that_asks_and_stands_from_its_end() {
    let mut talk = Talk::new();
    talk.order("a", 0, 0, &["A", "B", "C", "D"], 2);
    talk.state("a", 0, "A", 0, json!({"newBaseRequest": true}), 10.0);
    talk.state("a", 0, "B", 2, json!({}), 12.0);
    talk.order_at("a", 1, 2, &["B", "C", "D"], 2, 13.0);
    let figures = talk.0.end(20.0);
    let wait = &figures.bases[0];
    assert_eq!((figures.bases.len(), &*wait.node, wait.next_node.as_deref()), (1, "B", Some("C")));
    assert_eq!((wait.secs, wait.standing_secs, wait.answer), (3.0, 1.0, Answer::Free));
    assert_eq!(wait.edges, ["A-B", "B-C"].map(|edge| Some(edge.to_owned())));
    assert_eq!((figures.orders, figures.last_order), (2, Some(13.0)));
}

#[test]
fn a_base_that_others_were_in_is_one_of_traffic() {
    let mut talk = Talk::new();
    talk.order("b", 0, 0, &["C", "X"], 2);
    talk.state("b", 0, "C", 0, json!({}), 1.0);
    talk.order("a", 0, 0, &["A", "B", "C"], 2);
    talk.state("a", 0, "B", 2, json!({}), 10.0);
    // The other vehicle leaves the node for the next one.
    talk.state("b", 0, "X", 2, json!({}), 14.0);
    talk.order_at("a", 1, 2, &["B", "C"], 2, 15.0);
    talk.state("a", 1, "C", 4, json!({}), 16.0);
    let figures = talk.0.end(20.0);
    assert_eq!((figures.bases[0].secs, figures.bases[0].answer), (5.0, Answer::Held));
    assert_eq!(figures.bases.len(), 1, "{figures:?}");
}

#[test]
fn a_base_that_never_comes_counts_with_its_time_so_far() {
    let mut talk = Talk::new();
    talk.order("a", 0, 0, &["A", "B", "C"], 2);
    talk.state("a", 0, "B", 2, json!({}), 10.0);
    // An update that was lost on the way, or has only another horizon, is no answer.
    talk.order_at("a", 1, 2, &["B", "D"], 1, 11.0);
    let figures = talk.0.end(40.0);
    let wait = &figures.bases[0];
    assert_eq!((wait.secs, wait.answer), (30.0, Answer::MissingFree));
    assert_eq!(wait.next_node.as_deref(), Some("D"));
}

#[test]
fn the_work_at_the_end_of_a_base_is_no_waiting() {
    let mut talk = Talk::new();
    talk.order("a", 0, 0, &["A", "P", "D"], 2);
    let running = json!({"actionStates": [{"actionId": "a2", "actionStatus": "RUNNING"}]});
    let done = json!({"actionStates": [{"actionId": "a2", "actionStatus": "FINISHED"}]});
    talk.state("a", 0, "P", 2, running, 10.0);
    talk.state("a", 0, "P", 2, done, 18.0);
    talk.order_at("a", 1, 2, &["P", "D"], 2, 18.5);
    assert_eq!(talk.0.end(20.0).bases[0].secs, 0.5);
}

#[test]
fn transports_are_counted_from_pick_to_drop() {
    let mut talk = Talk(Meter::new([("P1".to_owned(), "goods in".to_owned())]));
    talk.0.hand_over(7, "goods in", "D", 3.0);
    talk.0.hand_over(8, "P1", "D", 4.0);
    talk.order("a", 0, 0, &["A", "P1", "D"], 3);
    let states = |pick: &str, drop: &str| {
        json!({"nodeStates": [], "actionStates": [{"actionId": "a2", "actionStatus": pick},
            {"actionId": "a4", "actionStatus": drop}]})
    };
    talk.state("a", 0, "D", 4, states("FINISHED", "RUNNING"), 20.0);
    talk.state("a", 0, "D", 4, states("FINISHED", "FINISHED"), 30.0);
    talk.state("a", 0, "D", 4, states("FINISHED", "FINISHED"), 31.0);
    let figures = talk.0.end(40.0);
    let finished = Finished { time: 30.0, number: Some(7), service_secs: Some(27.0) };
    assert_eq!((figures.finished, figures.open_orders), (vec![finished], 1));
}

#[test]
fn a_failed_pick_carries_nothing() {
    let mut talk = Talk::new();
    talk.order("a", 0, 0, &["A", "P", "D"], 3);
    let states = json!({"actionStates": [{"actionId": "a2", "actionStatus": "FAILED"},
        {"actionId": "a4", "actionStatus": "FINISHED"}]});
    talk.state("a", 0, "D", 4, states, 20.0);
    assert_eq!(talk.0.end(40.0).finished, []);
}

#[test]
fn vehicles_without_orders_and_their_errors_are_counted() {
    let mut talk = Talk::new();
    let error = json!({"errors": [{"errorType": "orderError", "errorLevel": "WARNING",
        "errorReferences": []}]});
    talk.state("a", 0, "A", 0, error.clone(), 1.0);
    talk.state("a", 0, "A", 0, error, 2.0);
    talk.order("b", 0, 0, &["B"], 1);
    talk.state("b", 0, "B", 0, json!({}), 2.0);
    assert_eq!(talk.0.placed_vehicles(), 2);
    let figures = talk.0.end(40.0);
    assert_eq!((figures.vehicles, figures.never_ordered), (2, 1));
    assert_eq!(figures.errors.get("orderError"), Some(&1));
}

#[test]
fn broken_messages_are_left_to_the_judge() {
    let mut meter = Meter::default();
    for (topic, payload) in [("order", "{"), ("uagv/v2/t/a/order", "[]"), ("a/state", "{}")] {
        meter.take(topic, payload.as_bytes(), 1.0);
    }
    assert_eq!(meter.end(2.0), Figures::default());
}
