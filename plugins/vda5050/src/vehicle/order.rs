//! Orders and their updates: figure 8 of the standard (2.x: 6.6.2, 6.6.4; 3.0: 6.1.2, 6.1.4).

use super::check::{Plan, check_form, check_map, is_near, plan};
use super::errors::{Cause, Fault, Until};
use super::jobs::Job;
use super::{Site, Vehicle};
use crate::message::{DecodeError, Order, Version};

/// The order that a vehicle has, or had last.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Its last update, as it was sent.
    pub last: Order,
    pub end: End,
}

/// Whether an order may be continued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Open,
    Cancelled,
}

/// The decision about an order.
enum Decision {
    Begin(Plan),
    Continue(Plan),
    /// It is there already.
    Ignore,
}

impl Vehicle {
    /// Takes an order or an update, or rejects it with an error.
    pub fn take_order(&mut self, order: Order, site: &Site) {
        match self.decide(&order, site) {
            Ok(Decision::Ignore) => {}
            Ok(Decision::Begin(_)) if self.fate.refuses_order() => {
                let reason = "a disturbance lets the vehicle refuse this order";
                self.report(Fault::new(Cause::NoRoute, reason).about_order(&order));
            }
            Ok(Decision::Begin(plan)) => self.begin(order, plan, site),
            Ok(Decision::Continue(plan)) => self.carry_on(order, plan, site),
            Err(fault) => self.report(fault),
        }
    }

    /// Rejects a message that can't be read.
    pub fn take_broken(&mut self, topic: &str, error: &DecodeError) {
        let mut fault = Fault::new(Cause::Malformed, error.reason()).about("topic", topic);
        for field in ["headerId", "orderId", "orderUpdateId"] {
            if let Some(value) = error.field(field) {
                fault = fault.about(field, value);
            }
        }
        self.report(fault);
    }

    fn decide(&self, order: &Order, site: &Site) -> Result<Decision, Fault> {
        check_form(order)?;
        match self.order.as_ref().filter(|held| held.last.order_id == order.order_id) {
            Some(held) => self.decide_on_update(held, order, site),
            None => self.decide_on_new(order, site),
        }
    }

    fn decide_on_new(&self, order: &Order, site: &Site) -> Result<Decision, Fault> {
        if !self.is_idle() {
            return Fault::reject(order, Cause::OtherOrderActive, "another order is active");
        }
        if self.version == Version::V3_0 && order.order_update_id != 0 {
            return Fault::reject(
                order,
                Cause::NotAContinuation,
                "a new order begins with the update 0",
            );
        }
        if self.is_broken() {
            return Fault::reject(order, Cause::NotAvailable, "the vehicle is broken");
        }
        if let Some(reason) = self.condition.refusal() {
            return Fault::reject(order, Cause::NotAvailable, reason);
        }
        let first = &order.nodes[0];
        if first.sequence_id != 0 {
            return Fault::reject(order, Cause::Malformed, "a new order begins with the place 0");
        }
        check_map(order, first, &site.map)?;
        let near = self.seen.is_some_and(|seen| is_near(first, seen.x, seen.y));
        let Some(here) =
            self.here.filter(|here| near || site.map.find_node(&first.node_id) == Some(*here))
        else {
            let reason = format!("the vehicle isn't at the first node '{}'", first.node_id);
            let fault = Fault::new(Cause::StartOutOfRange, reason).about_order(order);
            return Err(fault.about("nodeId", &first.node_id));
        };
        Ok(Decision::Begin(plan(order, here, &site.map, &site.catalogue)?))
    }

    fn decide_on_update(&self, held: &Held, order: &Order, site: &Site) -> Result<Decision, Fault> {
        let current = held.last.order_update_id;
        if order.order_update_id < current {
            return Fault::reject(
                order,
                Cause::OutdatedUpdate,
                &format!("the update {current} is there already"),
            );
        }
        if order.order_update_id == current && self.is_same(&held.last, order) {
            return Ok(Decision::Ignore);
        }
        if held.end == End::Cancelled || self.cancelling.is_some() {
            return Fault::reject(order, Cause::UpdateAfterCancel, "the order was cancelled");
        }
        if order.order_update_id == current {
            return Fault::reject(
                order,
                Cause::SameUpdate,
                "another update with this number is there already",
            );
        }
        let (node, place) = &self.progress.base_end;
        if (&order.nodes[0].node_id, &order.nodes[0].sequence_id) != (node, place) {
            let reason = format!("the base ends at '{node}', place {place}, not where this begins");
            return Fault::reject(order, Cause::NotAContinuation, &reason);
        }
        let mut plan = plan(order, self.progress.end_place, &site.map, &site.catalogue)?;
        // The decision point is sent again; its actions are there already.
        plan.jobs.retain(|job| job.sequence_id > *place);
        match plan.jobs.iter().find(|job| self.has_job_of_base(job)) {
            None => Ok(Decision::Continue(plan)),
            Some(job) => {
                let id = &job.action.action_id;
                let reason = format!("the action '{id}' is in the order already");
                Err(Fault::new(Cause::Malformed, reason).about_order(order).about("actionId", id))
            }
        }
    }

    /// Whether an update is the current one, sent again. 2.x doesn't look at its content.
    fn is_same(&self, current: &Order, order: &Order) -> bool {
        self.version != Version::V3_0
            || (&current.nodes, &current.edges) == (&order.nodes, &order.edges)
    }

    fn has_job_of_base(&self, job: &Job) -> bool {
        let mut jobs = self.jobs.iter();
        jobs.any(|known| {
            known.sequence_id <= self.progress.base_end.1
                && known.action.action_id == job.action.action_id
        })
    }

    fn begin(&mut self, order: Order, plan: Plan, site: &Site) {
        let first = &order.nodes[0];
        self.jobs.clear();
        if self.version != Version::V3_0 {
            self.instants.forget_ended();
        }
        self.progress.begin(first, self.here);
        plan.jobs.into_iter().for_each(|job| self.jobs.push(job));
        self.jobs.trigger(first.sequence_id);
        self.progress.append(plan.steps);
        self.accept(order, site);
    }

    fn carry_on(&mut self, order: Order, plan: Plan, site: &Site) {
        self.jobs.forget_after(self.progress.base_end.1);
        plan.jobs.into_iter().for_each(|job| self.jobs.push(job));
        self.progress.append(plan.steps);
        self.accept(order, site);
    }

    fn accept(&mut self, order: Order, site: &Site) {
        self.order = Some(Held { last: order, end: End::Open });
        self.forget_faults(Until::NewOrder);
        self.advance(site);
    }
}
