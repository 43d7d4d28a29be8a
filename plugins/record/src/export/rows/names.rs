//! The names of kinds and levels in tables, by the numbers of the contract.

use super::Value;

/// The names of events, by number.
pub(super) const EVENTS: [&str; 20] = [
    "unknown",
    "reached_node",
    "route_done",
    "waiting_for_release",
    "held",
    "resumed",
    "accepted",
    "refused",
    "spawned",
    "removed",
    "faulted",
    "stalled",
    "recovered",
    "broken_down",
    "repaired",
    "edge_closed",
    "edge_opened",
    "door_opened",
    "door_closed",
    "lift_arrived",
];

/// The names of the reasons of refusals, by number.
pub(super) const REFUSALS: [&str; 19] = [
    "none",
    "unknown_robot",
    "unknown_edge",
    "unknown_node",
    "unknown_robot_type",
    "not_connected",
    "no_reverse",
    "malformed_route",
    "distance_out_of_range",
    "fleet_full",
    "malformed_command",
    "not_steerable",
    "not_ahead",
    "edge_is_closed",
    "not_owner",
    "no_door",
    "no_lift",
    "lift_in_use",
    "no_cabin",
];

/// The names of commands, by number.
pub(super) const COMMANDS: [&str; 18] = [
    "leg",
    "assign",
    "extend",
    "cancel",
    "hold",
    "resume",
    "spawn_at_node",
    "spawn_on_edge",
    "remove",
    "release",
    "break",
    "repair",
    "close_edge",
    "open_edge",
    "request_door",
    "release_door",
    "call_lift",
    "release_lift",
];

/// The names of the order log's records, by number.
pub(super) const ORDERS: [&str; 12] = [
    "unknown",
    "created",
    "stop",
    "assigned",
    "withdrawn",
    "arrived",
    "handled",
    "finished",
    "failed",
    "cancelled",
    "unroutable",
    "reopened",
];

/// The names of the actions at stops, by number.
pub(super) const ACTIONS: [&str; 5] = ["none", "pick", "drop", "charge", "park"];

/// The names of the changes of contacts, by number.
pub(super) const CHANGES: [&str; 3] = ["unknown", "began", "ended"];

/// The names of levels of contacts, by number.
pub(super) const LEVELS: [&str; 3] = ["clear", "possible", "touching"];

/// Returns the name of a number as a value.
pub(super) fn name(names: &[&'static str], number: u32) -> Value {
    Value::Text(names.get(number as usize).copied().unwrap_or("unknown"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::regatta;

    /// The names that `proto/regatta.proto` has for the numbers 0, 1, ...
    fn recorded<T: TryFrom<i32>>(name: fn(&T) -> &'static str) -> Vec<String> {
        (0..)
            .map_while(|number| T::try_from(number).ok())
            .map(|value| name(&value).to_lowercase())
            .collect()
    }

    #[test]
    fn the_names_are_those_of_the_recorded_messages() {
        let events: Vec<_> = EVENTS
            .map(|name| match name {
                "unknown" => "event_unknown",
                "held" => "stands_held",
                "faulted" => "has_faulted",
                "stalled" => "has_stalled",
                name => name,
            })
            .into();
        assert_eq!(recorded(regatta::EventKind::as_str_name), events);
        assert_eq!(recorded(regatta::Refusal::as_str_name), REFUSALS);
        assert_eq!(recorded(regatta::CommandKind::as_str_name), COMMANDS);
        assert_eq!(
            recorded(regatta::OrderKind::as_str_name),
            ORDERS.map(|name| format!("order_{name}"))
        );
        assert_eq!(
            recorded(regatta::StopAction::as_str_name),
            ACTIONS.map(|name| format!("action_{name}"))
        );
        assert_eq!(recorded(regatta::ContactLevel::as_str_name), LEVELS);
        assert_eq!(recorded(regatta::ContactChange::as_str_name)[1..], CHANGES[1..]);
    }
}
