//! Streets that cross: lanes, crossings and the ways through them.
//!
//! Lengths are whole millimetres, so that nothing depends on rounding.

/// A street from one end of the plan to the other.
#[derive(Clone, Copy, Debug)]
pub struct Street {
    /// x of a column, y of a row.
    pub at: i64,
    /// Which lanes it has.
    pub ways: Ways,
    /// Millimetres per second.
    pub speed: u32,
    /// Speed in reverse gear, if that is allowed.
    pub reverse: Option<u32>,
    /// Edges between two crossings.
    pub stops: u32,
}

/// Lanes of a street. Up is to the north or to the east.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ways {
    Up,
    Down,
    Both,
}

/// A rectangle of streets. The first and last of each kind end at each other.
pub struct Plan {
    /// Streets to the north, from west to east.
    pub columns: Vec<Street>,
    /// Streets to the east, from south to north.
    pub rows: Vec<Street>,
    /// Between the middles of a street's two lanes.
    pub lane_gap: i64,
    /// From a crossing's centre to where its arms begin.
    pub crossing: i64,
    /// Speed in a turn, millimetres per second.
    pub turn_speed: u32,
}

/// Nodes and edges; a node's id is its place in the list, from 1, and so is an edge's.
#[derive(Default)]
pub struct Roads {
    pub nodes: Vec<RoadNode>,
    pub edges: Vec<RoadEdge>,
}

#[derive(Clone, Copy)]
pub struct RoadNode {
    pub x: i64,
    pub y: i64,
    pub heading: Heading,
}

pub struct RoadEdge {
    pub origin: u32,
    pub destination: u32,
    /// Handle lengths at the origin and at the destination; `None` for a straight edge.
    pub handles: Option<(i64, i64)>,
    pub speed: u32,
    pub reverse: Option<u32>,
}

/// Quarter turns counter-clockwise from east.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    East,
    North,
    West,
    South,
}

use Heading::{East, North, South, West};

const HEADINGS: [Heading; 4] = [East, North, West, South];

impl Heading {
    fn vector(self) -> (i64, i64) {
        [(1, 0), (0, 1), (-1, 0), (0, -1)][self as usize]
    }

    fn opposite(self) -> Self {
        HEADINGS[(self as usize + 2) % 4]
    }
}

/// Ids of a crossing's nodes by heading: where lanes end, and where they begin.
#[derive(Clone, Copy, Default)]
struct Crossing {
    entries: [Option<u32>; 4],
    exits: [Option<u32>; 4],
}

impl Plan {
    pub fn build(&self) -> Roads {
        let mut roads = Roads::default();
        let crossings: Vec<Crossing> = self.places().map(|place| self.crossing(place, &mut roads)).collect();
        for place in self.places() {
            for heading in [East, North, West, South] {
                self.lane(place, heading, &crossings, &mut roads);
            }
        }
        for (place, crossing) in self.places().zip(&crossings) {
            self.ways_through(place, crossing, &mut roads);
        }
        roads
    }

    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let columns = self.columns.len();
        (0..self.rows.len()).flat_map(move |row| (0..columns).map(move |column| (column, row)))
    }

    fn street(&self, (column, row): (usize, usize), heading: Heading) -> &Street {
        match heading {
            East | West => &self.rows[row],
            North | South => &self.columns[column],
        }
    }

    fn neighbour(&self, (column, row): (usize, usize), heading: Heading) -> Option<(usize, usize)> {
        let (dx, dy) = heading.vector();
        let column = column.checked_add_signed(dx as isize).filter(|&column| column < self.columns.len())?;
        let row = row.checked_add_signed(dy as isize).filter(|&row| row < self.rows.len())?;
        Some((column, row))
    }

    /// A crossing's nodes: one for each lane that ends or begins there.
    fn crossing(&self, place: (usize, usize), roads: &mut Roads) -> Crossing {
        let mut crossing = Crossing::default();
        for heading in HEADINGS {
            let street = self.street(place, heading);
            if !street.ways.allow(heading) {
                continue;
            }
            let mut node = |side| Some(roads.add_node(self.lane_end(place, heading, side)));
            if self.neighbour(place, heading.opposite()).is_some() {
                crossing.entries[heading as usize] = node(-self.crossing);
            }
            if self.neighbour(place, heading).is_some() {
                crossing.exits[heading as usize] = node(self.crossing);
            }
        }
        crossing
    }

    /// The point on a lane that is `ahead` of the crossing's centre.
    fn lane_end(&self, place: (usize, usize), heading: Heading, ahead: i64) -> RoadNode {
        let (dx, dy) = heading.vector();
        let right = if self.street(place, heading).ways == Ways::Both { self.lane_gap / 2 } else { 0 };
        let (x, y) = (self.columns[place.0].at, self.rows[place.1].at);
        RoadNode { x: x + ahead * dx + right * dy, y: y + ahead * dy - right * dx, heading }
    }

    /// The straight edges of a lane up to the next crossing.
    fn lane(&self, place: (usize, usize), heading: Heading, crossings: &[Crossing], roads: &mut Roads) {
        let at = |(column, row): (usize, usize)| &crossings[row * self.columns.len() + column];
        let Some(next) = self.neighbour(place, heading) else { return };
        let ends = (at(place).exits[heading as usize], at(next).entries[heading as usize]);
        let (Some(mut origin), Some(last)) = ends else { return };
        let (from, to) = (roads.node(origin), roads.node(last));
        let street = self.street(place, heading);
        let stops = i64::from(street.stops);
        for stop in 1..=stops {
            let between = |a: i64, b: i64| a + (b - a) * stop / stops;
            let node = RoadNode { x: between(from.x, to.x), y: between(from.y, to.y), heading };
            let destination = if stop == stops { last } else { roads.add_node(node) };
            let (speed, reverse) = (street.speed, street.reverse);
            roads.edges.push(RoadEdge { origin, destination, handles: None, speed, reverse });
            origin = destination;
        }
    }

    /// From every lane that ends at a crossing into every lane that begins there, except back.
    fn ways_through(&self, place: (usize, usize), crossing: &Crossing, roads: &mut Roads) {
        for (entry, from) in
            HEADINGS.into_iter().filter_map(|heading| Some((crossing.entries[heading as usize]?, heading)))
        {
            for to in HEADINGS.into_iter().filter(|&to| to != from.opposite()) {
                let Some(exit) = crossing.exits[to as usize] else { continue };
                let handles = (from != to).then(|| quarter_turn(roads.node(entry), roads.node(exit)));
                let speed = if from == to { self.street(place, to).speed } else { self.turn_speed };
                roads.edges.push(RoadEdge { origin: entry, destination: exit, handles, speed, reverse: None });
            }
        }
    }
}

/// Handle lengths of a quarter of an ellipse: 4/3 (√2 - 1) of its half axes.
fn quarter_turn(from: RoadNode, to: RoadNode) -> (i64, i64) {
    let along = |heading: Heading| {
        let (dx, dy) = heading.vector();
        (((to.x - from.x) * dx + (to.y - from.y) * dy) * 5523 + 5000) / 10_000
    };
    (along(from.heading), along(to.heading))
}

impl Ways {
    fn allow(self, heading: Heading) -> bool {
        match self {
            Self::Both => true,
            Self::Up => matches!(heading, East | North),
            Self::Down => matches!(heading, West | South),
        }
    }
}

impl Roads {
    fn add_node(&mut self, node: RoadNode) -> u32 {
        self.nodes.push(node);
        self.nodes.len() as u32
    }

    fn node(&self, id: u32) -> RoadNode {
        self.nodes[id as usize - 1]
    }
}
