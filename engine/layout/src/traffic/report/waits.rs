//! The lines about robots in each other's way: zones, rings, stations, nodes beside roads.

use regatta_base::graph::{EdgeIndex, NodeIndex};

use super::names::{Writer, listed};
use super::{Remark, Topic};
use crate::model::value::{plural, shorten};
use crate::model::zones::{Zone, ZoneRule};
use crate::traffic::InTheWay;
use crate::traffic::rings::{Others, Rings};
use crate::traffic::room::{Certainty, Count};
use crate::traffic::stations::{BlockingStation, Effect};

impl Writer<'_> {
    /// The line about the zones, if there are any.
    pub fn zones(&self) -> Option<Remark> {
        let zones = self.certificate.zones.as_slice();
        let (noun, let_in) = match zones.len() {
            0 => return None,
            1 => ("zone", "lets"),
            _ => ("zones", "let"),
        };
        let message = format!(
            "{} {noun} ({}) {let_in} fewer robots in than the roads hold, and robots may wait for \
             each other there: the numbers in the other lines are bounds, which don't count zones \
             unless they say so{}; let robots stop outside of zones",
            zones.len(),
            listed(zones.len(), zones.iter().map(zone)),
            self.kept_apart()
        );
        let edges: Vec<_> = zones.iter().flat_map(|zone| &zone.edges).copied().collect();
        let nodes: Vec<_> = zones.iter().flat_map(|zone| &zone.nodes).copied().collect();
        Some(Remark::new(Topic::Zone, message).about(&nodes).on(&edges))
    }

    /// The pairs of nodes at which zones keep two robots from waiting for each other, in words.
    fn kept_apart(&self) -> String {
        match self.certificate.rings.kept_apart {
            0 => String::new(),
            pairs => format!(
                "; at {} two robots would wait for each other, if {} let both in",
                pairs_of_nodes(pairs),
                if self.certificate.zones.len() == 1 { "it" } else { "they" }
            ),
        }
    }

    pub fn rings(&self) -> Vec<Remark> {
        let rings = &self.certificate.rings;
        let mut remarks = Vec::new();
        if let Some((a, b)) = rings.pair {
            let message = format!(
                "2 robots may wait for each other at {}, such as {} and {}: unless they can pass \
                 between nodes, one has to back off; let robots in from one side at a time",
                pairs_of_nodes(rings.pairs),
                self.node(a),
                self.node(b)
            );
            let robots = Some(Count { robots: 2, certainty: Certainty::Exact });
            remarks.push(Remark { robots, ..Remark::new(Topic::Ring, message).about(&[a, b]) });
        }
        remarks.extend(rings.smallest.iter().map(|ring| self.ring(ring)));
        remarks.extend(other_rings(rings));
        remarks.extend(self.safe());
        remarks
    }

    /// The number of robots that is proved safe, if there is one.
    fn safe(&self) -> Option<Remark> {
        let on_roads = self.certificate.safe_on_roads();
        let in_zones = self.certificate.safe_in_zones();
        let message = match (on_roads, in_zones) {
            (Some(0), _) => return None,
            (_, Some(robots)) if on_roads.is_none_or(|on_roads| robots < on_roads) => {
                safe_with_zones(robots, on_roads)
            }
            (Some(1), _) => {
                "1 robot alone is safe; 2 or more may all wait for each other".to_owned()
            }
            (_, None) => format!("{}: nothing to fix", never_wait(on_roads)),
            (_, Some(_)) => format!("{}: more may all wait for each other", never_wait(on_roads)),
        };
        Some(Remark::new(Topic::Ring, message))
    }

    fn ring(&self, ring: &[NodeIndex]) -> Remark {
        let mut zones = self.certificate.zones.iter();
        if let Some(guard) = zones.find(|zone| zone.keeps_apart(ring)) {
            let message = format!(
                "{} robots at {} would close a ring, but zone {} never lets all of them in: keep \
                 the zone",
                ring.len(),
                self.nodes(ring),
                zone(guard)
            );
            return Remark::new(Topic::Ring, message).about(ring);
        }
        let message = format!(
            "{} robots at {} close a ring: each waits for the next one; keep one of these nodes \
             free, or add a way out",
            ring.len(),
            self.nodes(ring)
        );
        let robots = Some(Count { robots: ring.len() as u32, certainty: Certainty::Exact });
        Remark { robots, ..Remark::new(Topic::Ring, message).about(ring) }
    }

    pub fn station(&self, station: &BlockingStation) -> Remark {
        let name = self.station_at(station.node);
        let effect = match station.effect {
            Effect::CutsOff(from, to) => format!(
                "no way leads from {} to {} meanwhile; move it to a bay beside the road, or add a \
                 way round",
                self.node(from),
                self.node(to)
            ),
            Effect::Detour => "others have to take another way; move it to a bay beside the road, \
                               or keep that way free"
                .to_owned(),
            Effect::Unknown => "it isn't known whether another way exists, as the search was \
                                stopped; move it to a bay beside the road"
                .to_owned(),
        };
        let message = format!("a robot at the station {name} blocks a through road: {effect}");
        Remark::new(Topic::Station, message).about(&[station.node])
    }

    pub fn in_the_way(&self, found: &InTheWay) -> Remark {
        let InTheWay { node, edges, swept } = found;
        let (name, standing, turning) = (self.node(*node), self.ends(edges), self.ends(swept));
        let who = match (edges.is_empty(), swept.is_empty()) {
            (true, _) => format!("a robot that turns at node {name} touches robots on {turning}"),
            (false, true) => format!("a robot at node {name} touches robots on {standing}"),
            (false, false) => format!(
                "a robot at node {name} touches robots on {standing}, and one that turns those on \
                 {turning}"
            ),
        };
        let message = format!("{who}: stop elsewhere, or move the roads apart");
        let all = [edges.as_slice(), swept].concat();
        Remark::new(Topic::InTheWay, message).about(&[*node]).on(&all)
    }

    /// Edges in words, as those that don't end at a node.
    fn ends(&self, edges: &[EdgeIndex]) -> String {
        let verb = if edges.len() == 1 { "doesn't" } else { "don't" };
        format!("{}, which {verb} end there", self.edges(edges))
    }
}

fn zone(zone: &Zone) -> String {
    let rule = match zone.rule {
        ZoneRule::Capacity(robots) => plural(robots.get() as usize, "robot"),
        ZoneRule::SameDirection => "one direction at a time".to_owned(),
    };
    format!("`{}`: {rule}", shorten(&zone.name))
}

/// The line about rings that aren't listed, if there are any or it isn't known.
fn other_rings(rings: &Rings) -> Option<Remark> {
    let last = rings.smallest.last().map_or(3, Vec::len);
    let stopped = "the search for rings of 3 robots or more was stopped";
    let message = match (rings.others, rings.certainty) {
        (Others::None, _) => return None,
        (_, Certainty::Bound) if rings.smallest.is_empty() => {
            format!("{stopped}: it isn't known whether there are any")
        }
        (_, Certainty::Bound) => {
            format!("{stopped}: there may be more, and smaller ones than those here")
        }
        (Others::Unknown, Certainty::Exact) => {
            format!("{stopped}: there may be more, of {last} robots or more")
        }
        (Others::Some, Certainty::Exact) => format!(
            "more rings, of {last} robots or more, aren't listed: these are the smallest ones"
        ),
    };
    Some(Remark::new(Topic::Ring, message))
}

/// Tells how many robots are safe where zones allow fewer than the roads.
fn safe_with_zones(robots: u32, on_roads: Option<u32>) -> String {
    let without = match on_roads {
        None => "any number of robots is safe".to_owned(),
        Some(on_roads) => format!("it takes {} robots or more", on_roads + 1),
    };
    match robots {
        1 => format!(
            "1 robot alone is safe with the zones: 2 or more may wait for each other there; \
             without zones, {without}"
        ),
        _ => format!(
            "{}: more may wait at zones; without zones, {without}",
            never_wait(Some(robots))
        ),
    }
}

/// Tells that a number of robots, or any number of them, is safe.
fn never_wait(robots: Option<u32>) -> String {
    let robots =
        robots.map_or("any number of robots".to_owned(), |robots| format!("up to {robots} robots"));
    format!("{robots} at nodes never all wait for each other, wherever they stand and go")
}

fn pairs_of_nodes(count: usize) -> String {
    if count == 1 { "1 pair of nodes".to_owned() } else { format!("{count} pairs of nodes") }
}
