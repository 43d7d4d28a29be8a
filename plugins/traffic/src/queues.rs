//! The causes of queues. A robot that waits is kept out of the next edge of its route, and blocks
//! those behind it. The whole queue waits for the edge that its head is kept out of.
//!
//! Only frames are read, so this works with any manager. A frame doesn't contain the next edge of a
//! robot, but later frames do. So samples are kept, and evaluated at the end of the run.

use regatta_base::rows::Rows;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};
use regatta_plugin::{Frame, Plugin, Result, World};

/// The largest number of rows that are kept. With more, every other sample is forgotten.
const MAX_ROWS: usize = 2_000_000;
/// The distance, in metres, within which a standing robot blocks a node.
const REACH: f32 = 1.0;
/// The largest number of robots in a chain that wait for each other.
const LONGEST_CHAIN: usize = 1000;

/// An edge of the world.
#[derive(Clone, Copy, Debug)]
pub struct Track {
    /// Index of the origin.
    pub origin: u32,
    /// Index of the destination.
    pub destination: u32,
    /// Its length in metres.
    pub length: f32,
}

/// The motion of a robot in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Driving,
    /// It stands, and waits to drive on.
    Waiting,
    /// The robot stands for another reason: at a stop, without an order, or broken down.
    Standing,
}

impl Motion {
    fn of(state: u8, speed: f32) -> Self {
        match state {
            state if state == RobotState::Waiting as u8 => Self::Waiting,
            state if state == RobotState::Driving as u8 || speed != 0.0 => Self::Driving,
            _ => Self::Standing,
        }
    }
}

/// A robot in a sample.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// [`NO_EDGE`] if it is absent, or on no edge of the world.
    edge: u32,
    /// Metres from the edge's origin.
    s: f32,
    motion: Motion,
    /// Whether it drives from destination to origin.
    is_reverse: bool,
}

/// A robot's time on an edge. Frames are numbered.
#[derive(Clone, Copy, Debug)]
struct Visit {
    edge: u32,
    /// The first frame.
    entered: u32,
    /// The last one in which it waited there; 0 if it never did. That of the newest visit is in
    /// [`Now`].
    waited: u32,
}

/// The state of a robot in the newest frame.
#[derive(Clone, Copy, Debug)]
struct Now {
    /// The edge of its newest visit; [`NO_EDGE`] without one.
    edge: u32,
    /// The last frame of that visit in which it waited; 0 if it never did.
    waited: u32,
    /// Whether it drove in reverse gear the last time that it drove.
    is_reverse: bool,
}

impl Now {
    const UNKNOWN: Self = Self { edge: NO_EDGE, waited: 0, is_reverse: false };
}

/// The robots at an instant.
#[derive(Debug)]
struct Sample {
    /// The number of its frame.
    frame: u32,
    /// By robot.
    rows: Vec<Row>,
}

/// Samples of a run, from which the causes of queues are computed at its end.
#[derive(Debug, Default)]
pub struct Queues {
    tracks: Vec<Track>,
    /// The number of nodes.
    nodes: usize,
    /// By robot: the edges that it entered.
    visits: Vec<Vec<Visit>>,
    /// By robot. Most frames change nothing else.
    now: Vec<Now>,
    samples: Vec<Sample>,
    rows: usize,
    frame: u32,
    /// Seconds between two samples.
    sample_secs: f64,
    next_sample_secs: f64,
}

impl Queues {
    /// Begins a run.
    pub fn new(tracks: Vec<Track>) -> Self {
        let ends = tracks.iter().flat_map(|track| [track.origin, track.destination]);
        let nodes = ends.max().map_or(0, |node| node as usize + 1);
        Self { tracks, nodes, sample_secs: 1.0, ..Self::default() }
    }

    /// Takes a frame at some simulated seconds.
    pub fn add(&mut self, columns: &Columns<'_>, sim_secs: f64) {
        self.frame += 1;
        self.visits.resize(columns.edge.len(), Vec::new());
        self.now.resize(columns.edge.len(), Now::UNKNOWN);
        let rows = columns.edge.iter().zip(columns.speed).zip(columns.state);
        for (robot, (now, ((&edge, &speed), &state))) in self.now.iter_mut().zip(rows).enumerate() {
            if speed != 0.0 {
                now.is_reverse = speed < 0.0;
            }
            if edge != NO_EDGE && edge != now.edge {
                let visits = &mut self.visits[robot];
                if let Some(last) = visits.last_mut() {
                    last.waited = now.waited;
                }
                visits.push(Visit { edge, entered: self.frame, waited: 0 });
                (now.edge, now.waited) = (edge, 0);
            }
            if state == RobotState::Waiting as u8 && now.edge != NO_EDGE {
                now.waited = self.frame;
            }
        }
        if sim_secs >= self.next_sample_secs {
            self.next_sample_secs = sim_secs + self.sample_secs;
            self.sample(columns);
        }
    }

    fn sample(&mut self, columns: &Columns<'_>) {
        let tracks = self.tracks.len();
        let rows: Vec<Row> = (0..columns.edge.len())
            .map(|robot| {
                let (edge, state) = (columns.edge[robot], columns.state[robot]);
                let is_present = state != RobotState::Absent as u8 && (edge as usize) < tracks;
                Row {
                    edge: if is_present { edge } else { NO_EDGE },
                    s: columns.s[robot],
                    motion: Motion::of(state, columns.speed[robot]),
                    is_reverse: self.now[robot].is_reverse,
                }
            })
            .collect();
        self.rows += rows.len();
        self.samples.push(Sample { frame: self.frame, rows });
        if self.rows > MAX_ROWS {
            let mut index = 0;
            self.samples.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.rows = self.samples.iter().map(|sample| sample.rows.len()).sum();
            self.sample_secs *= 2.0;
        }
    }

    /// Returns the robot seconds that each edge caused: those of the robots that were kept out of
    /// it, and of those behind them.
    pub fn caused_secs(&self) -> Vec<f64> {
        let mut caused = vec![0.0; self.tracks.len()];
        for sample in &self.samples {
            let places = Places::new(self, sample);
            for (robot, row) in sample.rows.iter().enumerate() {
                if row.motion == Motion::Waiting && row.edge != NO_EDGE {
                    caused[places.cause(robot) as usize] += self.sample_secs;
                }
            }
        }
        caused
    }

    /// Returns the edge that a robot enters next after a frame; `None` if it never does.
    fn next_edge(&self, robot: usize, frame: u32) -> Option<u32> {
        let visits = &self.visits[robot];
        let next = visits.partition_point(|visit| visit.entered <= frame);
        visits.get(next).map(|visit| visit.edge).filter(|edge| (*edge as usize) < self.tracks.len())
    }

    /// Whether a robot waits on its edge in a frame or after it. If it drives in between, it moves
    /// up in a queue.
    fn is_in_queue(&self, robot: usize, frame: u32) -> bool {
        let visits = &self.visits[robot];
        let count = visits.partition_point(|visit| visit.entered <= frame);
        if count == visits.len() {
            return count > 0 && self.now[robot].waited >= frame;
        }
        count > 0 && visits[count - 1].waited >= frame
    }
}

/// The robots of a sample by place.
struct Places<'a> {
    queues: &'a Queues,
    sample: &'a Sample,
    /// By edge, by ascending distance from its origin.
    on_edge: Rows<usize>,
    /// By node: the robots that stand near it.
    at_node: Rows<usize>,
}

/// The reason why a robot can't drive on.
enum Blocker {
    /// Another robot that waits.
    Waiting(usize),
    /// A robot that stands for another reason at the end of the same edge, or nearer.
    SameEdge,
    /// The robot is kept out of its next edge.
    NextEdge,
}

impl<'a> Places<'a> {
    fn new(queues: &'a Queues, sample: &'a Sample) -> Self {
        let (mut on_edge, mut at_node) = (Vec::new(), Vec::new());
        let present = sample.rows.iter().enumerate().filter(|(_, row)| row.edge != NO_EDGE);
        for (robot, row) in present {
            on_edge.push((row.edge, robot));
            let track = queues.tracks[row.edge as usize];
            for (node, metres) in [(track.origin, row.s), (track.destination, track.length - row.s)]
            {
                if row.motion != Motion::Driving && metres <= REACH {
                    at_node.push((node, robot));
                }
            }
        }
        on_edge.sort_by(|(edge, a), (other, b)| {
            edge.cmp(other).then(sample.rows[*a].s.total_cmp(&sample.rows[*b].s))
        });
        let on_edge = Rows::of_sorted(queues.tracks.len(), on_edge);
        let at_node = Rows::by_row(queues.nodes, at_node);
        Self { queues, sample, on_edge, at_node }
    }

    /// Returns the edge that a robot waits for: the edge that the head of its queue can't enter.
    fn cause(&self, robot: usize) -> u32 {
        let mut chain = vec![robot];
        let mut cause = self.sample.rows[robot].edge;
        while let Some(&last) = chain.last() {
            let row = &self.sample.rows[last];
            let next = self.queues.next_edge(last, self.sample.frame);
            cause = next.unwrap_or(cause);
            match self.blocker(last, next) {
                // In a ring of robots that wait for each other, any of the edges will do.
                Blocker::Waiting(other)
                    if chain.contains(&other) || chain.len() >= LONGEST_CHAIN =>
                {
                    break;
                }
                Blocker::Waiting(other) => chain.push(other),
                Blocker::SameEdge => return row.edge,
                Blocker::NextEdge => break,
            }
        }
        cause
    }

    fn blocker(&self, robot: usize, next: Option<u32>) -> Blocker {
        let row = &self.sample.rows[robot];
        let track = self.queues.tracks[row.edge as usize];
        if let Some(other) = self.ahead(robot) {
            return self.blocked_by(other, Blocker::SameEdge);
        }
        let exit = if row.is_reverse { track.origin } else { track.destination };
        let at_exit = self.standing(exit, robot);
        let Some(next) = next else {
            return at_exit
                .map_or(Blocker::NextEdge, |other| self.blocked_by(other, Blocker::SameEdge));
        };
        let after = self.queues.tracks[next as usize];
        let is_entered_at_origin = after.origin == exit;
        let rows = self.on_edge.row(next);
        let nearest = if is_entered_at_origin { rows.first() } else { rows.last() };
        if let Some(nearest) = nearest {
            return self.blocked_by(*nearest, Blocker::NextEdge);
        }
        // Another robot may stand at the node between the edges, or at the one beyond: it came
        // there by another edge.
        if let Some(other) = at_exit.filter(|other| !self.is_kept_back_by(*other, robot)) {
            return self.blocked_by(other, Blocker::SameEdge);
        }
        let far = if is_entered_at_origin { after.destination } else { after.origin };
        self.standing(far, robot)
            .map_or(Blocker::NextEdge, |other| self.blocked_by(other, Blocker::NextEdge))
    }

    /// Returns another robot as a blocker; `standing` if it neither drives nor waits.
    fn blocked_by(&self, other: usize, standing: Blocker) -> Blocker {
        let row = &self.sample.rows[other];
        match row.motion {
            Motion::Waiting => Blocker::Waiting(other),
            Motion::Driving if self.queues.is_in_queue(other, self.sample.frame) => {
                Blocker::Waiting(other)
            }
            Motion::Driving => Blocker::NextEdge,
            Motion::Standing => standing,
        }
    }

    /// Returns a robot that stands at a node on another edge than a given one.
    fn standing(&self, node: u32, robot: usize) -> Option<usize> {
        let edge = self.sample.rows[robot].edge;
        let mut others = self.at_node.row(node).iter().copied();
        others.find(|other| *other != robot && self.sample.rows[*other].edge != edge)
    }

    /// Whether a robot at the same node is itself kept back by another one, because both share an
    /// edge: then it doesn't block it.
    fn is_kept_back_by(&self, robot: usize, other: usize) -> bool {
        let next = self.queues.next_edge(robot, self.sample.frame);
        next.is_some()
            && (next == Some(self.sample.rows[other].edge)
                || next == self.queues.next_edge(other, self.sample.frame))
    }

    /// Returns the next robot before another one on the same edge.
    fn ahead(&self, robot: usize) -> Option<usize> {
        let row = &self.sample.rows[robot];
        let rows = self.on_edge.row(row.edge);
        let place = rows.iter().position(|other| *other == robot)?;
        let ahead = if row.is_reverse { place.checked_sub(1)? } else { place + 1 };
        rows.get(ahead).copied()
    }
}

/// The plugin that finds the causes of queues.
#[derive(Debug, Default)]
pub struct QueueObserver {
    /// The ids of edges.
    ids: Vec<u32>,
    queues: Queues,
}

impl QueueObserver {
    /// Returns the ids of the edges that robots were kept out of, with the robot seconds of those
    /// that were kept out and of those behind them.
    pub fn caused_secs(&self) -> impl Iterator<Item = (u32, f64)> {
        let edges = self.ids.iter().copied().zip(self.queues.caused_secs());
        edges.filter(|(_, secs)| *secs > 0.0)
    }
}

impl Plugin for QueueObserver {
    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.ids = world.edges().iter().map(|edge| edge.id).collect();
        let tracks = world.edges().iter().map(|edge| Track {
            origin: edge.origin,
            destination: edge.destination,
            length: edge.length,
        });
        self.queues = Queues::new(tracks.collect());
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.queues.add(&frame.columns(), frame.sim_time().as_secs_f64());
        Ok(())
    }
}

#[cfg(test)]
mod tests;
