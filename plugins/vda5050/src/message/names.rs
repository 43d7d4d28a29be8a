//! The names that differ between 2.x and 3.0, in one place.

use super::header::Topic;

/// A name of 3.0, and that of 2.x.
#[derive(Debug)]
pub(super) struct Renamed {
    pub new: &'static str,
    pub old: &'static str,
}

/// A value of a field in 3.0, and that in 2.x.
#[derive(Debug)]
pub(super) struct RenamedValue {
    /// The field, by its name of 3.0.
    pub field: &'static str,
    pub new: &'static str,
    pub old: &'static str,
}

const fn renamed(new: &'static str, old: &'static str) -> Renamed {
    Renamed { new, old }
}

/// The fields of all messages but the factsheet.
const FIELDS: &[Renamed] = &[
    renamed("actionDescriptor", "actionDescription"),
    renamed("actionResult", "resultDescription"),
    renamed("activeEmergencyStop", "eStop"),
    renamed("corridorReferencePoint", "corridorRefPoint"),
    renamed("edgeDescriptor", "edgeDescription"),
    renamed("infoDescriptor", "infoDescription"),
    renamed("localized", "positionInitialized"),
    renamed("mapDescriptor", "mapDescription"),
    renamed("maximumMobileRobotHeight", "maxHeight"),
    renamed("maximumRotationSpeed", "maxRotationSpeed"),
    renamed("maximumSpeed", "maxSpeed"),
    renamed("minimumLoadHandlingDeviceHeight", "minHeight"),
    renamed("mobileRobotPosition", "agvPosition"),
    renamed("nodeDescriptor", "nodeDescription"),
    renamed("powerSupply", "batteryState"),
    renamed("stateOfCharge", "batteryCharge"),
];

/// The fields of the factsheet.
const FACTSHEET_FIELDS: &[Renamed] = &[
    renamed("maximumAcceleration", "accelerationMax"),
    renamed("maximumArrayLengths", "maxArrayLens"),
    renamed("maximumDeceleration", "decelerationMax"),
    renamed("maximumHeight", "heightMax"),
    renamed("maximumLoadMass", "maxLoadMass"),
    renamed("maximumSpeed", "speedMax"),
    renamed("maximumStringLengths", "maxStringLens"),
    renamed("minimumHeight", "heightMin"),
    renamed("minimumOrderInterval", "minOrderInterval"),
    renamed("minimumSpeed", "speedMin"),
    renamed("minimumStateInterval", "minStateInterval"),
    renamed("mobileRobotActions", "agvActions"),
    renamed("mobileRobotClass", "agvClass"),
    renamed("mobileRobotGeometry", "agvGeometry"),
    renamed("mobileRobotKinematics", "agvKinematic"),
];

/// The values that are spelt otherwise.
pub(super) const VALUES: &[RenamedValue] = &[
    RenamedValue { field: "connectionState", new: "CONNECTION_BROKEN", old: "CONNECTIONBROKEN" },
    RenamedValue {
        field: "corridorReferencePoint",
        new: "KINEMATIC_CENTER",
        old: "KINEMATICCENTER",
    },
    RenamedValue { field: "operatingMode", new: "TEACH_IN", old: "TEACHIN" },
];

/// The field whose content has the sender's own names.
pub(super) const PARAMETERS: &str = "actionParameters";

/// The fields of a topic's message that are spelt otherwise.
pub(super) const fn fields(topic: Topic) -> &'static [Renamed] {
    match topic {
        Topic::Factsheet => FACTSHEET_FIELDS,
        _ => FIELDS,
    }
}
