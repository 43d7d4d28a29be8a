//! The names of kinds and levels in tables, by the numbers of the contract.

use super::Value;

/// The names of events, by number.
pub(super) const EVENTS: [&str; 21] = [
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
    "action_failed",
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

/// The names of the causes of breakdowns, by number.
pub(super) const CAUSES: [&str; 2] = ["unknown", "flat_battery"];

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
pub(super) const ORDERS: [&str; 13] = [
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
    "queued",
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
    use regatta_plugin::command::CommandKind;
    use regatta_plugin::event::{BreakdownCause, EventKind, Refusal};
    use regatta_plugin::order::{OrderKind, StopAction};

    use super::*;
    use crate::schema::regatta;

    /// The names that `regatta.proto` has for the numbers 0, 1, ...
    fn recorded<T: TryFrom<i32>>(name: fn(&T) -> &'static str) -> Vec<String> {
        (0..)
            .map_while(|number| T::try_from(number).ok())
            .map(|value| name(&value).to_lowercase())
            .collect()
    }

    /// A record that is new in the contract has a name here, too.
    #[test]
    fn all_numbers_of_the_contract_have_names() {
        let last = |names: &[&str]| names.len() - 1;
        assert_eq!(EventKind::ALL.map(|kind| kind as usize).into_iter().max(), Some(last(&EVENTS)));
        assert_eq!(Refusal::ALL.map(|kind| kind as usize).into_iter().max(), Some(last(&REFUSALS)));
        assert_eq!(
            BreakdownCause::ALL.map(|cause| cause as usize).into_iter().max(),
            Some(last(&CAUSES))
        );
        assert_eq!(
            CommandKind::ALL.map(|kind| kind as usize).into_iter().max(),
            Some(last(&COMMANDS))
        );
        assert_eq!(OrderKind::ALL.map(|kind| kind as usize).into_iter().max(), Some(last(&ORDERS)));
        assert_eq!(
            StopAction::ALL.map(|kind| kind as usize).into_iter().max(),
            Some(last(&ACTIONS))
        );
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
