//! The thread that asks the fleet manager about transport orders, through its web API: for the one
//! of the selected robot, which may have begun before this window opened, and for the robot with an
//! order of a name.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use regatta_interface::orders::{NamedOrder, RobotOrder, Stop};
use regatta_orders::{Client, ClientError};
use regatta_plugin::order::StopAction;
use regatta_plugin::{FleetName, Result};
use serde_json::Value;

use super::{Fact, Report};

/// The time between two requests for the order of the selected robot.
const ASK_EVERY: Duration = Duration::from_secs(2);

/// A query for orders.
#[derive(Debug)]
pub enum OrderQuery {
    /// The order of a robot, from now on; none without one.
    OfRobot(Option<u32>),
    /// The robot that carries out the order of this name.
    Named(String),
}

/// Asks until the link is dropped.
pub fn run(fleet: &FleetName, queried: &Receiver<OrderQuery>, report: &Sender<Report>) -> Result {
    // Without a directory for sockets, no manager can be asked.
    let client = Client::of_fleet(fleet).ok();
    let mut robot = None;
    loop {
        match queried.recv_timeout(ASK_EVERY) {
            Ok(OrderQuery::OfRobot(wanted)) => robot = wanted,
            Ok(OrderQuery::Named(name)) => {
                if report.send(with_order(client.as_ref(), &name)).is_err() {
                    return Ok(());
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        if let (Some(robot), Some(client)) = (robot, &client) {
            let found = Fact::NamedOrder(of_robot(client, robot));
            if report.send(found.into()).is_err() {
                return Ok(());
            }
        }
    }
}

/// Asks for the order of a robot; `None` if it has none, or if no manager answers.
fn of_robot(client: &Client, robot: u32) -> Option<NamedOrder> {
    let vehicle = client.get(&format!("/v1/vehicles/{robot}")).ok()?;
    let name = vehicle["transportOrder"].as_str()?;
    read(robot, &client.get(&Client::order_path(name)).ok()?)
}

/// Asks for the robot with the order of a name.
fn with_order(client: Option<&Client>, name: &str) -> Report {
    let answer = client.map(|client| client.get(&Client::order_path(name)));
    match answer {
        Some(Ok(order)) => holder(name, &order),
        Some(Err(ClientError::Refused { .. })) => {
            Report::Notice(format!("there is no robot, place or order '{name}'"))
        }
        _ => Report::Notice(format!("there is no robot or place '{name}'")),
    }
}

/// Returns the robot that carries out an order, or the state of an order of no robot.
fn holder(name: &str, order: &Value) -> Report {
    let robot = order["processingVehicle"].as_str().and_then(|robot| robot.parse().ok());
    let state = order["state"].as_str().unwrap_or("unknown");
    match (robot, state) {
        (_, "finished" | "failed" | "cancelled") | (None, _) => {
            Report::Notice(format!("order '{name}' is {state}: no robot has it now"))
        }
        (Some(robot), _) => Report::Holder(robot),
    }
}

/// Reads a robot's order from an answer of the web API.
fn read(robot: u32, order: &Value) -> Option<NamedOrder> {
    let name = order["name"].as_str()?.to_owned();
    let stops = order["destinations"].as_array()?;
    let index = stops.iter().position(|stop| stop["state"] != "finished");
    let next = index.and_then(|index| stops.get(index));
    let order = RobotOrder {
        number: 0,
        stop: index.map_or([0; 2], |index| [index as u32 + 1, stops.len() as u32]),
        next: next.and_then(stop_of),
        is_handling: next.is_some_and(|stop| stop["state"] == "handling"),
    };
    Some(NamedOrder { robot, name, order })
}

fn stop_of(stop: &Value) -> Option<Stop> {
    let node = u32::try_from(stop["node"].as_u64()?).ok()?;
    let action = match stop["operation"].as_str() {
        Some("pick") => StopAction::Pick,
        Some("drop") => StopAction::Drop,
        Some("charge") => StopAction::Charge,
        Some("park") => StopAction::Park,
        _ => StopAction::None,
    };
    Some(Stop { node, action })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn an_order_that_began_before_is_read_with_its_next_stop() {
        let answer = json!({
            "name": "load:1-1",
            "state": "travelling",
            "processingVehicle": "7",
            "destinations": [
                {"node": 30, "operation": "pick", "state": "finished"},
                {"node": 40, "operation": "drop", "state": "travelling"},
            ],
        });
        let found = read(7, &answer).expect("an order");
        assert_eq!((found.robot, found.name.as_str()), (7, "load:1-1"));
        let next = Some(Stop { node: 40, action: StopAction::Drop });
        let order = RobotOrder { number: 0, stop: [2, 2], next, is_handling: false };
        assert_eq!(found.order, order);
        assert!(matches!(holder("load:1-1", &answer), Report::Holder(7)));
        assert_eq!(read(7, &json!({"error": "?"})), None);
    }

    #[test]
    fn an_order_of_no_robot_tells_its_state() {
        for (order, text) in [
            (json!({"state": "finished", "processingVehicle": "7"}), "is finished"),
            (json!({"state": "waiting", "processingVehicle": null}), "is waiting"),
        ] {
            let Report::Notice(told) = holder("a", &order) else { panic!("{order}") };
            assert!(told.contains(text), "{told}");
        }
    }
}
