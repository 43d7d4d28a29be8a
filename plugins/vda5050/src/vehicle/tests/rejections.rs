//! Rejections with the error types, levels and references of the standard (2.x: 6.6.4, 6.6.3.2;
//! 3.0: 6.1.4, 6.6.5.4).

use super::*;

/// Changes an order.
type Change = fn(&mut Value);

#[test]
fn orders_that_cannot_be_taken_are_rejected_with_the_error_of_the_version() {
    let changes: [(&str, Change, [&str; 2], [&str; 2]); 14] = [
        ("no nodes", |it| it["nodes"] = json!([]), MALFORMED, WARNING),
        ("too few edges", |it| it["edges"] = json!([]), MALFORMED, WARNING),
        ("first not released", |it| it["nodes"][0]["released"] = json!(false), MALFORMED, WARNING),
        ("gap", |it| it["nodes"][1]["sequenceId"] = json!(4), MALFORMED, WARNING),
        ("released after", |it| it["edges"][0]["released"] = json!(false), MALFORMED, WARNING),
        ("other end", |it| it["edges"][0]["endNodeId"] = json!("C"), MALFORMED, WARNING),
        (
            "an id twice",
            |it| it["nodes"][1]["actions"] = actions("x,pick,HARD;x,drop,HARD"),
            MALFORMED,
            WARNING,
        ),
        (
            "an action that it can't",
            |it| it["nodes"][1]["actions"] = actions("x,fly,HARD"),
            ["orderError", "INVALID_ORDER_ACTION"],
            WARNING,
        ),
        (
            "a path of its own",
            |it| {
                it["edges"][0]["trajectory"] = json!({"degree": 1, "knotVector": [0, 0, 1, 1],
                "controlPoints": [{"x": 0, "y": 0}, {"x": 1, "y": 1}]})
            },
            ["orderError", "UNSUPPORTED_PARAMETER"],
            ["Warning", "Critical"],
        ),
        (
            "slower",
            |it| it["edges"][0]["maxSpeed"] = json!(0.5),
            ["orderError", "UNSUPPORTED_PARAMETER"],
            ["Warning", "Critical"],
        ),
        (
            "sideways",
            |it| it["edges"][0]["orientation"] = json!(1.5),
            ["orderError", "UNSUPPORTED_PARAMETER"],
            ["Warning", "Critical"],
        ),
        ("elsewhere", |it| it["nodes"][0]["nodeId"] = json!("B"), START, WARNING),
        ("unknown edge", |it| it["edges"][0]["edgeId"] = json!("XY"), NO_ROUTE, WARNING),
        (
            "unknown map",
            |it| it["nodes"][1]["nodePosition"] = json!({"x": 0, "y": 0, "mapId": "moon"}),
            ["orderError", "UNKNOWN_MAP_ID"],
            WARNING,
        ),
    ];
    for (name, change, types, levels) in changes {
        for (version, kind, level) in
            [(Version::V2_1, types[0], levels[0]), (Version::V3_0, types[1], levels[1])]
        {
            let mut trial = Trial::new(version);
            let mut wrong = order("o", 0, 0, "A B");
            change(&mut wrong);
            trial.order(&wrong);
            assert_eq!(trial.errors(), [(kind.to_owned(), level.to_owned())], "{name}");
            let references = &trial.state().errors[0].error_references;
            assert!(references.contains(&crate::message::Reference::new("orderId", "o")), "{name}");
            assert_eq!((trial.state().order_id.as_str(), trial.commands.len()), ("", 0), "{name}");
            // The error is reported until an order is accepted.
            trial.stand();
            assert_eq!(trial.errors().len(), 1, "{name}");
            trial.order(&order("right", 0, 0, "A B"));
            assert_eq!(trial.errors(), [], "{name}");
        }
    }
}

const MALFORMED: [&str; 2] = ["validationError", "VALIDATION_FAILURE"];
const START: [&str; 2] = ["noRouteError", "START_NODE_OUT_OF_RANGE"];
const NO_ROUTE: [&str; 2] = ["noRouteError", "NO_ROUTE_TO_TARGET"];
const WARNING: [&str; 2] = ["Warning", "Warning"];

#[test]
fn updates_that_do_not_fit_leave_the_order_as_it_is() {
    let updates = [
        (order("o", 0, 0, "A B C"), ["orderUpdateError", "OUTDATED_ORDER_UPDATE"]),
        (order("o", 2, 0, "A B C"), ["orderUpdateError", "INVALID_ORDER"]),
        (order("o", 2, 4, "B A"), ["orderUpdateError", "INVALID_ORDER"]),
        (order("other", 0, 0, "A B"), ["orderError", "OTHER_ORDER_ACTIVE"]),
    ];
    for (update, types) in updates {
        for (version, kind) in [(Version::V2_0, types[0]), (Version::V3_0, types[1])] {
            let mut trial = Trial::new(version);
            trial.order(&order("o", 0, 0, "A B | C")).order(&order("o", 1, 2, "B C"));
            let before = (trial.ahead(), trial.commands.len());
            trial.order(&update);
            assert_eq!(trial.errors(), [(kind.to_owned(), "Warning".to_owned())], "{update}");
            assert_eq!((trial.ahead(), trial.commands.len()), before);
            assert_eq!(trial.state().order_update_id, 1);
        }
    }
}

#[test]
fn an_order_that_comes_twice_is_ignored_and_in_3_0_one_with_other_content_rejected() {
    for version in Version::ALL {
        let mut trial = Trial::new(version);
        trial.order(&order("o", 0, 0, "A B")).order(&order("o", 0, 0, "A B"));
        assert_eq!(trial.errors(), []);
        trial.order(&order("o", 0, 0, "A B | C"));
        let is_told = version == Version::V3_0;
        assert_eq!(trial.errors().len(), usize::from(is_told), "{version}");
        assert_eq!(trial.ahead(), "B");
    }
}

#[test]
fn in_3_0_a_new_order_begins_with_the_update_0() {
    for (version, errors) in [(Version::V2_1, 0), (Version::V3_0, 1)] {
        let mut trial = Trial::new(version);
        trial.order(&order("o", 3, 0, "A B"));
        assert_eq!(trial.errors().len(), errors, "{version}");
    }
}

#[test]
fn a_broken_message_is_an_error_about_what_can_be_read_of_it() {
    let mut trial = Trial::new(Version::V2_0);
    let error = decode::<Order>(br#"{"orderId":"o","orderUpdateId":4}"#).expect_err("no nodes");
    trial.vehicle.take_broken("order", &error);
    let state = trial.state();
    assert_eq!(state.errors[0].error_type, "validationError");
    let keys = state.errors[0].error_references.iter().map(|it| it.reference_value.as_str());
    assert_eq!(keys.collect::<Vec<_>>(), ["order", "o", "4"]);
}

#[test]
fn a_flood_of_errors_is_bounded() {
    let mut trial = Trial::new(Version::V3_0);
    for id in 0..1000 {
        trial.order(&order(&id.to_string(), 0, 0, "B C"));
        trial.instant(&id.to_string(), "fly", json!([]));
    }
    assert_eq!(trial.errors().len(), MOST_FAULTS);
    assert_eq!(trial.state().instant_action_states.map(|states| states.len()), Some(100));
}

#[test]
fn a_broken_vehicle_takes_no_orders() {
    let mut trial = Trial::new(Version::V3_0);
    trial.see(0.0, RobotState::Broken);
    trial.order(&order("o", 0, 0, "A B"));
    let types: Vec<_> = trial.errors().into_iter().map(|error| error.0).collect();
    assert_eq!(types, ["BREAKDOWN", "MOBILE_ROBOT_NOT_AVAILABLE"]);
    trial.stand();
    assert_eq!(trial.errors(), []);
}
