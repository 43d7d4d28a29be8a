//! The thread that sends the user's orders, and reports their answers.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use regatta_interface::orders::UserOrder;
use regatta_kit::{DispatchError, Dispatcher, WayError};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::manager::{ManagerAnswer, ManagerResponse};
use regatta_plugin::{FleetName, ManagerClient, ManagerError, Orders, Result};

use super::report::Report;

/// The time between two looks for answers.
const POLL: Duration = Duration::from_millis(20);
/// The time after which the user is told that an order has no answer yet. The answer is told
/// whenever it comes.
const PATIENCE: Duration = Duration::from_secs(2);
/// The longest wait for the world, before a robot is sent.
const WORLD: Duration = Duration::from_secs(2);

/// Sends orders until the link is dropped. The fleet is joined with the first one, and left when
/// all are answered.
pub fn run(fleet: &FleetName, requested: &Receiver<UserOrder>, report: &Sender<Report>) -> Result {
    while let Ok(first) = requested.recv() {
        let outcome = serve(fleet, first, requested, report);
        let outcome = outcome.map_err(|error| format!("can't give orders: {error}"));
        if outcome.is_err_and(|text| report.send(Report::Notice(text)).is_err()) {
            break;
        }
    }
    Ok(())
}

fn serve(
    fleet: &FleetName,
    first: UserOrder,
    requested: &Receiver<UserOrder>,
    report: &Sender<Report>,
) -> Result<(), DispatchError> {
    let dispatcher = Dispatcher::join(fleet, "viewer-orders", WORLD)?;
    let mut pending = PendingOrders {
        dispatcher,
        manager: ManagerClient::open(fleet)?,
        waiting: BTreeMap::new(),
    };
    let mut next = Some(first);
    loop {
        let orders = next.into_iter().chain(requested.try_iter());
        let mut told: Vec<Report> = orders.filter_map(|order| pending.give(order)).collect();
        told.extend(pending.answers()?.into_iter().map(Report::Notice));
        if told.into_iter().any(|told| report.send(told).is_err()) || pending.waiting.is_empty() {
            return Ok(());
        }
        next = match requested.recv_timeout(POLL) {
            Ok(order) => Some(order),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        };
    }
}

/// Orders that are being carried out.
struct PendingOrders {
    dispatcher: Dispatcher,
    manager: ManagerClient,
    /// By token: the order, when it was sent, and whether the user knows that it waits.
    waiting: BTreeMap<u64, (UserOrder, Instant, bool)>,
}

impl PendingOrders {
    /// Sends an order. Returns what to tell now: the fleet manager's answer, or why the order can't
    /// be sent.
    fn give(&mut self, order: UserOrder) -> Option<Report> {
        match order {
            UserOrder::SendByManager { robot, node } => {
                Some(asked(order, self.manager.send(robot, node)))
            }
            UserOrder::Recall(robot) => Some(asked(order, self.manager.recall(robot))),
            _ => match self.send(order) {
                Ok(token) => {
                    self.waiting.insert(token, (order, Instant::now(), false));
                    None
                }
                Err(error) => Some(Report::Refused(order, format!("can't {order}: {error}"))),
            },
        }
    }

    fn send(&mut self, order: UserOrder) -> Result<u64, DispatchError> {
        let UserOrder::Send { robot, node } = order else {
            return Ok(self
                .dispatcher
                .give(|orders| collect(order, orders).unwrap_or_default())?);
        };
        let legs = self.dispatcher.way(
            robot,
            |world| {
                let found = world.nodes().iter().position(|other| other.id == node);
                found.ok_or_else(|| WayError::UnknownNode(node.to_string()))
            },
            false,
        )?;
        Ok(self.dispatcher.give(|orders| orders.assign(robot, &legs))?)
    }

    /// What to tell of answers that have come, or not.
    fn answers(&mut self) -> Result<Vec<String>, DispatchError> {
        let mut told = Vec::new();
        for answer in self.dispatcher.answers()? {
            if let Some((order, ..)) = self.waiting.remove(&answer.token) {
                told.push(text(order, answer));
            }
        }
        for (order, since, is_told) in
            self.waiting.values_mut().filter(|(_, since, _)| since.elapsed() > PATIENCE)
        {
            if !std::mem::replace(is_told, true) {
                let secs = since.elapsed().as_secs();
                told.push(format!(
                    "{order}: no answer for {secs} s; a paused fleet takes it at its next tick"
                ));
            }
        }
        Ok(told)
    }
}

/// Collects the order, and returns its token; `None` for one that needs a way, or is for the
/// fleet manager.
fn collect(order: UserOrder, orders: &mut Orders) -> Option<u64> {
    Some(match order {
        UserOrder::Hold(robot) => orders.hold(robot),
        UserOrder::Resume(robot) => orders.resume(robot),
        UserOrder::Break(robot) => orders.break_down(robot),
        UserOrder::Repair(robot) => orders.repair(robot),
        UserOrder::Cancel(robot) => orders.cancel(robot),
        UserOrder::Close(edge) => orders.close_edge(edge),
        UserOrder::Open(edge) => orders.open_edge(edge),
        UserOrder::Send { .. } | UserOrder::SendByManager { .. } | UserOrder::Recall(_) => {
            return None;
        }
    })
}

/// What to tell of a request to the fleet manager.
fn asked(order: UserOrder, answer: Result<ManagerResponse, ManagerError>) -> Report {
    match answer.map(|response| response.answer()) {
        Ok(Some(ManagerAnswer::Later)) => {
            Report::Notice(format!("accepted: {order}, when its order is finished"))
        }
        Ok(_) => Report::Notice(format!("accepted: {order}")),
        Err(error) => Report::Refused(order, format!("can't {order}: {error}")),
    }
}

fn text(order: UserOrder, answer: EventRecord) -> String {
    match answer.kind() {
        Some(EventKind::Accepted) => format!("accepted: {order}"),
        _ => format!("can't {order}: {}", DispatchError::Refused(answer)),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use regatta_plugin::ProducerPorts;
    use regatta_plugin::event::Refusal;
    use regatta_plugin::order::{OrderKind, OrderRecord};

    use super::*;

    /// The order that no frame has told of a way for, and two that are answered by the test.
    #[test]
    fn answers_and_refusals_are_told() {
        let fleet: FleetName =
            format!("unit-viewer-orders-{}", std::process::id()).parse().expect("a name");
        let mut producer = ProducerPorts::create(&fleet, 1).expect("a producer");
        let ((request, requested), (report, reports)) = (mpsc::channel(), mpsc::channel());
        let thread = std::thread::spawn(move || {
            run(&fleet, &requested, &report).map_err(|error| error.to_string())
        });
        [UserOrder::Hold(4), UserOrder::Close(9)]
            .into_iter()
            .for_each(|order| request.send(order).expect("sent"));
        let mut taken: Vec<OrderRecord> = Vec::new();
        while taken.len() < 2 {
            producer.update();
            producer.take_orders(|_, records| taken.extend_from_slice(records)).expect("readable");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(
            [taken[0].kind, taken[1].kind],
            [OrderKind::Hold, OrderKind::CloseEdge].map(|kind| kind as u32)
        );
        let answer = |order: &OrderRecord, kind: EventKind, detail| EventRecord {
            token: order.token,
            kind: kind as u32,
            id: order.id,
            detail,
            ..EventRecord::default()
        };
        let answers = [
            answer(&taken[0], EventKind::Accepted, 0),
            answer(&taken[1], EventKind::Refused, Refusal::UnknownEdge as u32),
        ];
        producer.publish_events(1, 0, &answers).expect("published");
        let told = [(); 2].map(|()| match reports.recv().expect("a report") {
            Report::Notice(text) => text,
            other => panic!("{other:?}"),
        });
        assert_eq!(
            told,
            ["accepted: hold robot 4", "can't close edge 9: refused: there is no edge 9"]
        );
        drop((request, reports));
        assert_eq!(thread.join().expect("no panic"), Ok(()));
    }
}
