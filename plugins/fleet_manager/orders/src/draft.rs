//! Orders as users write them, unchecked, and their conversion to [`NewOrder`].

use serde::{Deserialize, Serialize};

use super::order::{Action, NameError, NewOrder, OrderName, Stop};
use super::places::{PlaceError, Places};
#[cfg(feature = "http")]
use super::schema;

/// The largest number of stops of an order.
pub const MAX_STOPS: usize = 1_000;
/// The longest dwell time, and the latest time, in seconds: some 30 years.
pub(crate) const MAX_SECS: f64 = 1e9;

/// An order as a user writes it: a body of the web API, or a row of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct OrderDraft {
    /// The name; absent for one that is generated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "http", schema(value_type = OrderName, inline, required = false))]
    pub name: Option<String>,
    /// The stops.
    #[cfg_attr(feature = "http", schema(min_items = 1, max_items = 1000))]
    pub destinations: Vec<StopDraft>,
    /// 0 to 255; higher is first.
    #[serde(default)]
    #[cfg_attr(feature = "http", schema(minimum = 0, maximum = 255))]
    pub priority: u8,
    /// Simulated time in seconds before which no robot gets it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "http", schema(schema_with = schema::seconds, required = false))]
    pub earliest_start: Option<f64>,
    /// Simulated time in seconds at which it should be finished.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "http", schema(schema_with = schema::seconds, required = false))]
    pub deadline: Option<f64>,
    /// The id of the only robot that may get it; any may if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "http", schema(schema_with = schema::robot, required = false))]
    pub intended_vehicle: Option<Label>,
    /// The names of the robot types that may get it; any may if absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "http", schema(required = false))]
    pub robot_types: Vec<String>,
}

/// A stop as a user writes it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
#[cfg_attr(feature = "http", schema(as = Destination))]
pub struct StopDraft {
    /// The name or the id of a node.
    #[cfg_attr(feature = "http", schema(schema_with = schema::location))]
    pub location_name: Label,
    /// none, pick, drop, charge or park, in any case; also NOP and MOVE for none, Load cargo and
    /// Unload cargo.
    #[serde(default)]
    #[cfg_attr(feature = "http", schema(schema_with = schema::operation, required = false))]
    pub operation: Action,
    /// The duration of the operation, in seconds.
    #[serde(default)]
    #[cfg_attr(feature = "http", schema(schema_with = schema::seconds, required = false))]
    pub dwell: f64,
}

/// The name or the id of a node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Label {
    /// An id.
    Id(u32),
    /// A name, or an id as text.
    Name(String),
}

impl Label {
    fn robot(&self) -> Result<u32, DraftError> {
        let text = self.to_string();
        text.parse().map_err(|_| DraftError::Robot(text))
    }
}

impl Default for Label {
    fn default() -> Self {
        Self::Name(String::new())
    }
}

impl std::fmt::Display for Label {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Id(id) => write!(formatter, "{id}"),
            Self::Name(name) => formatter.write_str(name),
        }
    }
}

/// The error of checking an [`OrderDraft`].
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum DraftError {
    /// The name is invalid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// There is no such node.
    #[error(
        "stop {} is at `{}`, which is neither the name nor the id of a node",
        .stop + 1,
        .label.escape_debug()
    )]
    UnknownStop {
        /// The index of the stop.
        stop: usize,
        /// The name or id that no node has.
        label: String,
    },
    /// Several nodes have the name.
    #[error(
        "stop {} is at `{}`, which is the name of several nodes; give the id of one",
        .stop + 1,
        .label.escape_debug()
    )]
    AmbiguousStop {
        /// The index of the stop.
        stop: usize,
        /// The name that they have.
        label: String,
    },
    /// A stop at a storage at which a robot neither picks nor drops.
    #[error(
        "stop {} is at the storage `{}`, where robots pick or drop: give one of the two actions",
        .stop + 1,
        .label.escape_debug()
    )]
    StorageAction {
        /// The index of the stop.
        stop: usize,
        /// The name of the storage.
        label: String,
    },
    /// No stops, or too many.
    #[error("an order has 1 to {MAX_STOPS} stops, and this one has {0}")]
    Stops(usize),
    /// `intendedVehicle` isn't the id of a robot.
    #[error("`{}` isn't the id of a robot (`intendedVehicle`)", .0.escape_debug())]
    Robot(String),
    /// There is no such robot type.
    #[error(transparent)]
    RobotType(PlaceError),
    /// It is for one robot, and for robot types.
    #[error("it is for a robot and for robot types: give one of the two")]
    RobotAndTypes,
    /// A time that is not a number of seconds.
    #[error("`{field}` is {value}, and must be 0 to 1000000000 seconds")]
    Secs {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// The deadline is before the earliest start.
    #[error("the deadline ({deadline} s) is before the earliest start ({earliest} s)")]
    Deadline {
        /// The deadline in seconds.
        deadline: f64,
        /// The earliest start in seconds.
        earliest: f64,
    },
}

impl OrderDraft {
    /// Checks the order, and finds the nodes. An order without a name gets that of `generated`.
    ///
    /// # Errors
    /// [`DraftError`] for the first error.
    pub fn check(
        &self,
        places: &Places,
        generated: impl FnOnce() -> OrderName,
    ) -> Result<NewOrder, DraftError> {
        let name = match &self.name {
            Some(name) => OrderName::parse(name)?,
            None => generated(),
        };
        if self.destinations.is_empty() || self.destinations.len() > MAX_STOPS {
            return Err(DraftError::Stops(self.destinations.len()));
        }
        let stops =
            self.destinations.iter().enumerate().map(|(index, stop)| stop.check(index, places));
        let stops = stops.collect::<Result<_, _>>()?;
        let earliest_secs = secs("earliestStart", self.earliest_start.unwrap_or(0.0))?;
        let deadline_secs = self.deadline.map(|deadline| secs("deadline", deadline)).transpose()?;
        let intended_robot = self.intended_vehicle.as_ref().map(Label::robot).transpose()?;
        let robot_types = self.robot_types(places)?;
        match deadline_secs {
            Some(deadline) if deadline < earliest_secs => {
                Err(DraftError::Deadline { deadline, earliest: earliest_secs })
            }
            _ => Ok(NewOrder {
                name,
                stops,
                priority: self.priority,
                earliest_secs,
                deadline_secs,
                intended_robot,
                robot_types,
            }),
        }
    }

    fn robot_types(&self, places: &Places) -> Result<Vec<u32>, DraftError> {
        match &self.intended_vehicle {
            Some(_) if !self.robot_types.is_empty() => Err(DraftError::RobotAndTypes),
            _ => places.robot_types(&self.robot_types).map_err(DraftError::RobotType),
        }
    }
}

impl OrderDraft {
    /// Takes the name out of an order of a file; one without a name gets that of its line.
    pub(crate) fn named_by_line(&self, line: usize) -> Result<(Self, OrderName), DraftError> {
        let mut draft = self.clone();
        let name = draft.name.take().unwrap_or_else(|| format!("line-{line}"));
        Ok((draft, OrderName::parse(&name)?))
    }
}

impl StopDraft {
    fn check(&self, stop: usize, places: &Places) -> Result<Stop, DraftError> {
        let label = self.location_name.to_string();
        let node = match places.find_one(&label) {
            Ok(node) => node,
            Err(PlaceError::Ambiguous(_)) => return Err(DraftError::AmbiguousStop { stop, label }),
            Err(_) => return Err(DraftError::UnknownStop { stop, label }),
        };
        let is_transport = matches!(self.operation, Action::Pick | Action::Drop);
        if places.storage(node).is_some() && !is_transport {
            return Err(DraftError::StorageAction { stop, label });
        }
        Ok(Stop { node, action: self.operation, dwell_secs: secs("dwell", self.dwell)? })
    }
}

/// Checks a time in seconds.
pub(crate) fn secs(field: &'static str, value: f64) -> Result<f64, DraftError> {
    // The sum with 0 turns -0 into 0.
    if (0.0..=MAX_SECS).contains(&value) {
        Ok(value + 0.0)
    } else {
        Err(DraftError::Secs { field, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::places::Place;

    fn places() -> Places {
        let place = |id, name: &str| Place { id, name: name.to_owned(), ..Place::default() };
        Places::new(vec![place(10, "A"), place(20, ""), place(30, "10")])
    }

    fn check(json: &str) -> Result<NewOrder, DraftError> {
        let draft: OrderDraft = serde_json::from_str(json).expect("a draft");
        draft.check(&places(), || OrderName::parse("made").expect("a name"))
    }

    #[test]
    fn stops_are_found_by_name_before_id() {
        let order = check(
            r#"{"destinations": [{"locationName": "A", "operation": "pick", "dwell": 2}, {"locationName": 20},
                {"locationName": "10"}]}"#,
        );
        let order = order.expect("an order");
        let nodes: Vec<_> = order.stops.iter().map(|stop| stop.node).collect();
        assert_eq!((nodes, order.name.as_str()), (vec![0, 1, 2], "made"));
        assert_eq!((order.stops[0].action, order.stops[0].dwell_secs), (Action::Pick, 2.0));
        assert_eq!((order.intended_robot, order.robot_types), (None, Vec::new()));
    }

    #[test]
    fn an_order_may_be_for_robot_types() {
        let types = ["amr", "forklift", "tugger"].map(str::to_owned).to_vec();
        let places = places().with_robot_types(types);
        let check = |names: &str| {
            let json =
                format!(r#"{{"destinations": [{{"locationName": "A"}}], "robotTypes": {names}}}"#);
            let draft: OrderDraft = serde_json::from_str(&json).expect("a draft");
            draft.check(&places, || OrderName::parse("made").expect("a name"))
        };
        let order = check(r#"["tugger", "forklift", "tugger"]"#).expect("an order");
        assert_eq!(order.robot_types, [1, 2]);
        assert_eq!(places.robot_type_names(&order.robot_types), ["forklift", "tugger"]);
        let error = check(r#"["lift"]"#).expect_err("unknown").to_string();
        assert_eq!(error, "no robot type has the name `lift`; there are: amr, forklift, tugger");
    }

    #[test]
    fn an_order_may_be_for_one_robot_only() {
        for robot in ["7", "\"7\""] {
            let order = check(&format!(
                r#"{{"destinations": [{{"locationName": "A"}}], "intendedVehicle": {robot}}}"#
            ));
            assert_eq!(order.expect("an order").intended_robot, Some(7));
        }
    }

    #[test]
    fn operations_may_be_in_any_case() {
        for (text, action) in [
            ("PICK", Action::Pick),
            ("Drop", Action::Drop),
            ("pick", Action::Pick),
            ("NOP", Action::None),
            ("Load cargo", Action::Pick),
            ("Unload cargo", Action::Drop),
        ] {
            let json =
                format!(r#"{{"destinations": [{{"locationName": "A", "operation": "{text}"}}]}}"#);
            assert_eq!(check(&json).expect(text).stops[0].action, action, "{text}");
        }
        let json = r#"{"destinations": [{"locationName": "A", "operation": "lift"}]}"#;
        let error = serde_json::from_str::<OrderDraft>(json).expect_err("unknown").to_string();
        assert!(error.contains("unknown action `lift`; use none, pick"), "{error}");
    }

    #[test]
    fn what_is_wrong_is_refused_with_its_reason() {
        for (json, reason) in [
            (r#"{"destinations": []}"#, "has 0"),
            (r#"{"destinations": [{"locationName": "B"}]}"#, "stop 1 is at `B`"),
            (r#"{"destinations": [{"locationName": "A", "dwell": -1}]}"#, "`dwell` is -1"),
            (
                r#"{"destinations": [{"locationName": "A"}], "earliestStart": 1e300}"#,
                "earliestStart",
            ),
            (
                r#"{"destinations": [{"locationName": "A"}], "earliestStart": 9, "deadline": 8}"#,
                "before the earliest",
            ),
            (
                r#"{"destinations": [{"locationName": "A"}], "intendedVehicle": "x"}"#,
                "`x` isn't the id of a robot (`intendedVehicle`)",
            ),
            (
                r#"{"destinations": [{"locationName": "A"}], "intendedVehicle": 1, "robotTypes": ["a"]}"#,
                "give one of the two",
            ),
            (r#"{"destinations": [{"locationName": "A"}], "name": ""}"#, "1 to 128"),
            (r#"{"destinations": [{"locationName": "A"}], "name": "sent:1"}"#, "generated"),
            (r#"{"destinations": [{"locationName": "A"}], "name": "a/b"}"#, "a `/`"),
            (r#"{"destinations": [{"locationName": "A"}], "name": "load:1-1"}"#, "generated"),
        ] {
            let error = check(json).expect_err(json).to_string();
            assert!(error.contains(reason), "{json}: {error}");
        }
    }

    #[test]
    fn a_name_of_several_nodes_is_refused_and_a_station_of_several_nodes_is_not() {
        let place = |id, name: &str| Place { id, name: name.to_owned(), ..Place::default() };
        let mut places = Places::new(vec![place(1, "A"), place(2, "twin"), place(3, "twin")]);
        places.add_name("ramp", 1);
        places.add_name("ramp", 2);
        let stop_at = |name: &str| {
            let json = format!(r#"{{"destinations": [{{"locationName": "{name}"}}]}}"#);
            let draft: OrderDraft = serde_json::from_str(&json).expect("a draft");
            draft.destinations[0].check(0, &places).map(|stop| stop.node)
        };
        assert_eq!(stop_at("ramp"), Ok(1), "the first node of the station");
        let error = stop_at("twin").expect_err("two nodes").to_string();
        assert_eq!(
            error,
            "stop 1 is at `twin`, which is the name of several nodes; give the id of one"
        );
    }
}
