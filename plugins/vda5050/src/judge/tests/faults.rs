//! Planted faults: each changes one thing in a correct conversation, and its rule finds it.

mod master;
mod message;
mod vehicle;

use strum::IntoEnumIterator;

use super::conversation::Conversation;
use crate::judge::{Finding, Rule};
use crate::message::Version;

/// A rule, the version of the conversation, and the change that breaks the rule.
type Fault = (Rule, Version, fn(&mut Conversation));

const V2_0: Version = Version::V2_0;
const V2_1: Version = Version::V2_1;
const V3_0: Version = Version::V3_0;

fn judged((_, version, plant): &Fault) -> Vec<Finding> {
    let mut talk = Conversation::correct(*version);
    plant(&mut talk);
    talk.judged(100.0)
}

fn all() -> impl Iterator<Item = &'static Fault> {
    message::FAULTS.iter().chain(master::FAULTS).chain(vehicle::FAULTS)
}

#[test]
fn each_planted_fault_is_found() {
    let missed: Vec<_> = all().filter_map(missed).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

/// The findings of a fault, if that of its rule isn't among them.
fn missed(fault: &Fault) -> Option<String> {
    let findings = judged(fault);
    let found = findings.iter().find(|finding| finding.rule == fault.0);
    let is_told = found.is_some_and(|found| !found.message.is_empty() && !found.clause.is_empty());
    let texts: Vec<_> = findings.iter().map(ToString::to_string).collect();
    (!is_told).then(|| format!("{} in {}: {texts:#?}", fault.0.id(), fault.1))
}

#[test]
fn each_rule_has_a_planted_fault() {
    let without: Vec<_> =
        Rule::iter().filter(|rule| all().all(|fault| fault.0 != *rule)).map(Rule::id).collect();
    assert!(without.is_empty(), "{without:?}");
}

/// A fault of one field isn't told as another one: most changes have one finding.
#[test]
fn faults_of_messages_have_one_finding() {
    for fault in message::FAULTS.iter().filter(|fault| fault.0 != Rule::Json) {
        let findings = judged(fault);
        let others: Vec<_> =
            findings.iter().filter(|one| one.rule != fault.0).map(ToString::to_string).collect();
        assert!(others.is_empty(), "{}: {others:#?}", fault.0.id());
    }
}
