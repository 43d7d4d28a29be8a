//! `regatta orders list`: a line for each order, with the words of the glossary.

use regatta_orders::Client;
use regatta_plugin::activity::Activity;
use serde_json::Value;

use crate::failure::Failure;
use crate::output::show;

/// The number of orders that are requested at once: there may be millions.
const PAGE: usize = 1_000;
/// The state of the API for an order whose robot drives to its next stop.
const UNDER_WAY: &str = "travelling";

/// Lists the orders in a state, or all of them.
pub fn run(client: &Client, state: Option<&str>, as_json: bool) -> Result<(), Failure> {
    let query = match state {
        Some(state) if !state.chars().all(|c| c.is_ascii_alphabetic()) => {
            return Err(format!("invalid state '{}'", state.escape_debug()).into());
        }
        Some(state) => format!("&state={}", of_api(state)),
        None => String::new(),
    };
    if !as_json {
        println!("{:<24} {:<11} {:>6} {:>8}  stops", "name", "state", "robot", "priority");
    }
    let (mut all, mut after) = (Vec::new(), String::new());
    loop {
        let answer = client.get(&format!("/v1/transportOrders?limit={PAGE}{query}{after}"))?;
        let page = answer.as_array().map_or(&[][..], Vec::as_slice);
        for order in page.iter().filter(|order| is_listed(order, state)) {
            match as_json {
                true => all.push(order.clone()),
                false => show(line(order) + "\n"),
            }
        }
        match page.last().and_then(|order| order["name"].as_str()) {
            Some(name) if page.len() == PAGE => after = format!("&after={}", Client::escaped(name)),
            _ => break,
        }
    }
    if as_json {
        println!("{}", Value::Array(all));
    }
    Ok(())
}

/// Returns the state of the API for a word: an order that is fetched or carried is under way.
fn of_api(word: &str) -> &str {
    let is_under_way = [Activity::Fetching, Activity::Carrying].map(Activity::name).contains(&word);
    if is_under_way { UNDER_WAY } else { word }
}

/// Whether an order of the API's state is in the state that was asked for.
fn is_listed(order: &Value, state: Option<&str>) -> bool {
    state.is_none_or(|state| of_api(state) == state || word(order) == state)
}

/// Returns the word for the state of an order: that of its robot's activity while it is under way.
fn word(order: &Value) -> &str {
    let state = order["state"].as_str().unwrap_or("-");
    if state != UNDER_WAY {
        return state;
    }
    let mut stops = order["destinations"].as_array().into_iter().flatten();
    let has_begun = stops.any(|stop| stop["state"] == "finished");
    if has_begun { Activity::Carrying.name() } else { Activity::Fetching.name() }
}

/// Formats an order in one line.
fn line(order: &Value) -> String {
    let stops = order["destinations"].as_array().into_iter().flatten();
    let stops: Vec<_> = stops.filter_map(|stop| stop["locationName"].as_str()).collect();
    let [name, robot] = ["name", "processingVehicle"].map(|key| order[key].as_str().unwrap_or("-"));
    let (state, priority, stops) = (word(order), &order["priority"], stops.join(" → "));
    format!("{name:<24} {state:<11} {robot:>6} {priority:>8}  {stops}")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn order(state: &str, first_stop: &str) -> Value {
        let stops = json!([{"locationName": "A", "state": first_stop}, {"locationName": "B"}]);
        json!({"name": "q1", "state": state, "priority": 0, "destinations": stops})
    }

    #[test]
    fn an_order_under_way_is_what_its_robot_does() {
        let begun = order("travelling", "finished");
        assert!(line(&begun).contains(" carrying "), "{}", line(&begun));
        assert_eq!(word(&order("travelling", "travelling")), "fetching");
        assert_eq!(word(&order("handling", "handling")), "handling");
    }

    #[test]
    fn orders_are_listed_by_the_word_and_by_the_state_of_the_api() {
        let begun = order("travelling", "finished");
        let listed = ["carrying", "travelling", "fetching"].map(|state| {
            assert_eq!(of_api(state), "travelling");
            is_listed(&begun, Some(state))
        });
        assert_eq!(listed, [true, true, false]);
        assert!(is_listed(&begun, None) && of_api("open") == "open");
    }
}
