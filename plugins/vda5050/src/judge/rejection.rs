//! Rejections: the errors with which vehicles answer orders that they can't take.

use super::finding::{Notes, quoted};
use super::rule::Rule;
use super::vehicle::Vehicle;
use crate::message::{Error, Order, State};

/// The errors of a state that are judged.
const MOST_ERRORS: usize = 100;
/// The types of errors about orders and actions in 2.x.
const TYPES_2: &[&str] =
    &["validationError", "orderError", "orderUpdateError", "noOrderToCancel", "noRouteError"];
/// The types of errors about orders and actions in 3.0.
const TYPES_3: &[&str] = &[
    "UNSUPPORTED_PARAMETER",
    "NO_ORDER_TO_CANCEL",
    "VALIDATION_FAILURE",
    "INVALID_ORDER",
    "INVALID_ORDER_ACTION",
    "INVALID_INSTANT_ACTION",
    "OUTDATED_ORDER_UPDATE",
    "SAME_ORDER_UPDATE_ID",
    "ORDER_UPDATE_FOLLOWING_CANCEL",
    "INSUFFICIENT_MEMORY",
    "NODE_UNREACHABLE",
    "NO_ROUTE_TO_TARGET",
    "OTHER_ORDER_ACTIVE",
    "START_NODE_OUT_OF_RANGE",
    "MOBILE_ROBOT_NOT_AVAILABLE",
    "UNKNOWN_MAP_ID",
];

impl Error {
    /// Whether the error refers to something by a key and a value.
    pub(super) fn is_about(&self, key: &str, value: &str) -> bool {
        let mut references = self.error_references.iter();
        references
            .any(|reference| reference.reference_key == key && reference.reference_value == value)
    }

    fn is_rejection_of(&self, order: &Order) -> bool {
        let mut updates =
            self.error_references.iter().filter(|one| one.reference_key == "orderUpdateId");
        let update = order.order_update_id.to_string();
        self.is_about("orderId", &order.order_id)
            && updates.all(|one| one.reference_value == update)
    }
}

fn is_new(error: &Error, before: Option<&State>) -> bool {
    !before.is_some_and(|before| before.errors.contains(error))
}

fn is_of_standard(error: &Error, notes: &Notes<'_>) -> bool {
    let types = if notes.is_3() { TYPES_3 } else { TYPES_2 };
    types.contains(&error.error_type.as_str())
}

/// Judges the errors that are new in a state, and takes the orders that they reject as answered.
pub(super) fn judge(
    vehicle: &mut Vehicle,
    state: &State,
    before: Option<&State>,
    notes: &mut Notes<'_>,
) {
    let errors = state.errors.iter().take(MOST_ERRORS);
    for error in errors.filter(|error| is_new(error, before)) {
        let sent = &mut vehicle.orders.sent;
        let named = sent.iter().position(|sent| error.is_rejection_of(&sent.order));
        if let Some(place) = named {
            sent.remove(place);
            if !is_of_standard(error, notes) {
                let kind = quoted(&error.error_type);
                notes.add(Rule::RejectionType, format!("an order is rejected by {kind}"));
            }
        } else if is_of_standard(error, notes) && error.error_references.is_empty() {
            let kind = quoted(&error.error_type);
            notes.add(Rule::RejectionReferences, format!("error {kind} has no references"));
            // It can only be about the order that waits.
            sent.pop_front();
        }
    }
}
