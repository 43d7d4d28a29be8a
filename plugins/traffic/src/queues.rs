//! What robots wait for. A robot that stands is kept out of the next edge of its way, and those
//! behind it are kept back by it: so all of a queue waits for what its head is kept out of.
//!
//! Only frames are read, so it holds for any manager. They don't say where a robot wants to go, but
//! where it went: so samples are kept, and judged at the end of the run.

use std::collections::BTreeMap;

use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

/// The largest number of rows that are kept. With more, every other sample is forgotten.
const MAX_ROWS: usize = 2_000_000;
/// A robot that stands so near to a node, in metres, keeps others from it.
const REACH: f32 = 1.0;
/// The largest number of robots in a chain of those that wait for each other.
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

/// What a robot does in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Deed {
    Drives,
    /// It stands, and wants to drive on.
    Waits,
    /// It stands for another reason: at a stop, without an order, broken down.
    Stays,
}

/// A robot in a sample.
#[derive(Clone, Copy, Debug)]
struct Row {
    robot: u32,
    edge: u32,
    /// Metres from the edge's origin.
    s: f32,
    deed: Deed,
    /// Whether it drives from destination to origin.
    is_reverse: bool,
}

/// A robot's time on an edge. Frames are numbered.
#[derive(Clone, Copy, Debug)]
struct Visit {
    edge: u32,
    /// The first frame.
    entered: u32,
    /// The last one in which it waited there; 0 if it never did.
    waited: u32,
}

/// The robots at an instant.
#[derive(Debug)]
struct Sample {
    /// The number of its frame.
    frame: u32,
    rows: Vec<Row>,
}

/// Collects what is needed to say what robots waited for.
#[derive(Debug, Default)]
pub struct Queues {
    tracks: Vec<Track>,
    /// By robot: the edges that it entered.
    visits: Vec<Vec<Visit>>,
    /// By robot: whether it drove in reverse gear the last time that it drove.
    is_reverse: Vec<bool>,
    samples: Vec<Sample>,
    rows: usize,
    frame: u32,
    /// Every so many seconds there is a sample.
    sample_secs: f64,
    next_sample_secs: f64,
}

impl Queues {
    /// Begins a run.
    pub fn new(tracks: Vec<Track>) -> Self {
        Self { tracks, sample_secs: 1.0, ..Self::default() }
    }

    /// Takes a frame at some simulated seconds.
    pub fn add(&mut self, columns: &Columns<'_>, sim_secs: f64) {
        self.frame += 1;
        self.visits.resize(columns.edge.len(), Vec::new());
        self.is_reverse.resize(columns.edge.len(), false);
        let rows = columns.edge.iter().zip(columns.speed).zip(columns.state);
        for (((&edge, &speed), &state), (visits, is_reverse)) in
            rows.zip(self.visits.iter_mut().zip(&mut self.is_reverse))
        {
            *is_reverse = if speed == 0.0 { *is_reverse } else { speed < 0.0 };
            if edge != NO_EDGE && visits.last().is_none_or(|visit| visit.edge != edge) {
                visits.push(Visit { edge, entered: self.frame, waited: 0 });
            }
            if let Some(visit) = visits.last_mut().filter(|_| state == RobotState::Waiting as u8) {
                visit.waited = self.frame;
            }
        }
        if sim_secs >= self.next_sample_secs {
            self.next_sample_secs = sim_secs + self.sample_secs;
            self.sample(columns);
        }
    }

    fn sample(&mut self, columns: &Columns<'_>) {
        let mut rows = Vec::new();
        for (robot, (&edge, &state)) in columns.edge.iter().zip(columns.state).enumerate() {
            if state == RobotState::Absent as u8 || edge as usize >= self.tracks.len() {
                continue;
            }
            let deed = match state {
                state if state == RobotState::Waiting as u8 => Deed::Waits,
                state if state == RobotState::Driving as u8 || columns.speed[robot] != 0.0 => {
                    Deed::Drives
                }
                _ => Deed::Stays,
            };
            rows.push(Row {
                robot: robot as u32,
                edge,
                s: columns.s[robot],
                deed,
                is_reverse: self.is_reverse[robot],
            });
        }
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

    /// Returns by edge for how many robot seconds robots waited because they, or those before them,
    /// were kept out of it.
    pub fn caused_secs(&self) -> Vec<f64> {
        let mut caused = vec![0.0; self.tracks.len()];
        for sample in &self.samples {
            let places = Places::new(self, sample);
            for (index, _) in
                sample.rows.iter().enumerate().filter(|(_, row)| row.deed == Deed::Waits)
            {
                caused[places.cause(index) as usize] += self.sample_secs;
            }
        }
        caused
    }

    /// Returns the edge that a robot enters next after a frame; `None` if it never does.
    fn next_edge(&self, robot: u32, frame: u32) -> Option<u32> {
        let visits = &self.visits[robot as usize];
        let next = visits.partition_point(|visit| visit.entered <= frame);
        visits.get(next).map(|visit| visit.edge).filter(|edge| (*edge as usize) < self.tracks.len())
    }

    /// Whether a robot waits on its edge in a frame or after it: one that drives then just moves up
    /// in a queue.
    fn is_in_queue(&self, robot: u32, frame: u32) -> bool {
        let visits = &self.visits[robot as usize];
        let index = visits.partition_point(|visit| visit.entered <= frame).checked_sub(1);
        index.is_some_and(|index| visits[index].waited >= frame)
    }
}

/// Who is where in a sample. Numbers are indices of its rows.
struct Places<'a> {
    queues: &'a Queues,
    sample: &'a Sample,
    /// By edge, by ascending distance from its origin.
    on_edge: BTreeMap<u32, Vec<usize>>,
    /// Robots that stand near a node.
    at_node: BTreeMap<u32, Vec<usize>>,
}

/// Who keeps a robot where it is.
enum Blocker {
    /// One that waits, too.
    Waiting(usize),
    /// One that stands for another reason at the end of the edge on which the robot is, or nearer.
    Before,
    /// Nobody who waits or stands: the robot is kept out of its next edge.
    Other,
}

impl<'a> Places<'a> {
    fn new(queues: &'a Queues, sample: &'a Sample) -> Self {
        let (mut on_edge, mut at_node) =
            (BTreeMap::<u32, Vec<usize>>::new(), BTreeMap::<u32, Vec<usize>>::new());
        for (index, row) in sample.rows.iter().enumerate() {
            on_edge.entry(row.edge).or_default().push(index);
            let track = queues.tracks[row.edge as usize];
            for (node, metres) in [(track.origin, row.s), (track.destination, track.length - row.s)]
            {
                if row.deed != Deed::Drives && metres <= REACH {
                    at_node.entry(node).or_default().push(index);
                }
            }
        }
        on_edge
            .values_mut()
            .for_each(|rows| rows.sort_by(|a, b| sample.rows[*a].s.total_cmp(&sample.rows[*b].s)));
        Self { queues, sample, on_edge, at_node }
    }

    /// Returns the edge that keeps a robot waiting: the one that the head of its queue is kept out
    /// of.
    fn cause(&self, index: usize) -> u32 {
        let mut chain = vec![index];
        let mut cause = self.sample.rows[index].edge;
        while let Some(&last) = chain.last() {
            let row = &self.sample.rows[last];
            let next = self.queues.next_edge(row.robot, self.sample.frame);
            cause = next.unwrap_or(cause);
            match self.blocker(last, next) {
                // Robots that wait for each other in a ring: what the last one is kept out of is as
                // good as any.
                Blocker::Waiting(other)
                    if chain.contains(&other) || chain.len() >= LONGEST_CHAIN =>
                {
                    break;
                }
                Blocker::Waiting(other) => chain.push(other),
                Blocker::Before => return row.edge,
                Blocker::Other => break,
            }
        }
        cause
    }

    fn blocker(&self, index: usize, next: Option<u32>) -> Blocker {
        let row = &self.sample.rows[index];
        let track = self.queues.tracks[row.edge as usize];
        let found = |other: usize, is_before: bool| match self.sample.rows[other].deed {
            Deed::Waits => Blocker::Waiting(other),
            Deed::Drives
                if self.queues.is_in_queue(self.sample.rows[other].robot, self.sample.frame) =>
            {
                Blocker::Waiting(other)
            }
            Deed::Stays if is_before => Blocker::Before,
            Deed::Stays | Deed::Drives => Blocker::Other,
        };
        if let Some(other) = self.ahead(index) {
            return found(other, true);
        }
        let exit = if row.is_reverse { track.origin } else { track.destination };
        let standing = |node: u32| {
            let others = self.at_node.get(&node).into_iter().flatten().copied();
            others
                .filter(|other| *other != index)
                .find(|other| self.sample.rows[*other].edge != row.edge)
        };
        let Some(next) = next else {
            return standing(exit).map_or(Blocker::Other, |other| found(other, true));
        };
        let after = self.queues.tracks[next as usize];
        let is_entered_at_origin = after.origin == exit;
        if let Some(rows) = self.on_edge.get(&next) {
            let nearest = if is_entered_at_origin { rows.first() } else { rows.last() };
            return nearest.map_or(Blocker::Other, |other| found(*other, false));
        }
        // Another robot in the way on the node between the edges, or on the one beyond: it came
        // there by another edge.
        let far = if is_entered_at_origin { after.destination } else { after.origin };
        let between = standing(exit).filter(|other| !self.is_kept_back_by(*other, index));
        match between {
            Some(other) => found(other, true),
            None => standing(far).map_or(Blocker::Other, |other| found(other, false)),
        }
    }

    /// Whether a robot that stands at the same node wants to go where another one is: then it isn't
    /// in its way.
    fn is_kept_back_by(&self, robot: usize, other: usize) -> bool {
        let row = &self.sample.rows[robot];
        let next = self.queues.next_edge(row.robot, self.sample.frame);
        let other = &self.sample.rows[other];
        next.is_some()
            && (next == Some(other.edge)
                || next == self.queues.next_edge(other.robot, self.sample.frame))
    }

    /// Returns the next robot before another one on the same edge.
    fn ahead(&self, index: usize) -> Option<usize> {
        let row = &self.sample.rows[index];
        let rows = self.on_edge.get(&row.edge)?;
        let place = rows.iter().position(|other| *other == index)?;
        let ahead = if row.is_reverse { place.checked_sub(1)? } else { place + 1 };
        rows.get(ahead).copied()
    }
}

#[cfg(test)]
#[path = "queues/tests.rs"]
mod tests;
