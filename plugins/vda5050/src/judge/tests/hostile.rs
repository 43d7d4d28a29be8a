//! Messages of strangers: nothing makes the judge panic, and nothing makes it grow without end.

use proptest::prelude::*;
use serde_json::Value;

use super::conversation::{Conversation, IDLE, Shown, action, edge, node};
use crate::judge::traffic::Recording;
use crate::judge::{Judge, Protocol, Seen};
use crate::message::{ActionStatus, BlockingType, Version};

/// Replaces a value somewhere in a message.
fn mutate(value: &mut Value, path: &[usize], with: &Value) {
    let Some((step, rest)) = path.split_first() else {
        *value = with.clone();
        return;
    };
    match value {
        Value::Array(items) if !items.is_empty() => {
            let place = step % items.len();
            mutate(&mut items[place], rest, with);
        }
        Value::Object(fields) if !fields.is_empty() => {
            let place = step % fields.len();
            let field = fields.values_mut().nth(place).expect("a field");
            mutate(field, rest, with);
        }
        other => *other = with.clone(),
    }
}

fn values() -> impl Strategy<Value = Value> {
    let numbers = [0.0, -1.0, 1e308, -1e308, 4_294_967_295.0, 0.5, 1e19];
    prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        prop::sample::select(numbers.to_vec()).prop_map(Value::from),
        any::<u32>().prop_map(Value::from),
        "\\PC{0,8}".prop_map(Value::from),
        Just(Value::Array(vec![])),
        Just(serde_json::json!({})),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn mutations_of_correct_traffic_never_panic(
        version in prop::sample::select(Version::ALL.to_vec()),
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::collection::vec(any::<usize>(), 1..6), values()),
            1..12,
        ),
        swaps in prop::collection::vec(any::<[prop::sample::Index; 2]>(), 0..6),
    ) {
        let mut talk = Conversation::correct(version);
        for (message, path, value) in &changes {
            let count = talk.messages.len();
            mutate(&mut talk.messages[message.index(count)].content, path, value);
        }
        for [one, other] in swaps {
            let count = talk.messages.len();
            let times = [one, other].map(|at| talk.messages[at.index(count)].time);
            talk.messages[one.index(count)].time = times[1];
            talk.messages[other.index(count)].time = times[0];
        }
        for finding in talk.judged(100.0) {
            prop_assert!(!finding.to_string().is_empty());
        }
    }

    #[test]
    fn random_bytes_never_panic(
        topic in prop_oneof![Just("uagv/v2/KIT/1/order".to_owned()), "\\PC{0,40}"],
        payload in prop::collection::vec(any::<u8>(), 0..400),
        time in any::<Option<f64>>(),
    ) {
        let mut judge = Judge::new(Protocol::Auto);
        judge.take(&Seen { time, topic: &topic, payload: &payload, delivery: None });
        judge.pass(time.unwrap_or(f64::NAN));
        let mut recording = Recording::new(&payload[..]);
        while recording.read().expect("memory can be read").is_some() {}
    }
}

#[test]
fn actions_of_days_are_forgotten_but_not_those_of_the_order() {
    let mut talk = Conversation::correct(Version::V2_1);
    talk.cut(1.5);
    let template = talk.messages.clone();
    let mut order = template.iter().find(|sent| sent.topic.ends_with("order")).expect("it").clone();
    let (mut messages, mut number) = (template.clone(), 0_u32);
    for round in 1..60_u32 {
        let actions = (0..500).map(|_| {
            number += 1;
            serde_json::json!({"actionId": format!("i{number}"), "actionType": "stateRequest",
                "blockingType": "NONE", "actionParameters": []})
        });
        let actions: Vec<_> = actions.collect();
        order.topic = order.topic.replace("/order", "/instantActions");
        order.content = serde_json::json!({"headerId": round, "version": "2.1.0",
            "timestamp": "2023-11-14T22:13:21.300Z", "manufacturer": "KIT",
            "serialNumber": "0001", "actions": actions});
        messages.push(order.clone());
    }
    talk.messages = messages;
    assert_eq!(talk.judged(0.0), []);
}

#[test]
fn deep_and_large_messages_are_judged_in_time() {
    let start = std::time::Instant::now();
    let mut judge = Judge::new(Protocol::Auto);
    let topic = "uagv/v2/KIT/1/order";
    let deep = "[".repeat(4 << 20);
    let nodes = vec!["{}"; 200_000].join(",");
    let wide = format!("{{\"nodes\":[{nodes}],\"edges\":[{nodes}],\"orderId\":\"o\"}}");
    for payload in [deep, wide] {
        let findings =
            judge.take(&Seen { time: None, topic, payload: payload.as_bytes(), delivery: None });
        assert!((1..=20).contains(&findings.len()), "{}", findings.len());
    }
    let mut talk = Conversation::empty(Version::V2_1, "0001");
    let (mut nodes, mut edges, mut shown) = (Vec::new(), Vec::new(), Vec::new());
    let ids: Vec<_> = (0..10_000).map(|number| format!("a{number}")).collect();
    for (number, id) in (0..).zip(&ids) {
        nodes.push(node(&format!("n{}", number % 2), 2 * number, true));
        nodes.last_mut().expect("it").actions.push(action(id, "beep", BlockingType::None));
        edges.push(edge(2 * number + 1, true));
        shown.push((id.as_str(), ActionStatus::Waiting));
    }
    edges.pop();
    talk.arrive(0.0);
    talk.order(1.0, ("o", 0), &nodes, &edges);
    for tenths in 11..20 {
        let last = ("n1", 19_998);
        let state = Shown { order: ("o", 0), last, x: 4.0, actions: &shown, ..IDLE };
        talk.state(f64::from(tenths) / 10.0, &state);
    }
    assert_eq!(talk.judged(0.0), []);
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}
