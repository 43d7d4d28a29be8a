//! Finds the pairs of a conflict table: tracks near each other by a grid, then stretch by stretch.

use regatta_base::cores;
use regatta_base::sweep::{Grid, Outlines, Rectangle, Sweep, SweptBox, Touching, touching};

use super::super::{Roads, angle_between};
use super::{ConflictTable, Pair, RESOLUTION, Relation};

/// Everything that finding pairs needs.
struct Finder<'a> {
    roads: &'a Roads,
    sweeps: &'a [Sweep],
    lengths: &'a [f32],
    /// By edge: the edges that it leads into within [`AHEAD`], with the metres in between.
    ahead: Vec<Vec<(u32, f32)>>,
    /// By footprint and track.
    swept: Vec<Vec<Outlines<'a>>>,
}

/// The distance beyond its end for which an edge is followed, in robots' lengths.
const AHEAD: f32 = 2.5;

/// A pair of tracks that touch.
struct Found {
    tracks: [u32; 2],
    touching: Touching,
    /// Whether the first leads into the second (and the metres in between), or the second into the
    /// first.
    leads: [Option<f32>; 2],
}

/// Makes the tables of all pairs of footprints.
pub fn tables(
    roads: &Roads,
    sweeps: &[Sweep],
    discs: &[u32],
    lengths: &[f32],
) -> Vec<ConflictTable> {
    let mut places = vec![None; roads.nodes() as usize];
    for &node in discs {
        places[node as usize] = Some(SweptBox::disc(roads.position(node)));
    }
    let boxes = sweeps.iter().map(Sweep::boxes).chain(places.iter().map(|place| place.as_slice()));
    let boxes: Vec<&[SweptBox]> = boxes.collect();
    let mut swept: Vec<Vec<Outlines<'_>>> = Vec::new();
    for footprint in roads.footprints() {
        swept.push(cores::map(boxes.len(), |track| Outlines::new(boxes[track], footprint)));
    }
    let longest =
        roads.footprints().iter().map(|footprint| 2.0 * footprint.reach()).fold(0.0, f32::max);
    let ahead =
        cores::map(sweeps.len(), |edge| edges_ahead(roads, sweeps, edge as u32, AHEAD * longest));
    let finder = Finder { roads, sweeps, lengths, ahead, swept };
    let count = roads.footprints().len();
    (0..count * count).map(|pair| finder.table(pair / count, pair % count)).collect()
}

impl Finder<'_> {
    /// Makes the table of robots with footprint `own` and robots with footprint `other`.
    fn table(&self, own: usize, other: usize) -> ConflictTable {
        let tracks = self.swept[other].len();
        let swept: Vec<&[Rectangle]> =
            self.swept[other].iter().map(|swept| swept.rectangles()).collect();
        let radius =
            self.swept[own].iter().flat_map(|swept| swept.rectangles()).map(Rectangle::radius);
        let grid = Grid::new(&swept, 2.0 * radius.fold(0.5, f32::max));
        let found = cores::map(tracks, |track| self.find(own, other, &grid, track as u32));
        let found: Vec<Found> = found.into_iter().flatten().collect();
        let separations = self.separations([own, other], tracks, &found);
        let pairs =
            found.iter().flat_map(|found| self.pairs(own == other, found, &separations)).collect();
        ConflictTable::new(pairs, separations)
    }

    /// Finds the pairs of a track with all others.
    fn find(&self, own: usize, other: usize, grid: &Grid, a: u32) -> Vec<Found> {
        let mut found = Vec::new();
        let swept = &self.swept[own][a as usize];
        for b in grid.near(swept.rectangles()) {
            // With one footprint a pair is found once, and seen from both sides.
            if b == a || (own == other && b < a) || !self.roads.may_meet(a, b) {
                continue;
            }
            let Some(touching) = touching(swept, &self.swept[other][b as usize]) else { continue };
            found.push(Found {
                tracks: [a, b],
                leads: self.leads([own, other], [a, b], &touching),
                touching,
            });
        }
        found
    }

    /// Whether one of two tracks leads into the other, so that robots on them follow each other.
    fn leads(
        &self,
        footprints: [usize; 2],
        [a, b]: [u32; 2],
        touching: &Touching,
    ) -> [Option<f32>; 2] {
        let leads = [
            self.metres_between(footprints, a, b, touching.apart[0]),
            self.metres_between(footprints, b, a, touching.apart[1]),
        ];
        if leads[0].is_some() && leads[1].is_some() { [None; 2] } else { leads }
    }

    /// Returns the metres from the end of an edge to the start of one that it leads into, unless
    /// robots that touch are too far `apart` for that.
    fn metres_between(
        &self,
        [own, other]: [usize; 2],
        from: u32,
        to: u32,
        apart: f32,
    ) -> Option<f32> {
        let between = self.ahead.get(from as usize)?.iter().find(|(edge, _)| *edge == to)?.1;
        // On a road that turns back beside itself, robots far apart along it may touch.
        let footprints = self.roads.footprints();
        let nearest = footprints[own].reach() + footprints[other].reach();
        (between + apart < AHEAD * nearest).then_some(between)
    }

    /// Returns the distances at which robots follow each other, in metres: by the track of the one
    /// behind. A robot that keeps this distance never blocks the one ahead, whichever way that one
    /// takes.
    fn separations(&self, footprints: [usize; 2], tracks: usize, found: &[Found]) -> Vec<f32> {
        let [own, other] = footprints;
        let mut separations = cores::map(tracks, |track| self.separation(own, other, track as u32));
        for Found { tracks: [a, b], touching, leads } in found {
            let behind =
                [(*a, *b, leads[0], touching.apart[0]), (*b, *a, leads[1], touching.apart[1])];
            for (behind, ahead, between, apart) in behind {
                let Some(between) = between else { continue };
                let apart = self.straight_on(footprints, behind, ahead).unwrap_or(between + apart);
                let separation = &mut separations[behind as usize];
                *separation = separation.max(apart);
            }
        }
        for separation in &mut separations {
            *separation += RESOLUTION;
        }
        separations
    }

    /// Returns the entries of a pair; with one footprint it is seen from both sides.
    fn pairs(
        &self,
        both: bool,
        found: &Found,
        separations: &[f32],
    ) -> impl Iterator<Item = (u32, Pair)> + use<> {
        let [a, b] = found.tracks;
        let relation = match found.leads {
            [Some(between), _] => Relation::Into((separations[a as usize] - between).max(0.0)),
            [_, Some(between)] => Relation::From((separations[b as usize] - between).max(0.0)),
            _ => Relation::Crossing { own: found.touching.own, other: found.touching.other },
        };
        let [own, other] = [a, b].map(|track| self.lengths[track as usize]);
        let pair = (a, Pair::new(b, relation, own, other));
        let seen_from_other = (b, Pair::new(a, seen_from_other(relation), other, own));
        std::iter::once(pair).chain(both.then_some(seen_from_other))
    }

    /// Returns the distance between robots that touch where a straight edge leads straight on into
    /// another one.
    fn straight_on(&self, [own, other]: [usize; 2], front: u32, back: u32) -> Option<f32> {
        let (first, second) = (&self.sweeps[front as usize], &self.sweeps[back as usize]);
        let turn = angle_between(first.headings()[1], second.headings()[0]);
        let goes_on = first.is_straight() && second.is_straight() && turn < 1e-4;
        let footprints = self.roads.footprints();
        if !goes_on {
            return None;
        }
        first.straight_separation(&footprints[own], &footprints[other])
    }

    /// Returns how far apart two robots on a track have to be, in metres.
    fn separation(&self, own: usize, other: usize, track: u32) -> f32 {
        let footprints = self.roads.footprints();
        let straight = self.sweeps.get(track as usize).filter(|sweep| sweep.is_straight());
        if let Some(separation) = straight
            .and_then(|sweep| sweep.straight_separation(&footprints[own], &footprints[other]))
        {
            return separation;
        }
        let (a, b) = (&self.swept[own][track as usize], &self.swept[other][track as usize]);
        touching(a, b).map_or(0.0, |touching| touching.farthest)
    }
}

fn seen_from_other(relation: Relation) -> Relation {
    match relation {
        Relation::Crossing { own, other } => Relation::Crossing { own: other, other: own },
        Relation::Into(metres) => Relation::From(metres),
        Relation::From(metres) => Relation::Into(metres),
    }
}

/// The largest turn between edges that are driven both ways on which robots follow each other, in
/// radians. Beyond a sharper one a robot is out of the way of those behind it sooner than the
/// distance along the road says.
const SHARP: f32 = core::f32::consts::FRAC_PI_4;

/// Returns the edges that an edge leads into within some metres of its end, forward, with the
/// metres in between.
fn edges_ahead(roads: &Roads, sweeps: &[Sweep], edge: u32, metres: f32) -> Vec<(u32, f32)> {
    let mut ahead: Vec<(u32, f32)> = Vec::new();
    let mut open = vec![(edge, 0.0)];
    while let Some((last, between)) = open.pop() {
        for leg in roads.exits(roads.edge(last).destination) {
            if leg.is_reverse() || is_sharp(roads, sweeps, last, leg.edge()) {
                continue;
            }
            let known = ahead.iter_mut().find(|(known, _)| *known == leg.edge());
            match known {
                Some((_, nearest)) if *nearest <= between => continue,
                Some((_, nearest)) => *nearest = between,
                None => ahead.push((leg.edge(), between)),
            }
            let length = roads.edge(leg.edge()).length;
            if between + length < metres {
                open.push((leg.edge(), between + length));
            }
        }
    }
    ahead
}

/// Whether an edge leads into another one by a sharp turn, and both are driven both ways.
fn is_sharp(roads: &Roads, sweeps: &[Sweep], from: u32, to: u32) -> bool {
    let turn =
        angle_between(sweeps[from as usize].headings()[1], sweeps[to as usize].headings()[0]);
    turn > SHARP && is_two_way(roads, from) && is_two_way(roads, to)
}

/// Whether another edge leads back from an edge's destination to its origin.
fn is_two_way(roads: &Roads, edge: u32) -> bool {
    let road = roads.edge(edge);
    let mut exits = roads.exits(road.destination).iter();
    exits.any(|&back| back.edge() != edge && roads.end(back) == road.origin)
}
