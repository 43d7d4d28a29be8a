//! The route graph as hand-overs read it: the pieces of each leg in order, and the edges that leave
//! each node.

use std::collections::BTreeSet;
use std::sync::Arc;

use regatta_base::graph::{EdgeIndex, Gear, Leg, NodeIndex};

use super::piece::{Piece, PieceInfo};
use super::pieces::{MAX_PIECES, PieceIndex};
use super::routes::BaseEnd;
use super::tracks::Tracks;

/// An edge of the graph, without its shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The node where the edge starts.
    pub origin: NodeIndex,
    /// The node where the edge ends.
    pub destination: NodeIndex,
    /// Metres per second from origin to destination; above 0.
    pub speed: f64,
    /// Metres per second from destination to origin in reverse gear; `None` if that isn't allowed.
    pub reverse_speed: Option<f64>,
}

/// A leg, with all that a hand-over at its end or its start needs to know: half a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct CompiledLeg {
    /// Its first piece, in its gear.
    pub first_piece: PieceIndex,
    /// Commanded speed in metres per second; 0 if the leg can't be driven.
    pub speed: f32,
    /// Metres.
    pub length: f32,
    /// The node that it leads to.
    pub end: NodeIndex,
    /// The span of its first piece.
    pub(super) first_span: PieceSpan,
    /// The first of the edges that leave its end, in [`Exits`].
    first_exit: u32,
    /// The number of these edges, or [`MANY_EXITS`].
    exit_count: u16,
    /// The place among these of the edge that leads straight back, or [`NO_RETURN`].
    return_place: u16,
}

/// The number of exits from which on they aren't counted in [`CompiledLeg`].
const MANY_EXITS: u16 = u16::MAX;

/// The place of a way back that doesn't exist.
const NO_RETURN: u16 = u16::MAX;

/// The length of a piece and its position on the edge. Small, because each hand-over reads two of
/// these at random.
#[derive(Clone, Copy, Debug)]
pub(super) struct PieceSpan {
    /// In units of [`Distance`](crate::piece::Distance), less than 2³¹; bit 31 marks
    /// the last of a leg.
    length_and_last: u32,
    /// Metres along the edge from its origin to the end of this piece.
    pub s_end: f32,
}

impl PieceSpan {
    const LAST: u32 = 1 << 31;

    /// In units of [`Distance`](crate::piece::Distance).
    pub fn length(self) -> i32 {
        (self.length_and_last & !Self::LAST) as i32
    }

    /// Whether its leg ends with it.
    pub fn is_last(self) -> bool {
        self.length_and_last & Self::LAST != 0
    }
}

/// The error of compiling a graph with more pieces than a [`PieceIndex`] can tell apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyPieces {
    /// The number of pieces.
    pub pieces: usize,
    /// The largest number that an index can tell apart.
    pub max: usize,
}

/// The legs of a route graph, for hand-overs.
#[derive(Debug)]
pub struct LegTable {
    /// By node: its id in events.
    node_ids: Vec<u32>,
    tracks: Arc<Tracks>,
    /// By piece.
    spans: Vec<PieceSpan>,
    /// By piece: metres from its end to the end of its leg.
    rests: Vec<f32>,
    /// By edge: its legs in forward and in reverse gear.
    forward: Vec<CompiledLeg>,
    reverse: Vec<CompiledLeg>,
    exits: Exits,
    /// Edges that no robot may enter. Ordered by index, and mostly empty.
    closed: BTreeSet<EdgeIndex>,
    /// Edges that no robot may enter for now, although routes lead along them: behind closed doors.
    barred: BTreeSet<EdgeIndex>,
}

impl LegTable {
    /// Compiles the legs of a graph: its edges, the ids of its nodes, and the pieces of both.
    ///
    /// # Errors
    /// If there are more than [`MAX_PIECES`] pieces.
    ///
    /// # Panics
    /// If an edge has no node, or `tracks` are those of another graph.
    pub fn new(
        node_ids: Vec<u32>,
        edges: &[Edge],
        tracks: Arc<Tracks>,
    ) -> Result<Self, TooManyPieces> {
        check_pieces(tracks.pieces().len())?;
        let edge_indices = || (0..edges.len() as u32).map(EdgeIndex);
        let forward = edge_indices().map(|edge| Leg { edge, gear: Gear::Forward });
        let reverse = edge_indices().map(|edge| Leg { edge, gear: Gear::Reverse });
        let (spans, rests) = compile_pieces(&tracks, forward.clone().chain(reverse.clone()));
        let exits = Exits::new(node_ids.len(), edges);
        let compile = |leg| compile_leg(edges, &tracks, &spans, &exits, leg);
        let (forward, reverse) = (forward.map(compile).collect(), reverse.map(compile).collect());
        let (closed, barred) = (BTreeSet::new(), BTreeSet::new());
        let mut table =
            Self { node_ids, tracks, spans, rests, forward, reverse, exits, closed, barred };
        for edge in edge_indices() {
            let place = table.return_place(edge).and_then(|place| u16::try_from(place).ok());
            table.forward[edge.0 as usize].return_place = place.unwrap_or(NO_RETURN);
        }
        Ok(table)
    }

    /// Returns the id of a node in events.
    pub(super) fn node_id(&self, node: NodeIndex) -> u32 {
        self.node_ids[node.0 as usize]
    }

    /// Returns the pieces of all legs and nodes.
    pub fn tracks(&self) -> &Tracks {
        &self.tracks
    }

    /// Returns all pieces, by row.
    pub fn pieces(&self) -> &[Piece] {
        self.tracks.pieces()
    }

    /// Returns a leg; one that can't be driven has the speed 0.
    pub fn leg(&self, leg: Leg) -> &CompiledLeg {
        let legs = if leg.gear == Gear::Forward { &self.forward } else { &self.reverse };
        &legs[leg.edge.0 as usize]
    }

    /// Returns the index of a piece by its row in [`Tracks`].
    ///
    /// # Panics
    /// If there is no such row.
    pub fn piece(&self, row: u32, gear: Gear) -> PieceIndex {
        assert!((row as usize) < self.pieces().len(), "there is no piece {row}");
        PieceIndex::new(row, gear)
    }

    /// Returns the index of the piece on which robots stand on a node.
    pub fn node_piece(&self, node: NodeIndex) -> PieceIndex {
        self.piece(self.tracks.node_piece(node), Gear::Forward)
    }

    /// Returns the piece that follows another one on the same leg.
    ///
    /// # Panics
    /// If it is the last piece of the table.
    pub(super) fn next_piece(&self, piece: PieceIndex) -> PieceIndex {
        self.piece(piece.row() as u32 + 1, piece.gear())
    }

    pub(super) fn span(&self, piece: PieceIndex) -> PieceSpan {
        self.spans[piece.row()]
    }

    /// Spans of all pieces, by row.
    pub(super) fn spans(&self) -> &[PieceSpan] {
        &self.spans
    }

    /// Metres from the end of a piece to the end of its leg.
    pub(super) fn rest(&self, piece: PieceIndex) -> f32 {
        self.rests[piece.row()]
    }

    /// Metres from where a leg is entered to the end of one of its pieces.
    pub(super) fn driven(&self, leg: Leg, piece: PieceIndex) -> f64 {
        let s_end = f64::from(self.span(piece).s_end);
        match leg.gear {
            Gear::Forward => s_end,
            Gear::Reverse => f64::from(self.leg(leg).length) - s_end,
        }
    }

    /// Whether a robot at a distance `w` from the end of that piece has reached the end of its leg.
    pub fn is_leg_end(&self, piece: PieceIndex, w: i32) -> bool {
        w >= 0 && self.span(piece).is_last()
    }

    /// Returns the node that a robot's leg leads to, or the node that it stands on.
    pub fn node_ahead(&self, leg: Option<Leg>, piece: PieceIndex) -> NodeIndex {
        match leg {
            Some(leg) => self.leg(leg).end,
            None => NodeIndex(piece.row() as u32 - self.tracks.node_piece(NodeIndex(0))),
        }
    }

    /// Closes an edge. Returns whether it was open.
    pub fn close(&mut self, edge: EdgeIndex) -> bool {
        self.closed.insert(edge)
    }

    /// Opens an edge. Returns whether it was closed.
    pub fn open(&mut self, edge: EdgeIndex) -> bool {
        self.closed.remove(&edge)
    }

    /// Whether an edge is closed: no robot may enter it.
    pub fn is_closed(&self, edge: EdgeIndex) -> bool {
        self.closed.contains(&edge)
    }

    /// Bars an edge for now: robots whose routes lead along it wait before it. `false` lets them
    /// pass again.
    pub fn bar(&mut self, edge: EdgeIndex, is_barred: bool) {
        if is_barred {
            self.barred.insert(edge);
        } else {
            self.barred.remove(&edge);
        }
    }

    /// Whether robots wait before an edge for now.
    pub fn is_barred(&self, edge: EdgeIndex) -> bool {
        self.barred.contains(&edge)
    }

    /// The edges that no robot may enter, without those that are barred for now.
    pub fn closed(&self) -> impl Iterator<Item = EdgeIndex> {
        self.closed.iter().copied()
    }

    /// Returns the edge that a random walk takes from a node. It turns straight back only if there
    /// is no other edge.
    pub(super) fn random_exit(
        &self,
        node: NodeIndex,
        leg: Option<Leg>,
        random: u32,
    ) -> Result<EdgeIndex, BaseEnd> {
        let (exits, back) = match leg {
            Some(leg) => self.exits_after(leg),
            None => (self.exits.of(node), None),
        };
        if !self.closed.is_empty() && exits.iter().any(|edge| self.is_closed(*edge)) {
            return self.random_open_exit(exits, back, random);
        }
        let choices = exits.len() as u64 - u64::from(back.is_some());
        let choice = (u64::from(random) * choices) >> 32;
        let choice = choice + u64::from(back.is_some_and(|back| choice >= u64::from(back)));
        exits.get(choice as usize).copied().ok_or(BaseEnd::DeadEnd)
    }

    /// As [`random_exit`](Self::random_exit), for a node that closed edges leave. `back` is the
    /// place of the way back.
    fn random_open_exit(
        &self,
        exits: &[EdgeIndex],
        back: Option<u32>,
        random: u32,
    ) -> Result<EdgeIndex, BaseEnd> {
        let open = (0..).zip(exits.iter().copied()).filter(|(_, edge)| !self.is_closed(*edge));
        let mut ahead = open.clone().filter(|(place, _)| Some(*place) != back);
        let choice = (u64::from(random) * ahead.clone().count() as u64) >> 32;
        let chosen = ahead.nth(choice as usize).or_else(|| open.last());
        chosen.map(|(_, edge)| edge).ok_or(BaseEnd::Unreleased)
    }

    /// Returns the edges that leave the end of a leg, and the place among them of the way back,
    /// which a random walk doesn't take.
    fn exits_after(&self, leg: Leg) -> (&[EdgeIndex], Option<u32>) {
        let compiled = self.leg(leg);
        if compiled.exit_count == MANY_EXITS {
            let place = if leg.gear == Gear::Forward { self.return_place(leg.edge) } else { None };
            return (self.exits.of(compiled.end), place);
        }
        let exits = &self.exits.edges[compiled.first_exit as usize..];
        let back = compiled.return_place;
        let place = (back != NO_RETURN).then_some(u32::from(back));
        (&exits[..usize::from(compiled.exit_count)], place)
    }

    /// Returns the place among the edges that leave the destination of an edge of the first that
    /// leads straight back; `None` if there is none, or no other edge.
    fn return_place(&self, edge: EdgeIndex) -> Option<u32> {
        let [origin, destination] =
            [&self.reverse, &self.forward].map(|legs| legs[edge.0 as usize].end);
        let exits = self.exits.of(destination);
        let mut places = (0..).zip(exits);
        let (place, _) = places.find(|(_, exit)| self.forward[exit.0 as usize].end == origin)?;
        (exits.len() > 1).then_some(place)
    }
}

fn check_pieces(pieces: usize) -> Result<(), TooManyPieces> {
    if pieces > MAX_PIECES { Err(TooManyPieces { pieces, max: MAX_PIECES }) } else { Ok(()) }
}

fn compile_leg(
    edges: &[Edge],
    tracks: &Tracks,
    spans: &[PieceSpan],
    exits: &Exits,
    leg: Leg,
) -> CompiledLeg {
    let edge = &edges[leg.edge.0 as usize];
    let (end, speed) = match leg.gear {
        Gear::Forward => (edge.destination, Some(edge.speed)),
        Gear::Reverse => (edge.origin, edge.reverse_speed),
    };
    let (first_piece, speed, length) = match (tracks.track(leg), speed) {
        (Some(track), Some(speed)) => (track.first_piece, speed as f32, track.length as f32),
        _ => (0, 0.0, 0.0),
    };
    let gear = if speed > 0.0 { leg.gear } else { Gear::Forward };
    let (first_exit, exit_count) = exits.range(end);
    CompiledLeg {
        first_piece: PieceIndex::new(first_piece, gear),
        speed,
        length,
        end,
        first_span: spans[first_piece as usize],
        first_exit,
        exit_count: u16::try_from(exit_count).unwrap_or(MANY_EXITS),
        return_place: NO_RETURN,
    }
}

/// Returns, by piece, its span and the metres from its end to the end of its leg.
fn compile_pieces(tracks: &Tracks, legs: impl Iterator<Item = Leg>) -> (Vec<PieceSpan>, Vec<f32>) {
    let mut spans = Vec::with_capacity(tracks.infos().len());
    for PieceInfo { length, s_end } in tracks.infos() {
        spans.push(PieceSpan { length_and_last: length.0 as u32, s_end: *s_end });
    }
    let mut rests = vec![0.0; spans.len()];
    for track in legs.filter_map(|leg| tracks.track(leg)) {
        spans[track.last_piece() as usize].length_and_last |= PieceSpan::LAST;
        let mut rest = 0.0;
        for row in (track.first_piece..=track.last_piece()).rev() {
            rests[row as usize] = rest as f32;
            rest += tracks.infos()[row as usize].length.to_metres();
        }
    }
    // The pieces of nodes, where robots only stand.
    for node in &mut spans[tracks.node_piece(NodeIndex(0)) as usize..] {
        node.length_and_last = PieceSpan::LAST;
    }
    (spans, rests)
}

/// The edges that start at each node.
#[derive(Debug)]
struct Exits {
    /// By the node that they start at.
    edges: Vec<EdgeIndex>,
    /// By node: where its edges begin; and where the last ones end.
    start: Vec<u32>,
}

impl Exits {
    fn new(nodes: usize, edges: &[Edge]) -> Self {
        let mut by_node: Vec<_> = (0..edges.len() as u32).map(EdgeIndex).collect();
        by_node.sort_by_key(|edge| edges[edge.0 as usize].origin);
        let mut start = vec![0; nodes + 1];
        for edge in edges {
            start[edge.origin.0 as usize + 1] += 1;
        }
        for node in 0..nodes {
            start[node + 1] += start[node];
        }
        Self { edges: by_node, start }
    }

    /// Returns the place of a node's first edge, and the number of its edges.
    fn range(&self, node: NodeIndex) -> (u32, u32) {
        let node = node.0 as usize;
        (self.start[node], self.start[node + 1] - self.start[node])
    }

    fn of(&self, node: NodeIndex) -> &[EdgeIndex] {
        let (first, count) = self.range(node);
        &self.edges[first as usize..][..count as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compiles edges from node 0 to every other node, and as the last one an edge back from the
    /// last node.
    fn star(points: u32) -> LegTable {
        let edge = |origin, destination| Edge {
            origin: NodeIndex(origin),
            destination: NodeIndex(destination),
            speed: 1.0,
            reverse_speed: None,
        };
        let mut edges: Vec<_> = (1..=points).map(|point| edge(0, point)).collect();
        edges.push(edge(points, 0));
        let mut tracks = Tracks::default();
        for _ in &edges {
            tracks.push_edge(
                [(Piece::default(), PieceInfo::default())],
                None::<[(Piece, PieceInfo); 1]>,
            );
        }
        tracks.push_nodes((0..=points).map(|_| Piece::default()));
        LegTable::new((0..=points).collect(), &edges, Arc::new(tracks)).expect("few pieces")
    }

    #[test]
    fn random_walks_never_turn_back_where_they_neednt() {
        for points in [1, 2, 5, 70_000] {
            let table = star(points);
            let back = Leg { edge: EdgeIndex(points), gear: Gear::Forward };
            let choose = |leg, random| table.random_exit(NodeIndex(0), leg, random);
            assert_eq!(choose(Some(back), 0), Ok(EdgeIndex(0)));
            let last = EdgeIndex(points.saturating_sub(2));
            assert_eq!(choose(Some(back), u32::MAX), Ok(last), "{points}");
            assert_eq!(choose(None, u32::MAX), Ok(EdgeIndex(points - 1)), "{points}");
        }
    }

    #[test]
    fn more_pieces_than_an_index_can_tell_apart_are_refused() {
        assert_eq!(check_pieces(MAX_PIECES), Ok(()));
        let pieces = MAX_PIECES + 1;
        assert_eq!(check_pieces(pieces), Err(TooManyPieces { pieces, max: 134_217_728 }));
    }
}
