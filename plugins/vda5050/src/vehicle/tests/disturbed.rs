//! Vehicles that are disturbed (2.x: 6.10.6; 3.0: 6.6.7).

use super::*;
use crate::disturb::{Disturbance, Kind, Strike};
use crate::message::{EmergencyStop, OperatingMode};

impl Trial {
    fn disturbed(version: Version, disturbance: &str) -> Self {
        let list: Vec<Disturbance> = vec![disturbance.parse().expect("a disturbance")];
        let mut trial = Self::new(version);
        trial.vehicle.fate = Fate::new(&Disturbances::new(&list, 1), 0);
        trial
    }

    /// A disturbance of 30 s begins.
    fn strike(&mut self, kind: Kind) {
        self.vehicle.be_struck(Strike { kind, secs: 30.0 }, self.time);
        self.commands.extend(self.vehicle.take_outbox().commands);
    }
}

#[test]
fn an_operator_clears_the_order_and_gives_the_vehicle_back_at_a_node() {
    for version in Version::ALL {
        let mut trial = Trial::new(version);
        trial.order(&order("o", 0, 0, "A B:x,pick,HARD C | D"));
        trial.drive();
        trial.strike(Kind::ManualMode);
        let state = trial.state();
        assert_eq!(state.operating_mode, OperatingMode::Manual);
        assert_eq!((trial.ahead().as_str(), trial.status("x").as_str()), ("", "Failed"));
        assert_eq!(trial.commands.last(), Some(&Command::Cancel));
        trial.time += 40.0;
        trial.drive();
        assert_eq!(trial.state().operating_mode, OperatingMode::Manual, "it is on an edge");
        trial.order(&order("next", 0, 0, "A B"));
        assert!(trial.errors()[0].0.contains(if version == Version::V3_0 {
            "NOT_AVAILABLE"
        } else {
            "orderError"
        }));
        trial.x = 10.0;
        trial.stand();
        trial.wait(1.0);
        let state = trial.state();
        assert_eq!(state.operating_mode, OperatingMode::Automatic);
        assert_eq!(state.last_node_id, "B");
        trial.order(&order("next", 0, 0, "B C"));
        assert_eq!((trial.errors(), trial.last_legs()), (vec![], vec![3]));
    }
}

#[test]
fn a_stopped_vehicle_goes_on_by_itself_unless_its_master_pauses_it() {
    for pauses in [false, true] {
        let mut trial = Trial::new(Version::V2_1);
        trial.order(&order("o", 0, 0, "A B C"));
        trial.drive();
        trial.strike(Kind::EmergencyStops);
        assert_eq!(trial.commands.last(), Some(&Command::Hold));
        let stop = trial.state().safety_state.active_emergency_stop;
        assert_eq!(stop, EmergencyStop::AutoAcknowledged);
        trial.instant("s", "stopPause", json!([]));
        assert_eq!(trial.commands.last(), Some(&Command::Hold), "a master can't let it go on");
        if pauses {
            trial.instant("p", "startPause", json!([]));
        }
        trial.wait(31.0);
        assert_eq!(trial.state().safety_state.active_emergency_stop, EmergencyStop::None);
        let goes_on = trial.commands.last() == Some(&Command::Resume);
        assert_eq!((goes_on, trial.ahead().as_str()), (!pauses, "B C"));
    }
}

#[test]
fn a_vehicle_that_is_lost_stands_says_so_and_takes_no_new_order() {
    for version in Version::ALL {
        let mut trial = Trial::new(version);
        trial.strike(Kind::LostPositions);
        let is_localized =
            |trial: &Trial| trial.state().mobile_robot_position.is_some_and(|it| it.localized);
        assert!(!is_localized(&trial));
        assert!(trial.errors()[0].0.to_lowercase().starts_with("localization"));
        trial.order(&order("o", 0, 0, "A B"));
        assert_eq!(trial.last_legs(), [0; 0]);
        trial.wait(31.0);
        assert!(is_localized(&trial));
        trial.order(&order("p", 0, 0, "A B"));
        assert_eq!((trial.errors(), trial.last_legs()), (vec![], vec![1]));
    }
}

#[test]
fn actions_fail_and_orders_are_refused_as_often_as_wanted() {
    let mut trial = Trial::disturbed(Version::V2_0, "failed-actions=100%");
    trial.order(&order("o", 0, 0, "A:x,pick,HARD B"));
    trial.wait(11.0);
    assert_eq!(trial.status("x"), "Failed");
    assert_eq!(trial.state().loads, Some(vec![]), "nothing was picked");
    assert_eq!(trial.last_legs(), [1], "the order goes on");

    let mut trial = Trial::disturbed(Version::V2_0, "refused-orders=100%");
    trial.order(&order("o", 0, 0, "A B"));
    assert_eq!((trial.errors().len(), trial.ahead().as_str()), (1, ""));
}

#[test]
fn a_lost_connection_is_wanted_of_the_client() {
    let mut trial = Trial::new(Version::V2_0);
    let strike = Strike { kind: Kind::LostConnections, secs: 12.0 };
    trial.vehicle.be_struck(strike, 0.0);
    assert_eq!(trial.vehicle.take_outbox().silence_secs, Some(12.0));
    assert_eq!(trial.vehicle.take_outbox().silence_secs, None);
}
