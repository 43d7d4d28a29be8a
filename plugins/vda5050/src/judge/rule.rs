//! The rules of the judge, as one table.

use crate::message::Version;

/// The severity of a breach.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Severity {
    /// The standard advises against it, or it may have a cause that messages don't show.
    Warning,
    /// The standard forbids it.
    Error,
}

/// The side that breaks a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Side {
    /// The master (in 3.0: fleet control).
    Master,
    /// The vehicle (in 3.0: mobile robot).
    Vehicle,
    /// The sender of the message, by its topic.
    Sender,
}

/// A rule of the standard. Its id is its name with hyphens.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, strum::IntoStaticStr, strum::EnumIter,
)]
#[strum(serialize_all = "kebab-case")]
#[expect(missing_docs, reason = "the table RULES says what each is")]
pub enum Rule {
    Topic,
    SerialNumber,
    Json,
    MissingField,
    FieldType,
    UnknownValue,
    ValueRange,
    Schema,
    VersionUnknown,
    VersionOfTopic,
    VersionChanges,
    HeaderIdGap,
    HeaderIdRepeated,
    TimestampForm,
    TimestampBackwards,
    ClockSkew,
    Identity,
    QualityOfService,
    ConnectionNotRetained,
    FactsheetNotRetained,
    NoNodes,
    EdgeCount,
    SequenceIds,
    SequenceStart,
    EdgeEnds,
    EdgeBeforeNode,
    ReleasedAfterHorizon,
    FirstNodeUnreleased,
    ActionIdTwice,
    MapMissing,
    Trajectory,
    FirstUpdateId,
    UpdateIdBackwards,
    UpdateIdReused,
    BaseSentAgain,
    Stitching,
    StitchingNodeChanged,
    OrderWhileActive,
    UpdateAfterCancel,
    UpdateTooEarly,
    OrderOffline,
    OrderInMode,
    StartOutOfRange,
    HorizonNotReleased,
    ActionScope,
    InstantBlocking,
    InstantInMode,
    CancelWithoutOrder,
    HeadOn,
    NeverOnline,
    OfflineGoesOn,
    StateOverdue,
    OrderUnanswered,
    ActionUnanswered,
    OrderNeverSent,
    UpdateNeverSent,
    SequenceBackwards,
    NodeStates,
    EdgeStates,
    NodeUnnamed,
    LastNode,
    HorizonDriven,
    ActionStateMissing,
    ActionStateUnknown,
    ActionStateDropped,
    ActionStatus,
    DrivingWhilePaused,
    DrivingWithAction,
    DrivingInEmergency,
    DrivingUnlocalized,
    ActionsInParallel,
    PauseUntold,
    OrderInManualMode,
    CancelledOrderKept,
    CancelNotRefused,
    RejectionType,
    RejectionReferences,
    SpeedLimit,
    NodeOutOfRange,
    OffTrajectory,
    OffEdge,
    Visualization,
    Contact,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct RuleRow {
    /// The rule.
    pub rule: Rule,
    /// The severity of a breach.
    pub severity: Severity,
    /// The side that breaks it.
    pub side: Side,
    /// The clause of 2.x, with the numbers of 2.1.
    pub clause_2: &'static str,
    /// The clause of 3.0.
    pub clause_3: &'static str,
    /// The requirement.
    pub requirement: &'static str,
}

impl Rule {
    /// The id, as reports have it.
    pub fn id(self) -> &'static str {
        self.into()
    }

    /// Its row of the table.
    pub fn row(self) -> &'static RuleRow {
        // A test keeps rows and rules in the same order.
        &RULES[self as usize]
    }
}

impl RuleRow {
    /// The clause of a version.
    pub fn clause(&self, version: Version) -> &'static str {
        match version {
            Version::V2_0 | Version::V2_1 => self.clause_2,
            Version::V3_0 => self.clause_3,
        }
    }
}

const fn row(
    rule: Rule,
    severity: Severity,
    side: Side,
    clauses: [&'static str; 2],
    requirement: &'static str,
) -> RuleRow {
    let [clause_2, clause_3] = clauses;
    RuleRow { rule, severity, side, clause_2, clause_3, requirement }
}

use Severity::{Error, Warning};
use Side::{Master, Sender, Vehicle};

/// All rules, in the order of the enum.
#[rustfmt::skip]
pub const RULES: &[RuleRow] = &[
    // Each message.
    row(Rule::Topic, Warning, Sender, ["6.5", "4.3"],
        "the last level of a topic is one of the standard"),
    row(Rule::SerialNumber, Error, Sender, ["6.3", "4.2"],
        "a serial number consists of A-Z, a-z, 0-9, _ . : and -"),
    row(Rule::Json, Error, Sender, ["6.1.4", "7.1.4"],
        "a message is JSON of at most 4 MiB"),
    row(Rule::MissingField, Error, Sender, ["6.1.1", "7.1.1"],
        "all fields that aren't optional are there"),
    row(Rule::FieldType, Error, Sender, ["6.1.4", "7.1.4"],
        "a field has the type of the standard"),
    row(Rule::UnknownValue, Error, Sender, ["6.1.3", "7.1.3"],
        "an enumeration has a value of the standard"),
    row(Rule::ValueRange, Error, Sender, ["6.6.6, 6.10.6", "7.3, 7.8"],
        "a number is within its range"),
    row(Rule::Schema, Error, Sender, ["6.1", "7.1"],
        "a message is valid by the official schema of its version"),
    row(Rule::VersionUnknown, Error, Sender, ["6.4", "7.2"],
        "the header has a version of the standard, MAJOR.MINOR.PATCH"),
    row(Rule::VersionOfTopic, Error, Sender, ["6.3", "4.2"],
        "the version of the header has the major version of the topic"),
    row(Rule::VersionChanges, Warning, Sender, ["6.4", "7.2"],
        "master and vehicle speak the same version"),
    row(Rule::HeaderIdGap, Warning, Sender, ["6.4", "7.2"],
        "headerId rises by 1 with each message of a topic"),
    row(Rule::HeaderIdRepeated, Error, Sender, ["6.4", "7.2"],
        "no headerId of a topic is used again, but from 0 or 1 after a restart"),
    row(Rule::TimestampForm, Error, Sender, ["6.4", "7.2"],
        "timestamp is ISO 8601 in UTC, with Z"),
    row(Rule::TimestampBackwards, Error, Sender, ["6.4", "7.2"],
        "timestamps of a topic don't go back"),
    row(Rule::ClockSkew, Warning, Sender, ["6.4", "7.2"],
        "timestamp is within 10 s of the time when the message came"),
    row(Rule::Identity, Error, Sender, ["6.3", "4.2"],
        "manufacturer and serialNumber are those of the topic"),
    row(Rule::QualityOfService, Error, Sender, ["6.2", "4.1"],
        "connection has quality of service 1, all other topics 0"),
    row(Rule::ConnectionNotRetained, Error, Vehicle, ["6.14", "6.5"],
        "connection messages are retained"),
    row(Rule::FactsheetNotRetained, Error, Vehicle, ["6.15", "6.10"],
        "factsheets are retained (from 2.1 on)"),
    // An order alone.
    row(Rule::NoNodes, Error, Master, ["6.6.1", "6.1.1"],
        "an order has at least one node"),
    row(Rule::EdgeCount, Error, Master, ["6.6.1", "6.1.1"],
        "an order has one edge less than nodes"),
    row(Rule::SequenceIds, Error, Master, ["6.6.2", "6.1.1"],
        "sequence ids rise by 1 from node to edge to node"),
    row(Rule::SequenceStart, Error, Master, ["6.6.2", "6.1.1"],
        "the first node of a new order has the sequence id 0"),
    row(Rule::EdgeEnds, Error, Master, ["6.6.6", "7.3"],
        "an edge joins the nodes before and after it (2.x)"),
    row(Rule::EdgeBeforeNode, Error, Master, ["6.6.1", "6.1.1"],
        "an edge is released only if both of its nodes are"),
    row(Rule::ReleasedAfterHorizon, Error, Master, ["6.6.1", "6.1.1"],
        "nothing is released after what isn't released"),
    row(Rule::FirstNodeUnreleased, Error, Master, ["6.6.1", "6.1.1"],
        "the first node of an order is released"),
    row(Rule::ActionIdTwice, Error, Master, ["6.8", "7.3"],
        "an action id stands for one action only"),
    row(Rule::MapMissing, Error, Master, ["6.6.6", "7.3"],
        "the position of a node names its map"),
    row(Rule::Trajectory, Error, Master, ["6.6.6", "7.3"],
        "a trajectory has degree + 1 points or more, and rising knots that fit"),
    // Orders one after the other.
    row(Rule::FirstUpdateId, Warning, Master, ["6.6.2", "6.1.2"],
        "the orderUpdateId of a new order is 0"),
    row(Rule::UpdateIdBackwards, Error, Master, ["6.6.4.3", "6.1.4.4"],
        "orderUpdateId rises with each update"),
    row(Rule::UpdateIdReused, Error, Master, ["6.6.4.3", "6.1.4.5"],
        "an update that is sent again has the same content"),
    row(Rule::BaseSentAgain, Error, Master, ["6.6.2", "6.1.2"],
        "an update has no node of the base before its last one: the base doesn't shrink"),
    row(Rule::Stitching, Error, Master, ["6.6.2", "6.1.2"],
        "an update begins at the last node of the base"),
    row(Rule::StitchingNodeChanged, Error, Master, ["6.6.2", "6.1.2"],
        "the first node of an update keeps its position"),
    row(Rule::OrderWhileActive, Error, Master, ["6.6.2", "6.1.4.6"],
        "a new order comes when the last one is done or cancelled"),
    row(Rule::UpdateAfterCancel, Error, Master, ["6.6.3.1", "6.1.3.1"],
        "a cancelled order has no updates"),
    row(Rule::UpdateTooEarly, Warning, Master, ["6.6.4.3", "6.1.4.5"],
        "an update comes after a state that shows the update before"),
    row(Rule::OrderOffline, Warning, Master, ["6.14", "6.5"],
        "orders go to vehicles that are online"),
    row(Rule::OrderInMode, Error, Master, ["6.10.6", "6.6.6"],
        "orders go to vehicles whose operating mode allows them"),
    row(Rule::StartOutOfRange, Error, Master, ["6.6.1", "6.1.4.7"],
        "a new order begins where the vehicle is"),
    row(Rule::HorizonNotReleased, Warning, Master, ["6.6.2", "6.1.2"],
        "a vehicle doesn't wait longer than a minute for its horizon"),
    row(Rule::ActionScope, Error, Master, ["6.8.1", "6.2.3.1"],
        "a predefined action stands where the standard allows it"),
    row(Rule::InstantBlocking, Error, Master, ["6.9", "6.2.1"],
        "an instant action has the blocking type NONE (3.0)"),
    row(Rule::InstantInMode, Error, Master, ["6.10.6", "6.6.6"],
        "instant actions go to vehicles whose operating mode allows them (3.0)"),
    row(Rule::CancelWithoutOrder, Warning, Master, ["6.6.3.2", "6.1.3.2"],
        "cancelOrder goes to vehicles that have an order"),
    row(Rule::HeadOn, Warning, Master, ["5", "5.3"],
        "no two vehicles have the same way in opposite directions in their bases"),
    // A vehicle on the broker.
    row(Rule::NeverOnline, Error, Vehicle, ["6.14", "6.5"],
        "a vehicle says ONLINE before its first state"),
    row(Rule::OfflineGoesOn, Error, Vehicle, ["6.14", "6.5"],
        "a vehicle that was offline or broken says ONLINE before it goes on"),
    row(Rule::StateOverdue, Error, Vehicle, ["6.10", "6.6"],
        "a vehicle that is online sends a state at least every 30 s"),
    row(Rule::OrderUnanswered, Error, Vehicle, ["6.10", "6.6"],
        "a state within 10 s shows an order or its rejection"),
    row(Rule::ActionUnanswered, Error, Vehicle, ["6.9", "6.2.1"],
        "a state within 10 s has each instant action, or an error about it"),
    // Its progress along the order.
    row(Rule::OrderNeverSent, Error, Vehicle, ["6.10.6", "7.8"],
        "a state names an order that was sent"),
    row(Rule::UpdateNeverSent, Error, Vehicle, ["6.10.6", "7.8"],
        "a state names an update that was sent"),
    row(Rule::SequenceBackwards, Error, Vehicle, ["6.10.2", "6.6.2"],
        "lastNodeSequenceId doesn't go back within an order"),
    row(Rule::NodeStates, Error, Vehicle, ["6.10.1", "6.6.1"],
        "nodeStates are the nodes of the order that are still to be reached"),
    row(Rule::EdgeStates, Error, Vehicle, ["6.10.1", "6.6.1"],
        "edgeStates are the edges of the order that are still to be driven"),
    row(Rule::NodeUnnamed, Error, Vehicle, ["6.10.2", "6.6.2"],
        "a node leaves nodeStates when it is the last node, and not before"),
    row(Rule::LastNode, Error, Vehicle, ["6.10.2", "6.6.2"],
        "lastNodeId and lastNodeSequenceId belong to one node of the order"),
    row(Rule::HorizonDriven, Error, Vehicle, ["6.6.1", "6.1.1"],
        "a vehicle doesn't reach a node that isn't released"),
    // Its actions.
    row(Rule::ActionStateMissing, Error, Vehicle, ["6.11", "6.6.9"],
        "each action of the order has a state"),
    row(Rule::ActionStateUnknown, Warning, Vehicle, ["6.11", "6.6.9"],
        "actionStates are those of actions that were sent"),
    row(Rule::ActionStateDropped, Error, Vehicle, ["6.11", "7.8"],
        "the states of actions stay until the next order"),
    row(Rule::ActionStatus, Error, Vehicle, ["6.11", "6.6.9"],
        "the status of an action changes as the standard has it"),
    row(Rule::DrivingWhilePaused, Error, Vehicle, ["6.8.1", "6.2.3.1"],
        "a vehicle that is paused doesn't drive"),
    row(Rule::DrivingWithAction, Error, Vehicle, ["6.12", "6.2.2"],
        "a vehicle doesn't drive while a SOFT or HARD action runs"),
    row(Rule::DrivingInEmergency, Error, Vehicle, ["6.10.6", "7.8"],
        "a vehicle doesn't drive while its emergency stop is active"),
    row(Rule::DrivingUnlocalized, Warning, Vehicle, ["6.10.6", "7.8"],
        "a vehicle that doesn't know its position doesn't drive by itself"),
    row(Rule::ActionsInParallel, Error, Vehicle, ["6.12", "6.2.2"],
        "no other action of the order runs beside a HARD or SINGLE one"),
    row(Rule::PauseUntold, Error, Vehicle, ["6.8.2", "6.2.3.2"],
        "paused is true when startPause is finished, false when stopPause is"),
    row(Rule::OrderInManualMode, Error, Vehicle, ["6.10.6", "6.6.7"],
        "a vehicle clears its order when it enters the mode MANUAL"),
    row(Rule::CancelledOrderKept, Error, Vehicle, ["6.6.3", "6.1.3"],
        "a vehicle stands and has no nodes left when cancelOrder is finished"),
    row(Rule::CancelNotRefused, Error, Vehicle, ["6.6.3.2", "6.1.3.2"],
        "cancelOrder fails with the error of the standard if there is no order"),
    row(Rule::RejectionType, Warning, Vehicle, ["6.6.4", "6.6.5.4"],
        "an error about an order has a type of the standard"),
    row(Rule::RejectionReferences, Warning, Vehicle, ["7.1", "6.6.5.2"],
        "an error about an order or an action refers to it"),
    // Its place.
    row(Rule::SpeedLimit, Error, Vehicle, ["6.6.6", "7.3"],
        "a vehicle isn't faster than its edge allows"),
    row(Rule::NodeOutOfRange, Error, Vehicle, ["6.10.2", "6.6.2"],
        "a node is reached when the vehicle is within its allowed deviation"),
    row(Rule::OffTrajectory, Error, Vehicle, ["6.6.5", "6.1.5"],
        "a vehicle stays on the trajectory of its edge, or in its corridor"),
    row(Rule::OffEdge, Warning, Vehicle, ["6.6.5", "6.1.5"],
        "a vehicle is nearer to its edge than half the length of it"),
    row(Rule::Visualization, Error, Vehicle, ["6.13", "6.7"],
        "visualization and state have the same position"),
    row(Rule::Contact, Error, Vehicle, ["5", "5.4"],
        "vehicles don't touch, by the sizes of their factsheets"),
];

#[cfg(test)]
mod tests {
    use strum::IntoEnumIterator;

    use super::*;

    #[test]
    fn each_rule_has_its_row() {
        assert_eq!(Rule::iter().count(), RULES.len());
        for rule in Rule::iter() {
            assert_eq!(rule.row().rule, rule, "{}", rule.id());
        }
        assert_eq!(Rule::BaseSentAgain.id(), "base-sent-again");
    }
}
