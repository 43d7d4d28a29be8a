//! Actions and their blocking types (2.x: 6.8; 3.0: 6.2), pauses, loads and charging.

use super::*;

#[test]
fn a_vehicle_stops_for_soft_and_hard_actions_only() {
    for (blocking, legs) in [
        ("NONE", vec![1, 3, 5]),
        ("SINGLE", vec![1, 3, 5]),
        ("SOFT", vec![1, -3, -5]),
        ("HARD", vec![1, -3, -5]),
    ] {
        let mut trial = Trial::new(Version::V3_0);
        trial.order(&order("o", 0, 0, &format!("A B:x,pick,{blocking} C D")));
        assert_eq!(trial.last_legs(), legs, "{blocking}");
        trial.reach("B");
        assert_eq!(trial.status("x"), "Running");
        if legs.contains(&-3) {
            trial.wait(9.0);
            assert_eq!(trial.last_legs(), legs, "it runs");
            trial.wait(1.5);
            assert_eq!((trial.status("x").as_str(), trial.last_legs()), ("Finished", vec![3, 5]));
        }
    }
}

#[test]
fn actions_run_beside_each_other_as_their_blocking_types_let_them() {
    let running = |blocking: &str| {
        let mut trial = Trial::new(Version::V3_0);
        let kinds = blocking
            .split(' ')
            .zip('a'..)
            .map(|(blocking, id)| format!("{id},detectObject,{blocking}"));
        let kinds: Vec<_> = kinds.collect();
        trial.order(&order("o", 0, 0, &format!("A:{} B", kinds.join(";"))));
        let mut rounds = Vec::new();
        while trial.state().action_states.iter().any(|state| !state.action_status.is_over()) {
            let states = trial.state().action_states;
            let running =
                states.iter().filter(|state| format!("{:?}", state.action_status) == "Running");
            rounds.push(running.map(|state| state.action_id.clone()).collect::<String>());
            trial.wait(2.0);
        }
        rounds.join(" ")
    };
    for (blocking, rounds) in [
        ("NONE NONE SOFT", "abc"),
        ("NONE HARD NONE", "a b c"),
        ("NONE SINGLE SOFT NONE", "a b cd"),
        ("HARD HARD", "a b"),
        ("SOFT NONE HARD SINGLE", "ab c d"),
    ] {
        assert_eq!(running(blocking), rounds, "{blocking}");
    }
}

#[test]
fn an_action_of_an_edge_ends_with_it() {
    let mut trial = Trial::new(Version::V2_0);
    let mut along = order("o", 0, 0, "A B C");
    along["edges"][0]["actions"] = actions("x,detectObject,NONE");
    along["edges"][1]["actions"] = actions("y,detectObject,SOFT");
    along["edges"][0]["actions"][0]["actionType"] = json!("pick");
    trial.order(&along);
    assert_eq!(trial.status("x"), "Running", "the edge is entered when the vehicle may drive");
    assert_eq!((trial.status("y").as_str(), trial.last_legs()), ("Waiting", vec![1, -3]));
    trial.reach("B");
    assert_eq!((trial.status("x").as_str(), trial.status("y").as_str()), ("Finished", "Running"));
    trial.wait(2.0);
    assert_eq!((trial.status("y").as_str(), trial.last_legs()), ("Finished", vec![3]));
}

#[test]
fn a_failed_action_may_be_tried_again_in_3_0() {
    for (version, status) in [(Version::V2_1, "Failed"), (Version::V3_0, "Retriable")] {
        let mut trial = Trial::new(version);
        let mut empty = order("o", 0, 0, "A:x,drop,HARD B");
        empty["nodes"][0]["actions"][0]["retriable"] = json!(true);
        trial.order(&empty);
        trial.wait(10.0);
        assert_eq!(trial.status("x"), status);
        assert_eq!(trial.errors().len(), 1);
        if version == Version::V3_0 {
            let aim = json!([{"key": "actionId", "value": "x"}]);
            trial.instant("r", "retry", aim.clone());
            assert_eq!(
                (trial.status("r").as_str(), trial.status("x").as_str()),
                ("Finished", "Running")
            );
            trial.wait(10.0);
            trial.instant("s", "skipRetry", aim.clone());
            assert_eq!((trial.status("x").as_str(), trial.last_legs()), ("Failed", vec![1]));
            trial.instant("t", "retry", aim);
            assert_eq!(trial.status("t"), "Failed");
        }
    }
}

#[test]
fn loads_are_picked_and_dropped() {
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A:p,pick,HARD;q,pick,HARD;d,drop,HARD;e,drop,HARD"));
    let mut loads = Vec::new();
    for _ in 0..4 {
        trial.wait(10.0);
        loads.push(trial.state().loads.map_or(0, |loads| loads.len()));
    }
    assert_eq!(loads, [1, 1, 0, 0]);
    let statuses = ["p", "q", "d", "e"].map(|id| trial.status(id));
    assert_eq!(statuses, ["Finished", "Failed", "Finished", "Failed"]);
}

#[test]
fn a_pause_holds_the_vehicle_and_its_actions() {
    let mut trial = Trial::new(Version::V3_0);
    trial.order(&order("o", 0, 0, "A:x,pick,NONE B"));
    trial.drive();
    trial.instant("pause", "startPause", json!([]));
    assert_eq!(trial.commands.last(), Some(&Command::Hold));
    assert_eq!((trial.status("pause").as_str(), trial.status("x").as_str()), ("Running", "Paused"));
    trial.see(0.4, RobotState::Held);
    let state = trial.state();
    assert_eq!((state.driving, state.paused), (true, Some(false)), "it brakes");
    trial.time += 60.0;
    trial.see(0.0, RobotState::Held);
    assert_eq!((trial.status("pause").as_str(), trial.state().paused), ("Finished", Some(true)));
    assert_eq!(trial.status("x"), "Paused");
    trial.instant("go", "stopPause", json!([]));
    assert_eq!(trial.commands.last(), Some(&Command::Resume));
    let state = trial.state();
    assert_eq!((trial.status("go").as_str(), state.paused), ("Finished", Some(false)));
    trial.see(0.0, RobotState::Held);
    assert_eq!(trial.state().paused, Some(false), "the engine hasn't resumed it yet");
    trial.drive();
    assert_eq!((trial.status("x").as_str(), trial.state().paused), ("Running", Some(false)));
}

#[test]
fn a_trigger_ends_waiting() {
    let mut trial = Trial::new(Version::V3_0);
    trial.order(&order("o", 0, 0, "A:x,waitForTrigger,HARD B"));
    trial.wait(1000.0);
    assert_eq!(trial.status("x"), "Running");
    trial.instant("t", "trigger", json!([]));
    assert_eq!((trial.status("x").as_str(), trial.last_legs()), ("Finished", vec![1]));
}

#[test]
fn vehicles_charge_at_chargers_only() {
    let mut trial = Trial::new(Version::V2_1);
    trial.instant("c", "startCharging", json!([]));
    trial.wait(1.0);
    assert_eq!((trial.status("c").as_str(), trial.errors().len()), ("Failed", 1));
    trial.order(&order("o", 0, 0, "A B C D:d,startCharging,HARD"));
    ["B", "C"].into_iter().for_each(|node| trial.pass(node));
    trial.reach("D");
    trial.wait(1.0);
    assert!(trial.state().power_supply.charging);
    trial.instant("e", "stopCharging", json!([]));
    trial.wait(1.0);
    assert!(!trial.state().power_supply.charging);
}

#[test]
fn instant_actions_are_answered_and_repeated_ones_are_not_carried_out_again() {
    let mut trial = Trial::new(Version::V3_0);
    trial.instant("f", "factsheetRequest", json!([]));
    trial.instant("x", "fly", json!([]));
    assert_eq!((trial.status("f").as_str(), trial.status("x").as_str()), ("Finished", "Failed"));
    assert_eq!(trial.errors(), [("INVALID_INSTANT_ACTION".to_owned(), "Warning".to_owned())]);
    trial.instant("x", "startPause", json!([]));
    assert_eq!((trial.commands.len(), trial.errors().len()), (0, 1), "the id is known");
    trial.instant("clear", "clearInstantActions", json!([]));
    assert_eq!((trial.status("x").as_str(), trial.errors().len()), ("none", 0));
}

#[test]
fn a_vehicle_knows_where_it_is() {
    for (x, node, status) in [(0.2, "A", "Finished"), (0.0, "B", "Failed"), (9.0, "A", "Failed")] {
        let mut trial = Trial::new(Version::V2_0);
        let place = json!([{"key": "x", "value": x}, {"key": "y", "value": 0},
            {"key": "lastNodeId", "value": node}]);
        trial.instant("i", "initPosition", place);
        trial.wait(0.1);
        assert_eq!(trial.status("i"), status, "{x} {node}");
    }
}
