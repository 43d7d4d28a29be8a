//! What takes time, on threads of its own: requests of the engine, the order of the fleet list, the columns that there
//! are. Nothing here makes a picture wait. iceoryx2's ports stay on the thread that made them, so each has its own.

use std::collections::VecDeque;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{
    ColumnName, ColumnReader, Control, ControlError, FleetName, Participant, Result, Subscriber, column_names,
};

use crate::interface::rows::{RowQuery, Rows};
use crate::route::RouteWatch;

/// Between two questions how the engine is.
const STATUS_EVERY: Duration = Duration::from_millis(250);
/// How long an engine may take to answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Between two new orders of the fleet list.
const SORT_EVERY: Duration = Duration::from_millis(700);
/// Between two looks which columns there are: each goes through all services of the machine.
const LIST_EVERY: Duration = Duration::from_secs(2);
/// Between two looks at the selected robot's columns.
const VALUES_EVERY: Duration = Duration::from_millis(200);
/// How long routes may take: everything else that is looked at waits meanwhile.
const ROUTE_PATIENCE: Duration = Duration::from_millis(100);
/// Most columns that are read for the selected robot: each takes a place among the column's readers.
const MOST_COLUMNS: usize = 16;

/// What the threads found.
#[derive(Debug)]
pub enum Report {
    /// How the fleet is.
    Facts(Fact),
    /// Something to tell the person.
    Notice(String),
    /// The selected robots' routes; none if nobody knows them.
    Routes(Vec<RouteResponse>),
}

/// What was found out of a fleet.
#[derive(Debug)]
pub enum Fact {
    /// How the engine is; `None` if there is none.
    Status(Option<Box<ControlResponse>>),
    /// The fleet list's rows.
    Rows(Rows),
    /// The columns that are published.
    Columns(Vec<ColumnName>),
    /// The selected robot's values.
    Values(Vec<(ColumnName, f32)>),
}

impl From<Fact> for Report {
    fn from(fact: Fact) -> Self {
        Self::Facts(fact)
    }
}

/// What the survey is to find out.
#[derive(Debug)]
enum Ask {
    Rows(RowQuery),
    Robot(Option<u32>),
    Routes(Vec<u32>),
}

/// The threads. Dropping it ends them.
#[derive(Debug)]
pub struct Link {
    requests: Option<Sender<ControlRequest>>,
    asks: Option<Sender<Ask>>,
    reports: Receiver<Report>,
    survey: Option<JoinHandle<()>>,
}

impl Link {
    /// Starts the threads for a fleet, whether or not it has an engine.
    ///
    /// # Errors
    /// If the system has no threads to give.
    pub fn open(fleet: &FleetName) -> std::io::Result<Self> {
        let (report, reports) = mpsc::channel();
        let (requests, requested) = mpsc::channel();
        let (asks, asked) = mpsc::channel();
        let (name, control_report) = (fleet.clone(), report.clone());
        // Not waited for at the end: a step may take as long as it likes.
        std::thread::Builder::new().name("control".into()).spawn(move || {
            tell(&control_report, control(&name, &requested, &control_report));
        })?;
        let name = fleet.clone();
        let survey = std::thread::Builder::new().name("survey".into()).spawn(move || {
            tell(&report, survey(&name, &asked, &report));
        })?;
        Ok(Self { requests: Some(requests), asks: Some(asks), reports, survey: Some(survey) })
    }

    /// Sends a request to the engine, when the ones before are answered.
    pub fn request(&self, request: ControlRequest) {
        if let Some(requests) = &self.requests {
            // Its thread has said why it ended.
            let _ = requests.send(request);
        }
    }

    /// Asks for the rows of the fleet list.
    pub fn rows(&self, query: RowQuery) {
        self.ask(Ask::Rows(query));
    }

    /// Says of which robot the columns' values are wanted.
    pub fn robot(&self, robot: Option<u32>) {
        self.ask(Ask::Robot(robot));
    }

    /// Says of which robots the routes are wanted.
    pub fn routes(&self, robots: Vec<u32>) {
        self.ask(Ask::Routes(robots));
    }

    fn ask(&self, ask: Ask) {
        if let Some(asks) = &self.asks {
            let _ = asks.send(ask);
        }
    }

    /// What has been found since the last call.
    pub fn reports(&self) -> impl Iterator<Item = Report> {
        self.reports.try_iter()
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        (self.requests, self.asks) = (None, None);
        if let Some(survey) = self.survey.take() {
            // It panicked, and the panic has been told.
            let _ = survey.join();
        }
    }
}

fn tell(report: &Sender<Report>, result: Result) {
    if let Err(error) = result {
        // Nobody is there to hear it any more.
        let _ = report.send(Report::Notice(error.to_string()));
    }
}

/// Carries out requests until the link is dropped, and asks for the status in between.
fn control(fleet: &FleetName, requested: &Receiver<ControlRequest>, report: &Sender<Report>) -> Result {
    let mut control = Control::open(fleet)?;
    let mut waiting = VecDeque::new();
    loop {
        if waiting.is_empty() {
            match requested.recv_timeout(STATUS_EVERY) {
                Ok(request) => waiting.push_back(request),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
        waiting.extend(requested.try_iter());
        keep_newest(&mut waiting);
        let request = waiting.pop_front();
        let asked = request.unwrap_or(ControlRequest::new(ControlKind::Status));
        let found = match control.request(asked, PATIENCE) {
            Ok(status) => Fact::Status(Some(Box::new(status))).into(),
            Err(ControlError::NoEngine { .. }) if request.is_none() => Fact::Status(None).into(),
            Err(ControlError::Gone { .. }) => Fact::Status(None).into(),
            Err(error) if request.is_some() => Report::Notice(error.to_string()),
            Err(error) => {
                tracing::debug!(%error, "asking for the status");
                Fact::Status(None).into()
            }
        };
        if report.send(found).is_err() {
            return Ok(());
        }
    }
}

/// Of speeds and of numbers of robots only the last one counts: sliders give many.
fn keep_newest(requests: &mut VecDeque<ControlRequest>) {
    let replaced = [ControlKind::Speed, ControlKind::Robots].map(|kind| kind as u32);
    let all: Vec<_> = requests.drain(..).collect();
    for (i, request) in all.iter().enumerate() {
        let later = all[i + 1..].iter().any(|later| later.kind == request.kind);
        if !(later && replaced.contains(&request.kind)) {
            requests.push_back(*request);
        }
    }
}

/// Looks at the fleet for what the interface wants to know, until the link is dropped.
fn survey(fleet: &FleetName, asked: &Receiver<Ask>, report: &Sender<Report>) -> Result {
    let participant = Participant::join(fleet, "viewer-survey")?;
    let mut survey = Survey::new(participant);
    loop {
        match asked.recv_timeout(survey.patience()) {
            Ok(ask) => survey.take(ask),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        loop {
            match asked.try_recv() {
                Ok(ask) => survey.take(ask),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
        }
        for found in survey.look()? {
            if report.send(found).is_err() {
                return Ok(());
            }
        }
    }
}

struct Survey {
    participant: Participant,
    query: RowQuery,
    /// Open only while rows are wanted: a reader holds a frame.
    frames: Option<Subscriber>,
    robot: Option<u32>,
    names: Vec<ColumnName>,
    columns: Vec<(ColumnName, ColumnReader)>,
    routes: RouteWatch,
    sort_at: Instant,
    list_at: Instant,
    values_at: Instant,
}

impl Survey {
    fn new(participant: Participant) -> Self {
        let now = Instant::now();
        Self {
            participant,
            query: RowQuery::default(),
            frames: None,
            robot: None,
            names: Vec::new(),
            columns: Vec::new(),
            routes: RouteWatch::default(),
            sort_at: now,
            list_at: now,
            values_at: now,
        }
    }

    fn take(&mut self, ask: Ask) {
        match ask {
            Ask::Rows(query) => (self.query, self.sort_at) = (query, Instant::now()),
            Ask::Robot(robot) => (self.robot, self.values_at) = (robot, Instant::now()),
            Ask::Routes(robots) => self.routes.watch(robots, Instant::now()),
        }
    }

    /// How long there is nothing to do.
    fn patience(&self) -> Duration {
        let rows = (!self.query.is_plain()).then_some(self.sort_at);
        let values = self.robot.map(|_| self.values_at);
        let next = [Some(self.list_at), rows, values, self.routes.due()].into_iter().flatten().min();
        next.map_or(LIST_EVERY, |next| next.saturating_duration_since(Instant::now()))
    }

    fn look(&mut self) -> Result<Vec<Report>> {
        let mut found = Vec::new();
        if Instant::now() >= self.list_at {
            self.names = column_names(self.participant.fleet());
            found.push(Fact::Columns(self.names.clone()).into());
            self.list_at = Instant::now() + LIST_EVERY;
        }
        if self.query.is_plain() {
            self.frames = None;
        } else if Instant::now() >= self.sort_at {
            found.extend(self.sort()?.map(Fact::Rows).map(Report::from));
            self.sort_at = Instant::now() + SORT_EVERY;
        }
        if self.robot.is_none() {
            self.columns.clear();
        } else if Instant::now() >= self.values_at {
            found.push(Fact::Values(self.values()?).into());
            self.values_at = Instant::now() + VALUES_EVERY;
        }
        match self.routes.ask(&self.participant, ROUTE_PATIENCE) {
            Ok(routes) => found.extend(routes.map(Report::Routes)),
            Err(error) => found.push(Report::Notice(error.to_string())),
        }
        Ok(found)
    }

    fn sort(&mut self) -> Result<Option<Rows>> {
        let frames = match &mut self.frames {
            Some(frames) => frames,
            none => none.insert(Subscriber::open_on(&self.participant)?),
        };
        let rows = frames.latest()?.map(|frame| self.query.rows(frame.columns()));
        // A paused engine sends no other frame.
        Ok(if rows.is_some() { rows } else { frames.current()?.map(|frame| self.query.rows(frame.columns())) })
    }

    fn values(&mut self) -> Result<Vec<(ColumnName, f32)>> {
        let Some(robot) = self.robot else { return Ok(Vec::new()) };
        self.columns.retain(|(name, _)| self.names.contains(name));
        for name in self.names.iter().filter(|name| name.to_string() != "type").take(MOST_COLUMNS) {
            if !self.columns.iter().any(|(known, _)| known == name) {
                self.columns.push((name.clone(), ColumnReader::open_on(&self.participant, name.as_str())?));
            }
        }
        let mut values = Vec::new();
        for (name, reader) in &mut self.columns {
            reader.latest()?;
            let value = reader.current()?.and_then(|column| column.values.get(robot as usize).copied());
            // Our own reader keeps the name alive.
            values.extend(value.filter(|_| reader.has_publisher()).map(|value| (name.clone(), value)));
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_speeds_the_last_one_is_sent() {
        let speed = |speed| ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) };
        let (pause, step) = (ControlRequest::new(ControlKind::Pause), ControlRequest::new(ControlKind::Step));
        let mut requests = VecDeque::from([speed(1.0), pause, speed(2.0), step, step, speed(3.0)]);
        keep_newest(&mut requests);
        assert_eq!(requests, [pause, step, step, speed(3.0)]);
    }
}
