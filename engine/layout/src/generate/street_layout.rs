//! A rectangular layout of streets, and its road network of nodes and edges.
//!
//! A street has one or two one-way carriageways. Lengths are whole millimetres, so that no result
//! depends on rounding.

/// A street from one end of the layout to the other.
#[derive(Clone, Copy, Debug)]
pub struct Street {
    /// The x of a column, or the y of a row.
    pub at: i64,
    /// The directions of its carriageways.
    pub directions: Directions,
    /// Millimetres per second.
    pub speed: u32,
    /// The speed in reverse gear in millimetres per second; `None` if that isn't allowed.
    pub reverse: Option<u32>,
    /// The number of edges between two intersections.
    pub stops: u32,
}

/// The directions in which a street may be driven. Ascending is to the north or to the east.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    Ascending,
    Descending,
    Both,
}

/// A rectangle of streets. The outermost ones end where they meet.
pub struct StreetLayout {
    /// The streets to the north, from west to east.
    pub columns: Vec<Street>,
    /// The streets to the east, from south to north.
    pub rows: Vec<Street>,
    /// The distance between the centre lines of a street's two carriageways.
    pub carriageway_gap: i64,
    /// The distance from the centre of an intersection to its entries and exits.
    pub intersection_radius: i64,
    /// The speed in a turn in millimetres per second.
    pub turn_speed: u32,
    /// Whether there are chargers in bays beside the outermost columns.
    pub has_chargers: bool,
}

/// Nodes and edges. The id of a node or an edge is its position in the list, from 1.
#[derive(Default)]
pub struct RoadNetwork {
    pub nodes: Vec<RoadNode>,
    pub edges: Vec<RoadEdge>,
}

#[derive(Clone, Copy)]
pub struct RoadNode {
    pub x: i64,
    pub y: i64,
    pub heading: Heading,
    /// Whether the node is a charger.
    pub is_charger: bool,
}

pub struct RoadEdge {
    pub origin: u32,
    pub destination: u32,
    /// `None` for a straight edge.
    pub handles: Option<RoadHandles>,
    pub speed: u32,
    pub reverse: Option<u32>,
}

/// The handle lengths of a curved edge.
#[derive(Clone, Copy)]
pub struct RoadHandles {
    pub origin: i64,
    pub destination: i64,
}

/// A heading in quarter turns counter-clockwise from east.
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

impl Directions {
    /// Returns the direction of a one-way street by its number. Neighbours have opposite
    /// directions.
    pub fn alternating(number: usize) -> Self {
        if number % 2 == 1 { Self::Ascending } else { Self::Descending }
    }

    fn allow(self, heading: Heading) -> bool {
        match self {
            Self::Both => true,
            Self::Ascending => matches!(heading, East | North),
            Self::Descending => matches!(heading, West | South),
        }
    }
}

/// The ids of an intersection's nodes by heading: the ends of arriving carriageways and the starts
/// of departing carriageways.
#[derive(Clone, Copy, Default)]
struct Intersection {
    entries: [Option<u32>; 4],
    exits: [Option<u32>; 4],
}

impl StreetLayout {
    /// Builds the road network of the layout.
    pub fn build(&self) -> RoadNetwork {
        let mut network = RoadNetwork::default();
        let intersections: Vec<_> =
            self.positions().map(|at| self.add_intersection(at, &mut network)).collect();
        for at in self.positions() {
            for heading in HEADINGS {
                self.add_carriageway(at, heading, &intersections, &mut network);
            }
        }
        for (at, intersection) in self.positions().zip(&intersections) {
            self.connect_entries_to_exits(at, intersection, &mut network);
        }
        network
    }

    /// Returns the positions of the intersections as (column, row), row by row.
    fn positions(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
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
        let column =
            column.checked_add_signed(dx as isize).filter(|&column| column < self.columns.len())?;
        let row = row.checked_add_signed(dy as isize).filter(|&row| row < self.rows.len())?;
        Some((column, row))
    }

    /// Adds the nodes of an intersection: one for each carriageway that ends or starts there.
    fn add_intersection(&self, at: (usize, usize), network: &mut RoadNetwork) -> Intersection {
        let mut intersection = Intersection::default();
        for heading in HEADINGS {
            let street = self.street(at, heading);
            if !street.directions.allow(heading) {
                continue;
            }
            if self.neighbour(at, heading.opposite()).is_some() {
                let entry = self.carriageway_end(at, heading, -self.intersection_radius);
                intersection.entries[heading as usize] = Some(network.add_node(entry));
            }
            if self.neighbour(at, heading).is_some() {
                let exit = self.carriageway_end(at, heading, self.intersection_radius);
                intersection.exits[heading as usize] = Some(network.add_node(exit));
            }
        }
        intersection
    }

    /// Returns the node on a carriageway at the distance `ahead` beyond the intersection's centre.
    fn carriageway_end(&self, at: (usize, usize), heading: Heading, ahead: i64) -> RoadNode {
        let (dx, dy) = heading.vector();
        let is_dual = self.street(at, heading).directions == Directions::Both;
        let right = if is_dual { self.carriageway_gap / 2 } else { 0 };
        let (x, y) = (self.columns[at.0].at, self.rows[at.1].at);
        RoadNode {
            x: x + ahead * dx + right * dy,
            y: y + ahead * dy - right * dx,
            heading,
            is_charger: false,
        }
    }

    /// Adds the straight edges of a carriageway up to the next intersection.
    fn add_carriageway(
        &self,
        at: (usize, usize),
        heading: Heading,
        intersections: &[Intersection],
        network: &mut RoadNetwork,
    ) {
        let Some(next) = self.neighbour(at, heading) else { return };
        let [here, next] = [at, next].map(|(column, row)| row * self.columns.len() + column);
        let (Some(mut origin), Some(last)) = (
            intersections[here].exits[heading as usize],
            intersections[next].entries[heading as usize],
        ) else {
            return;
        };
        let (from, to) = (network.node(origin), network.node(last));
        let street = self.street(at, heading);
        let stops = i64::from(street.stops);
        let mut nodes = vec![origin];
        for stop in 1..=stops {
            let node = from.towards(to, stop, stops);
            let destination = if stop == stops { last } else { network.add_node(node) };
            let (speed, reverse) = (street.speed, street.reverse);
            network.edges.push(RoadEdge { origin, destination, handles: None, speed, reverse });
            origin = destination;
            nodes.push(origin);
        }
        // The outer carriageways have the ring road on their left.
        let is_outside = [(0, South), (self.columns.len() - 1, North)].contains(&(at.0, heading));
        if self.has_chargers && is_outside {
            for stops in nodes.windows(4).step_by(3) {
                self.add_charger(stops[0], stops[3], street.speed, network);
            }
        }
    }

    /// Adds a bay with a charger on the right of a carriageway, from one of its nodes to another.
    fn add_charger(&self, first: u32, last: u32, speed: u32, network: &mut RoadNetwork) {
        let (from, to) = (network.node(first), network.node(last));
        let ((dx, dy), gap) = (from.heading.vector(), self.carriageway_gap);
        let [entry, charger] = [1, 2].map(|part| {
            let node = from.towards(to, part, 3);
            let (x, y, is_charger) = (node.x + gap * dy, node.y - gap * dx, part == 2);
            network.add_node(RoadNode { x, y, is_charger, ..node })
        });
        let handle = ((to.x - from.x) * dx + (to.y - from.y) * dy) / 6;
        let curved = Some(RoadHandles { origin: handle, destination: handle });
        for (origin, destination, handles) in
            [(first, entry, curved), (entry, charger, None), (charger, last, curved)]
        {
            let speed = if handles.is_some() { self.turn_speed } else { speed.min(1000) };
            network.edges.push(RoadEdge { origin, destination, handles, speed, reverse: None });
        }
    }

    /// Adds the edges from every entry of an intersection to every exit, U-turns excepted.
    fn connect_entries_to_exits(
        &self,
        at: (usize, usize),
        intersection: &Intersection,
        network: &mut RoadNetwork,
    ) {
        for from in HEADINGS {
            let Some(entry) = intersection.entries[from as usize] else { continue };
            for to in HEADINGS.into_iter().filter(|&to| to != from.opposite()) {
                let Some(exit) = intersection.exits[to as usize] else { continue };
                let handles =
                    (from != to).then(|| quarter_turn(network.node(entry), network.node(exit)));
                let speed = if from == to { self.street(at, to).speed } else { self.turn_speed };
                network.edges.push(RoadEdge {
                    origin: entry,
                    destination: exit,
                    handles,
                    speed,
                    reverse: None,
                });
            }
        }
    }
}

/// Returns the handle lengths of a quarter of an ellipse: 4/3 (√2 - 1) of its semi-axes.
fn quarter_turn(from: RoadNode, to: RoadNode) -> RoadHandles {
    let [origin, destination] = [from.heading, to.heading].map(|heading| {
        let (dx, dy) = heading.vector();
        (((to.x - from.x) * dx + (to.y - from.y) * dy) * 5523 + 5000) / 10_000
    });
    RoadHandles { origin, destination }
}

impl RoadNode {
    /// Returns a node with the same heading at a fraction of the way to another.
    fn towards(self, to: Self, part: i64, parts: i64) -> Self {
        let x = self.x + (to.x - self.x) * part / parts;
        let y = self.y + (to.y - self.y) * part / parts;
        Self { x, y, ..self }
    }
}

impl RoadNetwork {
    fn add_node(&mut self, node: RoadNode) -> u32 {
        self.nodes.push(node);
        self.nodes.len() as u32
    }

    fn node(&self, id: u32) -> RoadNode {
        self.nodes[id as usize - 1]
    }
}
