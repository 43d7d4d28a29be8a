//! Robots as the entities of a simulator.

use regex::Regex;

use crate::map::Map;
use crate::message::geometry::{Header, Vector3};
use crate::message::simulation::*;
use crate::options::{robot_name, robot_number};
use crate::poses::MAP;
use crate::snapshot::{Robot, Snapshot};

/// Robots, among the categories of entities.
const ROBOT: u8 = 1;
/// Kinds of [`Bounds`].
const NO_BOUNDS: u8 = 0;
const BOX: u8 = 1;
const SPHERE: u8 = 3;
/// The longest pattern of names, in bytes.
const MAX_PATTERN_BYTES: usize = 1_000;

pub(super) fn features() -> SimulatorFeatures {
    SimulatorFeatures {
        features: vec![
            feature::SPAWNING,
            feature::DELETING,
            feature::ENTITY_CATEGORIES,
            feature::ENTITY_BOUNDS_BOX,
            feature::ENTITY_STATE_GETTING,
            feature::SIMULATION_STATE_GETTING,
            feature::SIMULATION_STATE_SETTING,
            feature::SIMULATION_STATE_PAUSE,
            feature::STEP_SIMULATION_SINGLE,
            feature::STEP_SIMULATION_MULTIPLE,
        ],
        spawn_formats: Vec::new(),
        custom_info: "Regatta: the uri of a robot is the name of its type".to_owned(),
    }
}

/// The robots that filters admit.
pub(super) fn entities(filters: &EntityFilters, snapshot: &Snapshot) -> GetEntitiesResponse {
    let is_admitted = match filter(filters) {
        Ok(is_admitted) => is_admitted,
        Err(result) => return GetEntitiesResponse { result, entities: Vec::new() },
    };
    let robots = snapshot.robots.iter().filter(|robot| is_admitted(robot));
    let entities = robots.map(|robot| robot_name(robot.id)).collect();
    GetEntitiesResponse { result: Result::ok(), entities }
}

/// Returns a test of robots.
fn filter(filters: &EntityFilters) -> std::result::Result<impl Fn(&Robot) -> bool + '_, Result> {
    let unsupported = |reason: &str| Err(Result::failed(code::FEATURE_UNSUPPORTED, reason));
    let Bounds { r#type: kind, points } = &filters.bounds;
    match (*kind, points.len()) {
        _ if !filters.tags.tags.is_empty() => return unsupported("robots have no tags"),
        (NO_BOUNDS, _) | (BOX | SPHERE, 2) => {}
        _ => return unsupported("bounds are a box or a sphere, of two points"),
    }
    if filters.filter.len() > MAX_PATTERN_BYTES {
        return unsupported("the pattern of names is too long");
    }
    let pattern = match Regex::new(&filters.filter) {
        Ok(pattern) => (!filters.filter.is_empty()).then_some(pattern),
        Err(error) => return Err(Result::failed(code::OPERATION_FAILED, error)),
    };
    let categories = &filters.categories;
    let has_robots = categories.is_empty() || categories.iter().any(|it| it.category == ROBOT);
    Ok(move |robot: &Robot| {
        has_robots
            && is_within(robot, *kind, points)
            && pattern.as_ref().is_none_or(|pattern| pattern.is_match(&robot_name(robot.id)))
    })
}

/// Whether a robot's position is within bounds, on the ground.
fn is_within(robot: &Robot, kind: u8, points: &[Vector3]) -> bool {
    let (Some(first), Some(second)) = (points.first(), points.get(1)) else { return true };
    let is_between =
        |at: f64, one: f64, other: f64| (one.min(other)..=one.max(other)).contains(&at);
    match kind {
        BOX => is_between(robot.x, first.x, second.x) && is_between(robot.y, first.y, second.y),
        SPHERE => (robot.x - first.x).hypot(robot.y - first.y) <= second.x,
        _ => true,
    }
}

/// The robot that is meant by a name.
pub(super) fn find<'snapshot>(
    entity: &str,
    snapshot: &'snapshot Snapshot,
) -> std::result::Result<&'snapshot Robot, Result> {
    let robot = robot_number(entity).and_then(|robot| snapshot.robot(robot));
    robot.ok_or_else(|| {
        Result::failed(code::NOT_FOUND, format_args!("no robot is called '{entity}'"))
    })
}

pub(super) fn entity_state(entity: &str, snapshot: &Snapshot) -> GetEntityStateResponse {
    match find(entity, snapshot) {
        Ok(robot) => GetEntityStateResponse {
            result: Result::ok(),
            state: EntityState {
                header: Header::new(&snapshot.stamp(), MAP),
                pose: robot.pose(),
                twist: robot.twist_on_map(),
                ..EntityState::default()
            },
        },
        Err(result) => GetEntityStateResponse { result, ..Default::default() },
    }
}

/// The type and the node of a robot to spawn.
pub(super) fn robot_to_spawn(
    request: &SpawnEntityRequest,
    map: &Map,
) -> std::result::Result<(u32, u32), Result> {
    let SpawnEntityRequest { entity_resource: Resource { uri, resource_string }, .. } = request;
    if !request.allow_renaming {
        let reason = "robots are called robot_N; ask for it with allow_renaming";
        return Err(Result::failed(code::NAME_INVALID, reason));
    }
    if uri.is_empty() && !resource_string.is_empty() {
        let reason = "robots are spawned by the name of their type, as uri";
        return Err(Result::failed(code::UNSUPPORTED_FORMAT, reason));
    }
    let kind = match map.robot_types.iter().position(|name| name == uri) {
        Some(kind) => kind,
        None if uri.is_empty() => 0,
        None => {
            let known = map.robot_types.join(", ");
            let reason = format_args!("no robot type is called '{uri}'; there are {known}");
            return Err(Result::failed(code::UNSUPPORTED_FORMAT, reason));
        }
    };
    let mut pose = request.initial_pose.clone();
    if pose.header.frame_id == "world" {
        pose.header.frame_id.clear();
    }
    let place = map.goal(&pose).map_err(|error| Result::failed(code::INVALID_POSE, error))?;
    Ok((kind as u32, place.node))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{NO_EDGE, RobotState};

    use super::*;

    fn snapshot() -> Snapshot {
        let robot = |id| Robot {
            id,
            x: f64::from(id),
            y: 0.0,
            theta: 0.0,
            speed: 0.0,
            edge: NO_EDGE,
            state: RobotState::Idle,
        };
        Snapshot { robots: (0..12).map(robot).collect(), ..Snapshot::default() }
    }

    fn names(filters: &EntityFilters) -> Vec<String> {
        entities(filters, &snapshot()).entities
    }

    #[test]
    fn entities_are_filtered() {
        assert_eq!(names(&EntityFilters::default()).len(), 12);
        let pattern =
            |filter: &str| EntityFilters { filter: filter.to_owned(), ..Default::default() };
        assert_eq!(names(&pattern("^robot_1[01]$")), ["robot_10", "robot_11"]);
        let wrong = entities(&pattern("("), &snapshot());
        assert_eq!((wrong.result.result, wrong.entities.len()), (code::OPERATION_FAILED, 0));
        let point = |x, y| Vector3 { x, y, z: 0.0 };
        let bounds = |r#type, points| EntityFilters {
            bounds: Bounds { r#type, points },
            ..Default::default()
        };
        assert_eq!(names(&bounds(SPHERE, vec![point(4.0, 0.0), point(1.5, 0.0)])).len(), 3);
        assert_eq!(names(&bounds(BOX, vec![point(9.0, 1.0), point(2.5, -1.0)])).len(), 7);
        let hull = entities(&bounds(2, vec![point(0.0, 0.0); 3]), &snapshot());
        assert_eq!(hull.result.result, code::FEATURE_UNSUPPORTED);
        let humans = EntityFilters {
            categories: vec![EntityCategory { category: 2 }],
            ..Default::default()
        };
        assert!(names(&humans).is_empty());
    }

    #[test]
    fn unknown_entities_are_not_found() {
        let found = entity_state("robot_3", &snapshot());
        assert_eq!((found.result.result, found.state.pose.position.x), (code::OK, 3.0));
        for name in ["robot_12", "robot_03", "", "\u{0}"] {
            let state = entity_state(name, &snapshot());
            assert_eq!(state.result.result, code::NOT_FOUND, "{name}");
        }
    }
}
