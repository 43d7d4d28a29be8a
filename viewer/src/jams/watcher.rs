//! The ports of the query about jams.

use std::time::{Duration, Instant};

use glam::Vec2;
use regatta_interface::jams::{EdgeFacts, Known, NodeFacts, Presence, Spot};
use regatta_interface::robot_spots;
use regatta_kit::RunHistory;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::traffic::TRAFFIC_PERIODS;
use regatta_plugin::{
    ColumnReader, ContactReader, HistoryReader, Participant, ReadError, Result, Subscriber,
    Traffic, TrafficReader, WorldReader,
};
use regatta_scene::heat::{Heat, HeatMap};

use super::{History, JamQuery, JamReport};

/// The time between two looks, unless they take long.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// A look is followed by a pause of at least so many times the time that it took.
const PAUSES: u32 = 20;
/// The time between two lists of hot spots, unless they take long.
const LIST_EVERY: Duration = Duration::from_millis(500);

/// The open ports, and the findings so far.
pub struct Watcher {
    frames: Subscriber,
    worlds: WorldReader,
    traffic: TrafficReader,
    contacts: ContactReader,
    activities: ColumnReader,
    published: HistoryReader,
    run: RunHistory,
    /// The heat map that was worked out last, and whether there is something newer.
    heat: Option<Heat>,
    is_heat_old: bool,
    /// Whether the traffic had a publisher at the last check.
    had_traffic: bool,
    /// Whether there is a frame that the hot spots don't count yet.
    has_frame: bool,
    pub(super) look_at: Instant,
    list_at: Instant,
}

impl Watcher {
    pub(super) fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            worlds: WorldReader::open_on(participant)?,
            traffic: TrafficReader::open_on(participant)?,
            contacts: ContactReader::open_on(participant)?,
            activities: ColumnReader::open_on(participant, ACTIVITY.name())?,
            published: HistoryReader::open_on(participant)?,
            run: RunHistory::default(),
            heat: None,
            is_heat_old: true,
            had_traffic: false,
            has_frame: false,
            list_at: Instant::now(),
            look_at: Instant::now(),
        })
    }

    /// Looks at everything that is watched. Before the next look is due, as when the pointer moves
    /// to another edge, only at what takes one pass over the robots.
    pub(super) fn look(&mut self, query: &JamQuery) -> Result<JamReport> {
        let start = Instant::now();
        self.has_frame |= self.frames.latest()?.is_some();
        self.contacts.latest()?;
        self.is_heat_old |= self.worlds.latest()?.is_some();
        self.is_heat_old |= self.traffic.latest()?.is_some();
        let has_traffic = self.traffic.has_publisher();
        self.is_heat_old |= std::mem::replace(&mut self.had_traffic, has_traffic) != has_traffic;
        let is_due = start >= self.look_at;
        let is_other = std::mem::replace(&mut self.heat, query.heat) != query.heat;
        let draws_heat = is_other || is_due && self.is_heat_old;
        let edges = query.edges.iter().map(|edge| self.edge_facts(*edge));
        let edges = edges.collect::<Result<_, _>>()?;
        let report = JamReport {
            heat: if draws_heat { Some(self.heat_map(query)?) } else { None },
            edges,
            node: self.node_facts(query)?,
            history: if query.history && is_due { self.history()? } else { None },
        };
        self.is_heat_old &= !draws_heat;
        if is_due {
            self.look_at = Instant::now() + LOOK_EVERY.max(start.elapsed() * PAUSES);
        }
        Ok(report)
    }

    fn heat_map(&self, query: &JamQuery) -> Result<Option<HeatMap>, ReadError> {
        let (Some(heat), Some(world)) = (query.heat, self.worlds.current()?) else {
            return Ok(None);
        };
        Ok(self.current_traffic()?.map(|traffic| HeatMap::new(heat, &traffic, &world)))
    }

    /// The newest figures, if they belong to the shown world and have a publisher.
    fn current_traffic(&self) -> Result<Option<Traffic<'_>>, ReadError> {
        let edges = self.worlds.current()?.map_or(0, |world| world.edges().len());
        let run = self.frames.current()?.map(|frame| frame.run_id());
        let has_publisher = self.traffic.has_publisher();
        Ok(self.traffic.current()?.filter(|traffic| {
            has_publisher
                && traffic.header.edges as usize == edges
                && run.is_none_or(|run| run == traffic.header.run_id)
        }))
    }

    /// Adds a new frame to the hot spots and the figures over time. Returns both from time to time:
    /// those of a plugin, which has seen more of the run, if there is one.
    fn history(&mut self) -> Result<Option<History>, ReadError> {
        let has_frame = std::mem::take(&mut self.has_frame);
        self.published.update()?;
        let Some(frame) = self.frames.current()?.filter(|_| has_frame) else { return Ok(None) };
        let run = frame.run_id();
        let has_checker = self.contacts.has_publisher();
        let contacts = self.contacts.current().filter(|_| has_checker);
        let contacts = contacts.map(|contacts| (contacts.header, contacts.pairs));
        let throughput = self
            .current_traffic()?
            .map(|traffic| traffic.periods[0].iter().map(|edge| edge.entered_per_hour).sum());
        let activities = self.activities.newest_of_run(run)?;
        self.run.add(&frame, contacts, activities, || throughput);
        if Instant::now() < self.list_at {
            return Ok(None);
        }
        let start = Instant::now();
        let found = self.published(run).unwrap_or_else(|| self.own());
        self.list_at = Instant::now() + LIST_EVERY.max(start.elapsed() * PAUSES);
        Ok(Some(found))
    }

    /// The findings of a plugin or a replay in a run: they are of more than this window has seen,
    /// even if the plugin has ended since.
    fn published(&self, run: u64) -> Option<History> {
        let (header, samples) = self.published.samples()?;
        let (_, spots) = self
            .published
            .spots()
            .filter(|(spots, _)| spots.run_id == run && header.run_id == run)?;
        let [from_secs, until_secs] =
            [header.began_nanos, header.sim_time_nanos].map(|nanos| nanos as f64 * 1e-9);
        let known = Known { from_secs, until_secs, is_published: true };
        Some((spots.iter().map(Spot::from).collect(), samples.into(), known))
    }

    /// The findings of this thread since it began to watch.
    fn own(&self) -> History {
        let until_secs = self.run.series.samples.last().map_or(0.0, |sample| sample.secs);
        let known = Known { from_secs: self.run.spots.began().1, until_secs, is_published: false };
        (
            self.run.spots.list().iter().map(Spot::from).collect(),
            self.run.series.samples.clone().into(),
            known,
        )
    }

    fn edge_facts(&self, edge: u32) -> Result<EdgeFacts, ReadError> {
        let published = self.current_traffic()?;
        let period_secs =
            published.map_or([0.0; TRAFFIC_PERIODS], |traffic| traffic.header.period_secs);
        let traffic = published.and_then(|traffic| {
            let figures: Vec<_> = traffic
                .periods
                .iter()
                .filter_map(|edges| edges.get(edge as usize).copied())
                .collect();
            <[_; TRAFFIC_PERIODS]>::try_from(figures).ok()
        });
        let frame = self.frames.current()?;
        let present = frame.map(|frame| Presence::on_edge(&frame, edge)).unwrap_or_default();
        Ok(EdgeFacts { edge, traffic, period_secs, present })
    }

    fn node_facts(&self, query: &JamQuery) -> Result<Option<NodeFacts>, ReadError> {
        let (frame, world) = (self.frames.current()?, self.worlds.current()?);
        let (Some(frame), Some(world), Some(index)) = (frame, world, query.node) else {
            return Ok(None);
        };
        let facts = world.nodes().get(index as usize).map(|node| {
            let place = Vec2::new(node.x, node.y);
            NodeFacts {
                node: index,
                present: Presence::around(&frame, place, robot_spots::radius(&world)),
            }
        });
        Ok(facts)
    }
}
