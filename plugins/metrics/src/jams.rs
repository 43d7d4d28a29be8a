//! The edges at which robots wait the longest, from the plugin `traffic`, if one runs and keeps up.

use std::cmp::Ordering;
use std::sync::Arc;

use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::{Participant, ReadError, Result, TrafficReader, WorldReader};

use crate::aggregator::RunClock;
use crate::snapshot::Jam;

/// The number of edges that are listed.
pub const LISTED: usize = 10;
/// The period of the figures among those of the traffic: the last ten minutes.
const PERIOD: usize = 1;
/// The largest age of figures relative to the newest frame, in simulated seconds: they are
/// published once a second.
const MAX_AGE_SECS: f64 = 10.0;

/// A reader of the traffic of a fleet, and of the names of its edges.
#[derive(Debug)]
pub struct JamReader {
    traffic: TrafficReader,
    world: WorldReader,
    edges: Vec<Edge>,
    revision: u64,
    newest: Option<Jams>,
}

/// The id and the name of an edge.
#[derive(Clone, Debug, PartialEq)]
struct Edge {
    id: u32,
    name: Arc<str>,
}

/// The worst edges at a tick of a run.
#[derive(Clone, Debug)]
struct Jams {
    run_id: u64,
    tick: u64,
    list: Arc<[Jam]>,
}

impl JamReader {
    /// Opens both, whether or not they are published yet.
    ///
    /// # Errors
    /// Fails if the fleet uses another version of the contract, or has no room for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        let (traffic, world) =
            (TrafficReader::open_on(participant)?, WorldReader::open_on(participant)?);
        Ok(Self { traffic, world, edges: Vec::new(), revision: 0, newest: None })
    }

    /// Returns the worst edges, the worst one first; `None` if no plugin publishes the traffic of
    /// the newest frame's run.
    pub fn jams(&self, newest: Option<RunClock>) -> Option<Arc<[Jam]>> {
        let (clock, jams) = (newest?, self.newest.as_ref()?);
        let age_secs = clock.tick.saturating_sub(jams.tick) as f64 * clock.tick_secs;
        (jams.run_id == clock.run_id && age_secs <= MAX_AGE_SECS).then(|| Arc::clone(&jams.list))
    }

    /// Reads the world, if there is a new one.
    pub fn read_world(&mut self) -> Result<(), ReadError> {
        if let Some(world) = self.world.latest()? {
            self.revision = world.revision();
            self.edges = world
                .edges()
                .iter()
                .map(|edge| Edge { id: edge.id, name: world.text(edge.name).into() })
                .collect();
        }
        Ok(())
    }

    /// Reads the traffic, if there are new figures.
    pub fn read_traffic(&mut self) -> Result<(), ReadError> {
        if let Some(traffic) = self.traffic.latest()?
            && traffic.header.world_revision == self.revision
        {
            let list = worst(&self.edges, traffic.periods[PERIOD]);
            self.newest =
                Some(Jams { run_id: traffic.header.run_id, tick: traffic.header.tick, list });
        }
        Ok(())
    }
}

/// Returns the edges at which robots waited the longest, the worst one first.
fn worst(edges: &[Edge], figures: &[EdgeTraffic]) -> Arc<[Jam]> {
    let mut rows: Vec<_> =
        edges.iter().zip(figures).filter(|(_, figures)| figures.waiting_secs > 0.0).collect();
    if rows.len() > LISTED {
        rows.select_nth_unstable_by(LISTED, by_waiting);
        rows.truncate(LISTED);
    }
    rows.sort_unstable_by(by_waiting);
    rows.into_iter()
        .map(|(edge, figures)| Jam { edge: edge.id, name: edge.name.clone(), figures: *figures })
        .collect()
}

fn by_waiting(a: &(&Edge, &EdgeTraffic), b: &(&Edge, &EdgeTraffic)) -> Ordering {
    b.1.waiting_secs.total_cmp(&a.1.waiting_secs).then(a.0.id.cmp(&b.0.id))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::traffic::TrafficHeader;
    use regatta_plugin::{FleetName, TrafficPublisher};

    use super::*;

    fn edge(id: u32) -> Edge {
        Edge { id, name: "".into() }
    }

    #[test]
    fn the_worst_edges_come_first() {
        let edges: Vec<Edge> = (100..140).map(edge).collect();
        let waiting =
            |secs: u32| EdgeTraffic { waiting_secs: secs as f32, ..EdgeTraffic::default() };
        let figures: Vec<_> = (0..40).map(|number| waiting(number * 7 % 40)).collect();
        let worst = worst(&edges, &figures);
        assert_eq!(
            worst.iter().map(|jam| jam.figures.waiting_secs).collect::<Vec<_>>(),
            [39.0, 38.0, 37.0, 36.0, 35.0, 34.0, 33.0, 32.0, 31.0, 30.0]
        );
        assert_eq!(worst[0].edge, 117);
        assert_eq!(
            super::worst(&edges[..3], &figures[..3]).len(),
            2,
            "nobody waited on the first edge"
        );
    }

    #[test]
    fn figures_belong_to_the_run_of_the_newest_frame() {
        let name: FleetName =
            format!("unit-metrics-jams-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut publisher = TrafficPublisher::open_on(&participant).expect("a publisher");
        let mut reader = JamReader::open_on(&participant).expect("a reader");
        (reader.edges, reader.revision) = (vec![edge(5), edge(6)], 3);
        let header =
            TrafficHeader { run_id: 7, tick: 100, world_revision: 3, ..TrafficHeader::default() };
        let figures = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
            .map(|secs| EdgeTraffic { waiting_secs: secs, ..Default::default() });
        publisher.publish(&header, &figures).expect("published");
        reader.read_traffic().expect("read");
        let clock = |run_id, tick| Some(RunClock { run_id, tick, tick_secs: 0.1 });
        let jams = reader.jams(clock(7, 200)).expect("figures of the run");
        assert_eq!(
            jams.iter().map(|jam| (jam.edge, jam.figures.waiting_secs)).collect::<Vec<_>>(),
            [(6, 4.0), (5, 3.0)]
        );
        assert!(reader.jams(clock(7, 201)).is_none(), "the plugin has ended");
        assert!(
            reader.jams(clock(8, 100)).is_none() && reader.jams(None).is_none(),
            "another run, no engine"
        );
    }
}
