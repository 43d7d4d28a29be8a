//! The state of the fleet: one column per value, one row per robot.

use regatta_motion::{
    AlignedVec, HeadingRows, HeadingRule, LimitRows, PieceColumn, ROW_GROUP, Rows, UNLIMITED,
};
use regatta_plugin::frame::{NO_EDGE, RobotState};

use super::Route;

/// All columns. Rows that hold no robot are inert: they are on the first piece and
/// [`RobotState::Absent`].
#[derive(Debug)]
pub(super) struct FleetColumns {
    pub piece: PieceColumn,
    pub w: AlignedVec<i32>,
    pub speed: AlignedVec<f32>,
    pub s_end: AlignedVec<f32>,
    pub edge: AlignedVec<u32>,
    pub state: AlignedVec<u8>,
    pub route: AlignedVec<Route>,
    pub robot_type: AlignedVec<u16>,
    limits: Option<Limits>,
    headings: Option<Headings>,
}

#[derive(Debug, Default)]
struct Limits {
    acceleration: AlignedVec<f32>,
    cruise: AlignedVec<f32>,
    brake: AlignedVec<f32>,
    rest: AlignedVec<f32>,
    stop: AlignedVec<f32>,
}

#[derive(Debug, Default)]
struct Headings {
    gain: AlignedVec<f32>,
    offset: AlignedVec<f32>,
    rate: AlignedVec<f32>,
}

impl Limits {
    fn resize(&mut self, groups: usize) {
        self.acceleration.resize(groups, UNLIMITED);
        self.cruise.resize(groups, 0.0);
        self.brake.resize(groups, f32::INFINITY);
        self.rest.resize(groups, 0.0);
        self.stop.resize(groups, 0.0);
    }
}

impl FleetColumns {
    /// Makes columns without rows. `pieces` is the length of the table of pieces; `limited` if a
    /// robot type limits its acceleration, `oriented` if headings aren't simply those of the edges.
    pub fn new(pieces: usize, limited: bool, oriented: bool) -> Self {
        Self {
            piece: PieceColumn::new(pieces),
            w: AlignedVec::new(),
            speed: AlignedVec::new(),
            s_end: AlignedVec::new(),
            edge: AlignedVec::new(),
            state: AlignedVec::new(),
            route: AlignedVec::new(),
            robot_type: AlignedVec::new(),
            limits: limited.then(Limits::default),
            headings: oriented.then(Headings::default),
        }
    }

    /// Resizes to that many rows, in whole groups. Existing rows stay as they are; new ones are
    /// inert.
    pub fn resize(&mut self, rows: usize) {
        let groups = rows.div_ceil(ROW_GROUP);
        self.piece.resize(groups);
        self.w.resize(groups, 0);
        self.speed.resize(groups, 0.0);
        self.s_end.resize(groups, 0.0);
        self.edge.resize(groups, NO_EDGE);
        self.state.resize(groups, RobotState::Absent as u8);
        self.route.resize(groups, Route::PARKED);
        self.robot_type.resize(groups, 0);
        if let Some(limits) = &mut self.limits {
            limits.resize(groups);
        }
        if let Some(headings) = &mut self.headings {
            headings.gain.resize(groups, 1.0);
            headings.offset.resize(groups, 0.0);
            headings.rate.resize(groups, 0.0);
        }
    }

    /// Adds the columns of limits, which bases need that end within a leg. Returns whether they
    /// weren't there.
    pub fn add_limits(&mut self) -> bool {
        let is_new = self.limits.is_none();
        let groups = self.capacity() / ROW_GROUP;
        self.limits.get_or_insert_with(Limits::default).resize(groups);
        is_new
    }

    /// Reserves memory for that many rows, and no more than they need.
    pub fn reserve(&mut self, rows: usize) {
        let groups = rows.div_ceil(ROW_GROUP);
        self.piece.reserve(groups);
        self.w.reserve(groups);
        self.speed.reserve(groups);
        self.s_end.reserve(groups);
        self.edge.reserve(groups);
        self.state.reserve(groups);
        self.route.reserve(groups);
        self.robot_type.reserve(groups);
        if let Some(limits) = &mut self.limits {
            limits.acceleration.reserve(groups);
            limits.cruise.reserve(groups);
            limits.brake.reserve(groups);
            limits.rest.reserve(groups);
            limits.stop.reserve(groups);
        }
        if let Some(headings) = &mut self.headings {
            headings.gain.reserve(groups);
            headings.offset.reserve(groups);
            headings.rate.reserve(groups);
        }
    }

    /// Number of rows, including those that hold no robot.
    pub fn capacity(&self) -> usize {
        self.piece.len()
    }

    /// Makes a row inert.
    pub fn clear(&mut self, row: usize) {
        self.piece.reset(row);
        self.w[row] = 0;
        self.speed[row] = 0.0;
        self.s_end[row] = 0.0;
        self.edge[row] = NO_EDGE;
        self.state[row] = RobotState::Absent as u8;
        self.route[row] = Route::PARKED;
        self.set_robot_type(row, 0, f32::INFINITY);
        if let Some(limits) = &mut self.limits {
            limits.cruise[row] = 0.0;
            limits.rest[row] = 0.0;
            limits.stop[row] = 0.0;
        }
        if let Some(headings) = &mut self.headings {
            headings.gain[row] = 1.0;
            headings.offset[row] = 0.0;
            headings.rate[row] = 0.0;
        }
    }

    /// Sets the robot type of a row and the type's acceleration limit; infinity for none.
    pub fn set_robot_type(&mut self, row: usize, robot_type: u16, acceleration: f32) {
        self.robot_type[row] = robot_type;
        if let Some(limits) = &mut self.limits {
            limits.acceleration[row] = acceleration.min(UNLIMITED);
            limits.brake[row] = f32::INFINITY;
        }
    }

    /// Returns the groups that hold the first `count` rows.
    pub fn rows(&mut self, count: usize) -> Rows<'_> {
        self.all_rows().split_at(count.next_multiple_of(ROW_GROUP)).0
    }

    /// Returns all rows, including those that hold no robot.
    pub fn all_rows(&mut self) -> Rows<'_> {
        Rows {
            first: 0,
            piece: self.piece.rows(),
            w: &mut self.w,
            speed: &mut self.speed,
            s_end: &mut self.s_end,
            edge: &mut self.edge,
            state: &mut self.state,
            route: &mut self.route,
            robot_type: &mut self.robot_type,
            limits: self.limits.as_mut().map(|limits| LimitRows {
                acceleration: &mut limits.acceleration,
                cruise: &mut limits.cruise,
                brake: &mut limits.brake,
                rest: &mut limits.rest,
                stop: &mut limits.stop,
            }),
            headings: self.headings.as_mut().map(|headings| HeadingRows {
                gain: &mut headings.gain,
                offset: &mut headings.offset,
                rate: &mut headings.rate,
            }),
        }
    }

    /// Returns the rule of the heading of a row.
    pub fn heading_rule(&self, row: usize) -> HeadingRule {
        match &self.headings {
            Some(headings) => {
                HeadingRule { gain: headings.gain[row], offset: headings.offset[row] }
            }
            None => HeadingRule::TANGENT,
        }
    }

    /// Bytes of memory per row.
    pub fn bytes_per_row(&self) -> usize {
        let hot = 5 * size_of::<u32>() + size_of::<u8>();
        let cold = size_of::<Route>() + size_of::<u16>();
        let limits = if self.limits.is_some() { 5 * size_of::<f32>() } else { 0 };
        let headings = if self.headings.is_some() { 3 * size_of::<f32>() } else { 0 };
        hot + cold + limits + headings
    }
}
