//! The errors of a vehicle, in the words of each version.

use crate::message::{Error, ErrorLevel, Order, Reference, Version};

/// An error of the standard, or of this vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Malformed,
    UnsupportedParameter,
    InvalidOrderAction,
    InvalidInstantAction,
    OutdatedUpdate,
    SameUpdate,
    UpdateAfterCancel,
    NotAContinuation,
    OtherOrderActive,
    StartOutOfRange,
    NoRoute,
    NodeUnreachable,
    UnknownMap,
    NotAvailable,
    NothingToCancel,
    ActionFailed,
    BrokenDown,
    NotLocalized,
}

/// The time until an error is no longer reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Until {
    NewOrder,
    NewInstantAction,
    /// Its cause is gone.
    Over,
}

/// An error that a vehicle reports.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    pub cause: Cause,
    pub description: String,
    pub references: Vec<Reference>,
}

/// The most errors that a vehicle reports: the newest ones.
pub(super) const MOST_FAULTS: usize = 20;

impl Fault {
    pub(super) fn new(cause: Cause, description: impl Into<String>) -> Self {
        Self { cause, description: description.into(), references: Vec::new() }
    }

    /// Rejects an order.
    pub(super) fn reject<T>(order: &Order, cause: Cause, reason: &str) -> Result<T, Self> {
        Err(Self::new(cause, reason).about_order(order))
    }

    /// Adds a reference.
    pub(super) fn about(mut self, key: &str, value: impl ToString) -> Self {
        self.references.push(Reference::new(key, value));
        self
    }

    /// Adds references to an order.
    pub(super) fn about_order(self, order: &Order) -> Self {
        let topic = self.about("topic", "order").about("headerId", order.header.header_id);
        topic.about("orderId", &order.order_id).about("orderUpdateId", order.order_update_id)
    }

    pub(super) const fn until(&self) -> Until {
        match self.cause {
            Cause::InvalidInstantAction => Until::NewInstantAction,
            Cause::BrokenDown | Cause::NotAvailable | Cause::NotLocalized => Until::Over,
            _ => Until::NewOrder,
        }
    }

    /// The error as a version words it.
    pub(super) fn report(&self, version: Version) -> Error {
        Error {
            error_type: self.cause.name(version).to_owned(),
            error_references: self.references.clone(),
            error_description: Some(self.description.clone()),
            error_hint: None,
            error_level: self.cause.level(version),
        }
    }
}

impl Cause {
    /// The error type. 2.x names few: those of its sections 6.6.3 and 6.6.4.
    const fn name(self, version: Version) -> &'static str {
        match version {
            Version::V2_0 | Version::V2_1 => self.old_name(),
            Version::V3_0 => self.new_name(),
        }
    }

    const fn old_name(self) -> &'static str {
        match self {
            Self::Malformed => "validationError",
            Self::UnsupportedParameter | Self::InvalidOrderAction | Self::UnknownMap => {
                "orderError"
            }
            Self::OtherOrderActive | Self::NotAvailable => "orderError",
            Self::OutdatedUpdate | Self::SameUpdate | Self::UpdateAfterCancel => "orderUpdateError",
            Self::NotAContinuation => "orderUpdateError",
            Self::StartOutOfRange | Self::NoRoute | Self::NodeUnreachable => "noRouteError",
            Self::NothingToCancel => "noOrderToCancel",
            Self::InvalidInstantAction => "instantActionError",
            Self::ActionFailed => "actionError",
            Self::BrokenDown => "breakdown",
            Self::NotLocalized => "localizationError",
        }
    }

    const fn new_name(self) -> &'static str {
        match self {
            Self::Malformed => "VALIDATION_FAILURE",
            Self::UnsupportedParameter => "UNSUPPORTED_PARAMETER",
            Self::InvalidOrderAction => "INVALID_ORDER_ACTION",
            Self::InvalidInstantAction => "INVALID_INSTANT_ACTION",
            Self::OutdatedUpdate => "OUTDATED_ORDER_UPDATE",
            Self::SameUpdate => "SAME_ORDER_UPDATE_ID",
            Self::UpdateAfterCancel => "ORDER_UPDATE_FOLLOWING_CANCEL",
            Self::NotAContinuation => "INVALID_ORDER",
            Self::OtherOrderActive => "OTHER_ORDER_ACTIVE",
            Self::StartOutOfRange => "START_NODE_OUT_OF_RANGE",
            Self::NoRoute => "NO_ROUTE_TO_TARGET",
            Self::NodeUnreachable => "NODE_UNREACHABLE",
            Self::UnknownMap => "UNKNOWN_MAP_ID",
            Self::NotAvailable => "MOBILE_ROBOT_NOT_AVAILABLE",
            Self::NothingToCancel => "NO_ORDER_TO_CANCEL",
            Self::ActionFailed => "ACTION_FAILED",
            Self::BrokenDown => "BREAKDOWN",
            Self::NotLocalized => "LOCALIZATION_ERROR",
        }
    }

    /// The level: table 9 of 3.0; 2.x calls rejections warnings.
    const fn level(self, version: Version) -> ErrorLevel {
        match (self, version) {
            (Self::BrokenDown, _) => ErrorLevel::Fatal,
            (
                Self::UnsupportedParameter | Self::NodeUnreachable | Self::NotLocalized,
                Version::V3_0,
            ) => ErrorLevel::Critical,
            _ => ErrorLevel::Warning,
        }
    }
}
