//! The figures of a run, from what the meter, the judge and the validator have seen.

use regatta_study::master::{Base, Breach, RawFigures, Transport};
use regatta_study::outcome::examples;
use regatta_vda5050::judge::{Report, Rule};
use regatta_vda5050::meter::{BaseWait, Figures};
use serde_json::Value;

use super::site::Site;
use crate::failure::Failure;
use crate::lockstep_run::findings;

/// The validator's name for a contact.
const CONTACT: &str = "contact";

/// Returns the figures of a run of `secs` seconds from the master's first order on.
///
/// # Errors
/// If the validator's report is of another form.
pub fn raw(
    site: &Site<'_>,
    secs: f64,
    seen: Figures,
    report: &Report,
    validator: &Value,
) -> Result<RawFigures, Failure> {
    let start = seen.first_order.unwrap_or_default();
    let transports = seen.finished.iter().map(|finished| Transport {
        at_secs: finished.time - start,
        service_secs: finished.service_secs,
    });
    let contacts = findings(validator).find(|(kind, _)| kind == CONTACT);
    let first_contact = examples(validator)?.remove(CONTACT);
    Ok(RawFigures {
        secs,
        orders: seen.orders,
        never_ordered: seen.never_ordered,
        bases: seen.bases.iter().map(|wait| base(site, wait)).collect(),
        transports: transports.collect(),
        open_orders: seen.open_orders,
        idle_secs: seen.idle_secs,
        errors: seen.errors,
        breaches: breaches(report),
        contacts: contacts.map_or(0, |(_, count)| count),
        first_contact: first_contact.map(|example| example.to_string()),
    })
}

fn base(site: &Site<'_>, wait: &BaseWait) -> Base {
    let edges = wait.edges.each_ref().map(|edge| site.edge(edge.as_ref()?));
    Base {
        vehicle: wait.vehicle.rsplit('/').next().unwrap_or_default().to_owned(),
        node: wait.node.clone(),
        next_node: wait.next_node.clone(),
        edges,
        secs: wait.secs,
        standing_secs: wait.standing_secs,
        is_of_master: wait.answer.is_of_master(),
        is_missing: wait.answer.is_missing(),
    }
}

fn breaches(report: &Report) -> Vec<Breach> {
    let mut breaches = Vec::new();
    for (row, count, first) in report.rules() {
        // The validator counts contacts, with the poses of all ticks.
        let Some(first) = first.filter(|_| row.rule != Rule::Contact) else { continue };
        let (severity, vehicle): (&str, _) =
            (row.severity.into(), first.vehicle.rsplit('/').next());
        breaches.push(Breach {
            rule: row.rule.id().to_owned(),
            requirement: row.requirement.to_owned(),
            side: first.side_name().to_owned(),
            severity: severity.to_owned(),
            clause: format!("VDA 5050 {}, {}", first.version, first.clause),
            count,
            example: format!("vehicle {}: {}", vehicle.unwrap_or_default(), first.message),
        });
    }
    breaches
}
