//! Cancelled orders (2.x: 6.6.3; 3.0: 6.1.3).

use super::*;

#[test]
fn a_cancelled_vehicle_drives_to_the_next_node_and_takes_another_order() {
    for version in Version::ALL {
        let mut trial = Trial::new(version);
        trial.order(&order("o", 0, 0, "A B:x,pick,HARD C | D"));
        trial.drive();
        trial.instant("c", "cancelOrder", json!([]));
        assert_eq!(trial.commands.last(), Some(&Command::Cancel));
        assert_eq!((trial.ahead().as_str(), trial.status("x").as_str()), ("B", "Failed"));
        trial.stand();
        assert_eq!(trial.status("c"), "Running", "the engine hasn't answered");
        trial.vehicle.cancelled();
        trial.reach("B");
        let state = trial.state();
        assert_eq!((trial.status("c").as_str(), state.last_node_id.as_str()), ("Finished", "B"));
        assert_eq!((state.order_id.as_str(), trial.ahead().as_str()), ("o", ""));
        trial.order(&order("o", 1, 4, "C D"));
        let error = match version {
            Version::V3_0 => "ORDER_UPDATE_FOLLOWING_CANCEL",
            _ => "orderUpdateError",
        };
        assert_eq!(trial.errors()[0].0, error);
        trial.order(&order("next", 0, 0, "B C"));
        assert_eq!((trial.errors(), trial.last_legs()), (vec![], vec![3]));
    }
}

#[test]
fn an_action_that_cannot_be_cancelled_is_finished_first() {
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A:x,pick,HARD;y,detectObject,HARD B"));
    trial.instant("c", "cancelOrder", json!([]));
    trial.stand();
    let statuses = ["c", "x", "y"].map(|id| trial.status(id));
    assert_eq!(statuses, ["Running", "Running", "Failed"]);
    assert!(!trial.commands.contains(&Command::Cancel), "it hasn't begun to drive");
    trial.wait(10.0);
    let statuses = ["c", "x", "y"].map(|id| trial.status(id));
    assert_eq!(statuses, ["Finished", "Finished", "Failed"]);
    assert!(trial.vehicle.is_idle());
}

#[test]
fn a_cancel_without_an_order_fails() {
    let mut trial = Trial::new(Version::V3_0);
    trial.instant("c", "cancelOrder", json!([]));
    assert_eq!(trial.status("c"), "Failed");
    let error = &trial.state().errors[0];
    assert_eq!(error.error_type, "NO_ORDER_TO_CANCEL");
    assert_eq!(error.error_references, [crate::message::Reference::new("actionId", "c")]);
    trial.order(&order("o", 0, 0, "A B"));
    trial.instant("d", "cancelOrder", json!([{"key": "orderId", "value": "other"}]));
    assert_eq!((trial.status("d").as_str(), trial.ahead().as_str()), ("Failed", "B"));
}

#[test]
fn two_cancels_end_together() {
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A B"));
    trial.drive();
    trial.instant("c", "cancelOrder", json!([])).instant("d", "cancelOrder", json!([]));
    trial.vehicle.cancelled();
    trial.reach("B");
    assert_eq!(["c", "d"].map(|id| trial.status(id)), ["Finished", "Finished"]);
}
