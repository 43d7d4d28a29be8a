//! The actions that a vehicle can carry out, and their durations.

use crate::message::{ActionScope, BlockingType, SupportedAction, Version};

/// The effect of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// It takes time.
    Lasts,
    /// It takes a load.
    Picks,
    /// It leaves a load.
    Drops,
    /// It begins to charge.
    Charges,
    /// It ends the charging.
    EndsCharging,
    /// It waits for a trigger.
    Waits,
    /// It ends waiting.
    Triggers,
    /// It pauses the vehicle.
    Pauses,
    /// It ends a pause.
    Resumes,
    /// It cancels the order.
    Cancels,
    /// It asks for a state.
    AsksForState,
    /// It asks for the factsheet.
    AsksForFactsheet,
    /// It says where the vehicle is.
    Localizes,
    /// It tries a failed action again.
    Retries,
    /// It lets a failed action fail.
    GivesUp,
    /// It clears the list of instant actions.
    Clears,
}

/// An action that vehicles can carry out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ability {
    pub name: String,
    pub effect: Effect,
    pub scopes: &'static [ActionScope],
    /// Simulated seconds; `None` if something else ends it.
    pub seconds: Option<f64>,
}

/// The actions of a fleet's vehicles.
#[derive(Clone, Debug, PartialEq)]
pub struct Catalogue {
    abilities: Vec<Ability>,
}

const INSTANT: &[ActionScope] = &[ActionScope::Instant];
const NODE: &[ActionScope] = &[ActionScope::Node];
const ORDER: &[ActionScope] = &[ActionScope::Node, ActionScope::Edge];
const INSTANT_NODE: &[ActionScope] = &[ActionScope::Instant, ActionScope::Node];

/// The actions of the standard that vehicles carry out, and their durations in seconds.
const STANDARD: &[(&str, Effect, &[ActionScope], Option<f64>)] = &[
    ("pick", Effect::Picks, ORDER, Some(10.0)),
    ("drop", Effect::Drops, ORDER, Some(10.0)),
    ("detectObject", Effect::Lasts, ORDER, Some(2.0)),
    ("finePositioning", Effect::Lasts, ORDER, Some(2.0)),
    ("waitForTrigger", Effect::Waits, NODE, None),
    ("trigger", Effect::Triggers, INSTANT, Some(0.0)),
    ("startCharging", Effect::Charges, INSTANT_NODE, Some(1.0)),
    ("stopCharging", Effect::EndsCharging, INSTANT_NODE, Some(1.0)),
    ("initPosition", Effect::Localizes, INSTANT_NODE, Some(0.0)),
    ("initializePosition", Effect::Localizes, INSTANT_NODE, Some(0.0)),
    ("startPause", Effect::Pauses, INSTANT, None),
    ("stopPause", Effect::Resumes, INSTANT, Some(0.0)),
    ("cancelOrder", Effect::Cancels, INSTANT, None),
    ("stateRequest", Effect::AsksForState, INSTANT, Some(0.0)),
    ("factsheetRequest", Effect::AsksForFactsheet, INSTANT, Some(0.0)),
    ("retry", Effect::Retries, INSTANT, Some(0.0)),
    ("skipRetry", Effect::GivesUp, INSTANT, Some(0.0)),
    ("clearInstantActions", Effect::Clears, INSTANT, Some(0.0)),
];

impl Default for Catalogue {
    /// The actions of the standard.
    fn default() -> Self {
        let abilities = STANDARD.iter().map(|&(name, effect, scopes, seconds)| Ability {
            name: name.to_owned(),
            effect,
            scopes,
            seconds,
        });
        Self { abilities: abilities.collect() }
    }
}

impl Catalogue {
    /// Sets the duration of an action in simulated seconds. An action that the standard doesn't
    /// have is added: orders may have it at nodes and edges, and it takes this time.
    pub fn set(&mut self, name: &str, seconds: f64) {
        match self.abilities.iter_mut().find(|ability| ability.name == name) {
            Some(ability) => ability.seconds = Some(seconds),
            None => self.abilities.push(Ability {
                name: name.to_owned(),
                effect: Effect::Lasts,
                scopes: ORDER,
                seconds: Some(seconds),
            }),
        }
    }

    /// The ability for an action, if it may stand there.
    pub(super) fn find(&self, name: &str, scope: ActionScope) -> Option<&Ability> {
        let mut named = self.abilities.iter().filter(|ability| ability.name == name);
        named.find(|ability| ability.scopes.contains(&scope))
    }

    /// The actions as the factsheet lists them.
    pub fn supported(&self, version: Version) -> Vec<SupportedAction> {
        let known = self.abilities.iter().filter(|ability| ability.is_of(version));
        known.map(Ability::supported).collect()
    }
}

impl Ability {
    /// Whether the action can be cancelled once it runs: a load isn't left halfway.
    pub(super) const fn can_be_cancelled(&self) -> bool {
        !matches!(self.effect, Effect::Picks | Effect::Drops)
    }

    /// Whether a version names the action. Those of others are carried out, too.
    fn is_of(&self, version: Version) -> bool {
        let others: &[&str] = match version {
            Version::V2_0 | Version::V2_1 => {
                &["initializePosition", "trigger", "retry", "skipRetry", "clearInstantActions"]
            }
            Version::V3_0 => &["initPosition"],
        };
        !others.contains(&self.name.as_str())
    }

    fn supported(&self) -> SupportedAction {
        use BlockingType::{Hard, None, Single, Soft};
        let is_instant = self.scopes == INSTANT;
        SupportedAction {
            action_type: self.name.clone(),
            action_scopes: self.scopes.to_vec(),
            blocking_types: Some(if is_instant {
                vec![None]
            } else {
                vec![None, Soft, Single, Hard]
            }),
            pause_allowed: Some(!is_instant),
            cancel_allowed: Some(!is_instant && self.can_be_cancelled()),
        }
    }
}
