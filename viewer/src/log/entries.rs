//! Entries of the log, made of events, contacts and orders.

use regatta_interface::log::{AlarmChange, AlarmKey, Entry, Kind, Place, Severity};
use regatta_kit::dispatch::refusal_text;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::event::{BreakdownCause, EventKind, EventRecord};
use regatta_plugin::order::{NO_ROBOT, OrderKind, OrderRecord};

/// Returns the entry of an event; `None` if it is routine, as reached nodes are.
pub(super) fn of_event(event: &EventRecord, time_nanos: u64) -> Option<(Entry, AlarmChange)> {
    use EventKind::{
        ActionFailed, BrokenDown, EdgeClosed, EdgeOpened, Faulted, Held, Recovered, Refused,
        Removed, Repaired, Resumed, Spawned, Stalled,
    };
    let (robot, id) = (event.robot, event.id);
    let is_flat = event.detail == BreakdownCause::FlatBattery as u32;
    let kind = event.kind()?;
    let (group, severity, text) = match kind {
        BrokenDown if is_flat => {
            (Kind::Fault, Severity::Alarm, format!("robot {robot}: battery flat"))
        }
        BrokenDown => (Kind::Fault, Severity::Alarm, format!("robot {robot} broke down")),
        Faulted => (Kind::Fault, Severity::Alarm, format!("robot {robot} can't continue")),
        ActionFailed => {
            let text = format!("robot {robot}: its action at node {id} failed");
            (Kind::Order, Severity::Warning, text)
        }
        Repaired => (Kind::Fault, Severity::Info, format!("robot {robot} repaired")),
        Stalled => (Kind::Stop, Severity::Warning, format!("robot {robot} stalls")),
        Recovered => (Kind::Stop, Severity::Info, format!("robot {robot} no longer stalls")),
        Held => (Kind::Stop, Severity::Warning, format!("robot {robot} stands, held")),
        Resumed => (Kind::Stop, Severity::Info, format!("robot {robot} resumed")),
        Refused if robot == NO_ROBOT => {
            let text = format!("a command was refused: {}", refusal_text(event));
            (Kind::Order, Severity::Warning, text)
        }
        Refused => {
            let text = format!("robot {robot}: command refused: {}", refusal_text(event));
            (Kind::Order, Severity::Warning, text)
        }
        Spawned => (Kind::Robot, Severity::Info, format!("robot {robot} joined")),
        Removed => (Kind::Robot, Severity::Info, format!("robot {robot} left")),
        EdgeClosed => (Kind::Edge, Severity::Warning, format!("edge {id} closed")),
        EdgeOpened => (Kind::Edge, Severity::Info, format!("edge {id} opened")),
        _ => return None,
    };
    let change = match kind {
        BrokenDown | Faulted => AlarmChange::Begins(AlarmKey::Robot(robot)),
        Repaired | Removed => AlarmChange::Ends(AlarmKey::Robot(robot)),
        EdgeClosed => AlarmChange::Begins(AlarmKey::Edge(id)),
        EdgeOpened => AlarmChange::Ends(AlarmKey::Edge(id)),
        _ => AlarmChange::None,
    };
    let place = if group == Kind::Edge { Place::Edge(id) } else { Place::None };
    let robot = Some(robot).filter(|robot| *robot != NO_ROBOT);
    Some((Entry { time_nanos, kind: group, severity, robot, place, text }, change))
}

/// Returns the entry of a contact that began or ended; `None` for one that was only possible.
pub(super) fn of_contact(event: &ContactEvent) -> Option<(Entry, AlarmChange)> {
    let ([one, other], key) = (event.robots, AlarmKey::Contact(event.robots));
    if event.level != ContactLevel::Touching as u32 {
        return None;
    }
    let begins = event.change == ContactChange::Began as u32;
    let (severity, change, text) = match begins {
        true => {
            (Severity::Alarm, AlarmChange::Begins(key), format!("robots {one} and {other} touch"))
        }
        false => (
            Severity::Info,
            AlarmChange::Ends(key),
            format!("robots {one} and {other} are apart again"),
        ),
    };
    let place = Place::At { x: event.x, y: event.y };
    let entry = Entry {
        time_nanos: event.sim_time_nanos,
        kind: Kind::Contact,
        severity,
        robot: Some(one),
        place,
        text,
    };
    Some((entry, change))
}

/// Returns the entry of a transport order that came to a bad end.
pub(super) fn of_order(order: &OrderRecord, time_nanos: u64) -> Option<(Entry, AlarmChange)> {
    let (severity, what) = match order.kind()? {
        OrderKind::Unroutable => (Severity::Warning, format!("waits: {}", order.obstacle().text())),
        OrderKind::Failed => (Severity::Warning, "failed".to_owned()),
        OrderKind::Cancelled => (Severity::Info, "was cancelled".to_owned()),
        // Short, so that a row has room for it.
        OrderKind::Withdrawn => (Severity::Info, "withdrawn".to_owned()),
        OrderKind::Reopened => (Severity::Info, "can be carried out again".to_owned()),
        _ => return None,
    };
    let robot = Some(order.robot).filter(|robot| *robot != NO_ROBOT);
    let by = robot.map(|robot| format!(" (robot {robot})")).unwrap_or_default();
    let text = format!("order {} {what}{by}", order.order);
    Some((
        Entry { time_nanos, kind: Kind::Order, severity, robot, place: Place::None, text },
        AlarmChange::None,
    ))
}
