//! The part of a run that listens to the broker, and hands transport orders over.

use std::collections::HashSet;
use std::time::{Duration, Instant, SystemTime};

use regatta_vda5050::broker::{Broker, Incoming, Session};
use regatta_vda5050::judge::{Judge, Protocol, Report, Seen};
use regatta_vda5050::message::Topic;
use regatta_vda5050::meter::{Figures, Meter};

use super::hand_over::{HandOver, HandedOver, Transport, Way};
use super::live_run::{LiveRun, RunError};
use super::load::{Arrival, LiveLoad};
use super::site::Site;
use crate::day;
use crate::failure::Failure;
use crate::vda5050::live::seconds;

/// The topics that are judged and measured.
const TOPICS: [Topic; 5] =
    [Topic::Order, Topic::InstantActions, Topic::State, Topic::Connection, Topic::Factsheet];
/// The time after which an order that couldn't be handed over is tried again.
const RETRY: Duration = Duration::from_secs(1);
/// The longest time that messages may wait in this process.
const MOST_LAG: Duration = Duration::from_secs(2);

/// The connection of a run with its judge, its meter and its load.
pub struct Ear<'a> {
    site: &'a Site<'a>,
    broker: Option<Broker>,
    is_up: bool,
    /// The vehicles of the run: others of the broker are none of its business.
    vehicles: HashSet<String>,
    judge: Judge,
    report: Report,
    meter: Meter,
    load: Option<LiveLoad>,
    hand_over: Option<HandOver>,
    load_start: Instant,
    /// Transport orders that couldn't be handed over, with the time of the next try.
    again: Vec<(Instant, Transport)>,
    handed: u64,
    finished: usize,
    /// The reason of the last hand-over that failed.
    refusal: Option<String>,
    run: String,
}

impl<'a> Ear<'a> {
    /// Connects to the broker.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn new(run: &LiveRun<'a>) -> Result<Self, RunError> {
        let site = run.site;
        let mut broker = Broker::start(site.url.clone(), site.password.clone())
            .map_err(|error| RunError::Failed(format!("can't start a thread: {error}")))?;
        broker.connect(&Session {
            client_id: format!("regatta-study-{}", std::process::id()),
            will: None,
            topics: site.vehicles.topics(&TOPICS),
        });
        Ok(Self {
            site,
            broker: Some(broker),
            is_up: false,
            vehicles: (0..run.vehicles as usize)
                .map(|robot| site.vehicles.vehicle(robot))
                .collect(),
            judge: Judge::new(Protocol::Auto),
            report: Report::new(1),
            meter: Meter::new(site.places()),
            load: None,
            hand_over: None,
            load_start: Instant::now(),
            again: Vec::new(),
            handed: 0,
            finished: 0,
            refusal: None,
            run: format!("{}-{}", run.vehicles, run.repeat),
        })
    }

    /// Whether the master has sent an order.
    pub fn has_order(&self) -> bool {
        self.meter.figures().first_order.is_some()
    }

    /// Begins to hand transport orders over, unless the master makes them.
    ///
    /// # Errors
    /// If the load can't be read.
    pub fn start_load(&mut self, run: &LiveRun<'_>) -> Result<(), Failure> {
        if self.site.way == Way::Own {
            return Ok(());
        }
        let places = day::places(&run.plan.variant.graph);
        self.load = Some(LiveLoad::new(run.plan, run.vehicles, run.repeat, places)?);
        let words = self.site.words(run.vehicles);
        let password = self.site.password.as_deref();
        self.hand_over = Some(HandOver::start(&self.site.way, &words, password));
        self.load_start = Instant::now();
        Ok(())
    }

    /// Takes what has come, and hands over what is due.
    ///
    /// # Errors
    /// If the connection is lost, or this process can't keep up.
    pub fn listen(&mut self) -> Result<(), RunError> {
        while let Some(incoming) = self.broker.as_ref().and_then(Broker::take) {
            self.receive(incoming)?;
        }
        for finding in self.judge.pass(seconds(SystemTime::now())) {
            self.report.add(finding);
        }
        self.hand_orders_over();
        Ok(())
    }

    fn receive(&mut self, incoming: Incoming) -> Result<(), RunError> {
        let url = &self.site.url;
        match incoming {
            Incoming::Connected { .. } => self.is_up = true,
            Incoming::Lost { reason, .. } if self.is_up => {
                let text = format!("{url}: the connection was lost ({reason})");
                return Err(RunError::Failed(text));
            }
            Incoming::Lost { reason, .. } => {
                let advice = "start the broker, or give another address, user or password";
                let text = format!("{url}: can't connect ({reason}): {advice}");
                return Err(RunError::Failed(text));
            }
            Incoming::Message { topic, payload, time } => {
                if time.elapsed().is_ok_and(|lag| lag > MOST_LAG) {
                    let text = "this machine is too slow to judge so many messages".to_owned();
                    return Err(RunError::Failed(text));
                }
                self.take(&topic, &payload, seconds(time));
            }
        }
        Ok(())
    }

    fn take(&mut self, topic: &str, payload: &[u8], time: f64) {
        let vehicle = topic.rsplit_once('/').map_or("", |(vehicle, _)| vehicle);
        if !self.vehicles.contains(vehicle) {
            return;
        }
        let seen = Seen { time: Some(time), topic, payload, delivery: None };
        for finding in self.judge.take(&seen) {
            self.report.add(finding);
        }
        self.meter.take(topic, payload, time);
    }

    fn hand_orders_over(&mut self) {
        let (Some(load), Some(hand_over)) = (&mut self.load, &self.hand_over) else { return };
        let secs = self.load_start.elapsed().as_secs_f64();
        let finished = &self.meter.figures().finished;
        for order in finished.iter().skip(self.finished).filter_map(|order| order.number) {
            load.finish(order, secs);
        }
        self.finished = finished.len();
        for Arrival { number, nodes } in load.arrivals(secs) {
            hand_over.hand_over(Transport {
                number,
                id: format!("regatta-{}-{number}", self.run),
                stations: nodes.map(|node| self.site.station(node)),
                nodes: nodes.map(|node| self.site.node(node)),
            });
        }
        let now = Instant::now();
        for (_, transport) in self.again.extract_if(.., |(time, _)| *time <= now) {
            hand_over.hand_over(transport);
        }
        while let Some(HandedOver { transport, result }) = hand_over.take() {
            match result {
                Ok(time) => {
                    let [pick, drop] = &transport.nodes;
                    self.meter.hand_over(transport.number, pick, drop, seconds(time));
                    self.handed += 1;
                }
                Err(reason) => {
                    self.refusal = Some(reason);
                    self.again.push((now + RETRY, transport));
                }
            }
        }
    }

    /// The number of vehicles that have said at which node they are.
    pub fn placed_vehicles(&self) -> usize {
        self.meter.placed_vehicles()
    }

    /// The number of transport orders that the master has got.
    pub fn handed(&self) -> u64 {
        self.handed
    }

    /// The reason of the last hand-over that failed.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_deref()
    }

    /// Ends the connection, and returns the figures.
    pub fn end(mut self) -> (Figures, Report) {
        if let Some(broker) = self.broker.take() {
            broker.end();
        }
        (self.meter.end(seconds(SystemTime::now())), self.report)
    }
}
