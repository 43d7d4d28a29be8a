//! The actions of a vehicle: those that the master has sent, and how their states change.

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding::{Notes, quoted};
use super::route::Route;
use super::rule::Rule;
use crate::message::{Action, ActionState, ActionStatus, BlockingType, Order, State};

/// Seconds within which a state has to answer.
pub(super) const ANSWER: f64 = 10.0;
/// The newest actions of a vehicle that are known, and as many before those.
const MOST_ACTIONS: usize = 10_000;

/// The actions that a master has sent to a vehicle.
#[derive(Debug, Default)]
pub(super) struct Actions {
    known: FxHashMap<String, Known>,
    /// Those before, which are forgotten when there are too many new ones.
    older: FxHashMap<String, Known>,
    /// The instant actions that no state has shown yet.
    waiting: Vec<Waiting>,
}

#[derive(Debug)]
struct Known {
    kind: String,
    blocking: BlockingType,
    origin: Origin,
}

#[derive(Debug)]
struct Waiting {
    id: String,
    kind: String,
    time: f64,
}

/// The message that an action came with.
#[derive(Debug, PartialEq, Eq)]
enum Origin {
    Order(String),
    Instant(Outlook),
}

/// Whether an instant action can be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outlook {
    /// The vehicle decides.
    Open,
    /// It is to cancel an order, and there is none.
    Vain,
}

impl Actions {
    /// Notes the actions of an order.
    pub fn add_order(&mut self, order: &Order, notes: &mut Notes<'_>) {
        let origin = Origin::Order(order.order_id.clone());
        let of_nodes = order.nodes.iter().flat_map(|node| &node.actions);
        let actions: Vec<_> =
            of_nodes.chain(order.edges.iter().flat_map(|edge| &edge.actions)).collect();
        let mut ids: Vec<_> = actions.iter().map(|action| &action.action_id).collect();
        ids.sort_unstable();
        if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            let id = quoted(pair[0]);
            notes.add(Rule::ActionIdTwice, format!("action id {id} stands twice in the order"));
        }
        for action in actions {
            // Horizon and stitching node are sent again with their actions.
            let is_again = self
                .get(&action.action_id)
                .is_some_and(|known| known.origin == origin && known.kind == action.action_type);
            if !is_again {
                self.add(action, Origin::Order(order.order_id.clone()), notes);
            }
        }
    }

    /// Notes an instant action.
    pub fn add_instant(
        &mut self,
        action: &Action,
        now: f64,
        outlook: Outlook,
        notes: &mut Notes<'_>,
    ) {
        let (id, kind) = (action.action_id.clone(), action.action_type.clone());
        self.add(action, Origin::Instant(outlook), notes);
        if self.waiting.len() < MOST_ACTIONS {
            self.waiting.push(Waiting { id, kind, time: now });
        }
    }

    fn add(&mut self, action: &Action, origin: Origin, notes: &mut Notes<'_>) {
        if self.known.len() >= MOST_ACTIONS {
            self.older = core::mem::take(&mut self.known);
        }
        let known =
            Known { kind: action.action_type.clone(), blocking: action.blocking_type, origin };
        let old = self.known.insert(action.action_id.clone(), known);
        if let Some(old) = old.as_ref().or_else(|| self.older.get(&action.action_id)) {
            let (id, kind) = (quoted(&action.action_id), quoted(&old.kind));
            notes.add(Rule::ActionIdTwice, format!("action id {id} was that of {kind} before"));
        }
    }

    /// Whether an action was to be carried out at once.
    pub fn is_instant(&self, id: &str) -> bool {
        self.get(id).is_some_and(|known| matches!(known.origin, Origin::Instant(_)))
    }

    fn get(&self, id: &str) -> Option<&Known> {
        self.known.get(id).or_else(|| self.older.get(id))
    }

    /// Judges the states of actions after those before.
    pub fn judge(&self, state: &State, before: Option<&State>, notes: &mut Notes<'_>) {
        let before = by_id(before);
        for now in all(state) {
            let old = before.get(now.action_id.as_str()).copied();
            if let Some(old) = old {
                judge_change(old, now, notes);
            }
            if old.is_none_or(|old| old.action_status != now.action_status) {
                self.judge_end(now, state, notes);
            }
        }
        self.judge_blocking(state, notes);
    }

    /// Judges that states of actions are those of actions that were sent.
    pub fn judge_known(&self, route: &Route, state: &State, notes: &mut Notes<'_>) {
        let of_order: FxHashSet<_> = route.actions().map(|action| &action.action_id).collect();
        for shown in all(state).filter(|shown| !of_order.contains(&shown.action_id)) {
            if self.get(&shown.action_id).is_none() {
                let id = quoted(&shown.action_id);
                notes.add(Rule::ActionStateUnknown, format!("action {id} was never sent"));
            }
        }
    }

    /// Judges an action whose status is new.
    fn judge_end(&self, now: &ActionState, state: &State, notes: &mut Notes<'_>) {
        let Some(known) = self.get(&now.action_id) else { return };
        let Origin::Instant(outlook) = known.origin else { return };
        let has_ended_well = now.action_status == ActionStatus::Finished;
        match (known.kind.as_str(), outlook) {
            ("cancelOrder", Outlook::Vain) => judge_vain_cancel(now, state, notes),
            ("cancelOrder", Outlook::Open) if has_ended_well => judge_cancel(state, notes),
            ("startPause", _) if has_ended_well && state.paused != Some(true) => {
                notes.add(Rule::PauseUntold, "startPause is finished, paused isn't true".into());
            }
            ("stopPause", _) if has_ended_well && state.paused == Some(true) => {
                notes.add(Rule::PauseUntold, "stopPause is finished, paused is true".into());
            }
            _ => {}
        }
    }

    fn judge_blocking(&self, state: &State, notes: &mut Notes<'_>) {
        let running = state.action_states.iter();
        let running: Vec<_> = running
            .filter(|shown| shown.action_status == ActionStatus::Running)
            .filter_map(|shown| Some((&shown.action_id, self.get(&shown.action_id)?)))
            .filter(|(_, known)| matches!(known.origin, Origin::Order(_)))
            .collect();
        if let Some((id, known)) = running.iter().find(|(_, known)| known.blocking.stops_driving())
            && state.driving
        {
            let (id, kind) = (quoted(id), quoted(&known.kind));
            let text = format!("driving while action {id} ({kind}, {:?}) runs", known.blocking);
            notes.add(Rule::DrivingWithAction, text);
        }
        if let Some((id, known)) = running.iter().find(|(_, known)| known.blocking.is_alone())
            && running.len() > 1
        {
            let (id, others) = (quoted(id), running.len() - 1);
            let text = format!("{others} more run beside action {id} ({:?})", known.blocking);
            notes.add(Rule::ActionsInParallel, text);
        }
    }

    /// Forgets the instant actions that a state has answered.
    pub fn answer(&mut self, state: &State) {
        if self.waiting.is_empty() {
            return;
        }
        let references = state.errors.iter().flat_map(|error| &error.error_references);
        let about = references.filter(|reference| reference.reference_key == "actionId");
        let told: FxHashSet<_> = about.map(|reference| &reference.reference_value).collect();
        let shown = by_id(Some(state));
        self.waiting.retain(|waiting| {
            !told.contains(&waiting.id) && !shown.contains_key(waiting.id.as_str())
        });
    }

    /// Tells the instant actions that weren't answered in time.
    pub fn watch(&mut self, now: f64, notes: &mut Notes<'_>) {
        self.waiting.retain(|waiting| {
            let is_late = now - waiting.time > ANSWER;
            if is_late {
                let (id, kind) = (quoted(&waiting.id), quoted(&waiting.kind));
                let text = format!("no state has action {id} ({kind}) after {ANSWER} s");
                notes.add(Rule::ActionUnanswered, text);
            }
            !is_late
        });
    }
}

/// The states of all actions.
pub(super) fn all(state: &State) -> impl Iterator<Item = &ActionState> {
    state.action_states.iter().chain(state.instant_action_states.iter().flatten())
}

/// The states of all actions by their ids.
fn by_id(state: Option<&State>) -> FxHashMap<&str, &ActionState> {
    let states = state.into_iter().flat_map(all);
    states.map(|shown| (shown.action_id.as_str(), shown)).collect()
}

/// Judges that each action of the order has a state.
pub(super) fn judge_complete(
    route: &Route,
    state: &State,
    before: Option<&State>,
    notes: &mut Notes<'_>,
) {
    let (shown, before) = (by_id(Some(state)), by_id(before));
    for action in route.actions() {
        if shown.contains_key(action.action_id.as_str()) {
            continue;
        }
        let id = quoted(&action.action_id);
        if before.contains_key(action.action_id.as_str()) {
            let text = format!("the state of action {id} is gone");
            notes.add(Rule::ActionStateDropped, text);
        } else {
            notes.add(Rule::ActionStateMissing, format!("action {id} has no state"));
        }
    }
}

/// Judges a change of a status. States may leave out those between.
fn judge_change(old: &ActionState, now: &ActionState, notes: &mut Notes<'_>) {
    let (from, to) = (old.action_status, now.action_status);
    let is_back = match (from, to) {
        _ if from == to => false,
        (_, ActionStatus::Waiting) => true,
        (ActionStatus::Running, ActionStatus::Initializing) => true,
        _ => from.is_over(),
    };
    if is_back {
        let id = quoted(&now.action_id);
        notes.add(Rule::ActionStatus, format!("action {id} goes from {from:?} to {to:?}"));
    }
}

fn judge_cancel(state: &State, notes: &mut Notes<'_>) {
    let left = state.node_states.len();
    if left > 0 || state.driving {
        let drives = if state.driving { "drives" } else { "stands" };
        let text = format!("cancelOrder is finished, the vehicle {drives} and has {left} nodes");
        notes.add(Rule::CancelledOrderKept, text);
    }
}

fn judge_vain_cancel(now: &ActionState, state: &State, notes: &mut Notes<'_>) {
    let has_error = state.errors.iter().any(|error| {
        ["noOrderToCancel", "NO_ORDER_TO_CANCEL"].contains(&error.error_type.as_str())
    });
    match now.action_status {
        ActionStatus::Failed if has_error => {}
        ActionStatus::Failed => {
            let text = "cancelOrder failed without an order, and no error says so".to_owned();
            notes.add(Rule::CancelNotRefused, text);
        }
        ActionStatus::Finished => {
            let text = "cancelOrder is finished, but there was no order".to_owned();
            notes.add(Rule::CancelNotRefused, text);
        }
        _ => {}
    }
}
