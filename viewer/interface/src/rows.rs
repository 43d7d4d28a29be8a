//! The rows of the fleet list: filtered and sorted robots. They are computed on a thread other than
//! the drawing one.

use regatta_plugin::activity::Activity;
use regatta_plugin::frame::{Columns, RobotState};

use crate::robot_filter::activity_of;

/// The sort key of the fleet list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SortBy {
    /// The id.
    #[default]
    Id,
    /// Metres east.
    X,
    /// Metres north.
    Y,
    /// The heading.
    Theta,
    /// Metres per second.
    Speed,
    /// The activity, by its word.
    Activity,
    /// The edge, by its index in the world.
    Edge,
}

/// A query for rows: filter and order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RowQuery {
    /// The sort key.
    pub sort: SortBy,
    /// Whether the largest value comes first.
    pub descending: bool,
    /// The first digits of an id or the first letters of an activity; empty for all robots.
    pub filter: String,
}

/// The answer to a [`RowQuery`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rows {
    /// The query.
    pub query: RowQuery,
    /// The ids of the robots, in the requested order.
    pub ids: Vec<u32>,
}

impl RowQuery {
    /// Whether the rows are all ids in order, so that they need not be computed.
    pub fn is_plain(&self) -> bool {
        self.sort == SortBy::Id && self.filter.trim().is_empty()
    }

    /// Computes the rows for the columns of a frame, and for the values of the column `activity`,
    /// which may be none.
    pub fn rows(&self, columns: Columns<'_>, activities: &[f32]) -> Rows {
        let filter = self.filter.trim().to_lowercase();
        let mut ids: Vec<u32> = (0..columns.x.len() as u32)
            .filter(|id| passes(&filter, *id, word(columns, activities, *id)))
            .collect();
        match self.sort {
            SortBy::Id => {}
            SortBy::X => sort_by_values(&mut ids, columns.x),
            SortBy::Y => sort_by_values(&mut ids, columns.y),
            SortBy::Theta => sort_by_values(&mut ids, columns.theta),
            SortBy::Speed => sort_by_values(&mut ids, columns.speed),
            SortBy::Activity => ids.sort_by_key(|id| word(columns, activities, *id)),
            SortBy::Edge => ids.sort_by_key(|id| columns.edge[*id as usize]),
        }
        if self.descending {
            ids.reverse();
        }
        Rows { query: self.clone(), ids }
    }
}

fn sort_by_values(ids: &mut [u32], values: &[f32]) {
    ids.sort_by(|a, b| values[*a as usize].total_cmp(&values[*b as usize]));
}

/// The word of a robot's activity; `None` if it is absent.
fn word(columns: Columns<'_>, activities: &[f32], id: u32) -> Option<&'static str> {
    let state = RobotState::from_number(columns.state[id as usize]);
    activity_of(state, activities, id).map(Activity::name)
}

fn passes(filter: &str, id: u32, word: Option<&str>) -> bool {
    let Some(word) = word else { return false };
    match filter.parse::<u32>() {
        Ok(wanted) => begins_with(id, wanted),
        Err(_) => word.starts_with(filter),
    }
}

/// Whether the decimal digits of a number begin with those of another.
fn begins_with(mut number: u32, start: u32) -> bool {
    while number > start && number >= 10 {
        number /= 10;
    }
    number == start
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_filtered_and_sorted() {
        let (x, y, theta) = ([3.0, 1.0, 2.0, 0.5], [0.0; 4], [0.0, -1.0, 1.0, 0.5]);
        let state = [0, 1, 3, 255];
        let (speed, edge) = ([1.0, 0.0, 0.5, 0.0], [7, 3, u32::MAX, 1]);
        let columns = Columns {
            x: &x,
            y: &y,
            theta: &theta,
            speed: &speed,
            s: &y,
            edge: &edge,
            state: &state,
        };
        let rows = |sort, descending, filter: &str| {
            RowQuery { sort, descending, filter: filter.into() }.rows(columns, &[]).ids
        };
        assert_eq!(rows(SortBy::X, false, ""), [1, 2, 0]);
        assert_eq!(rows(SortBy::Theta, true, ""), [2, 0, 1]);
        assert_eq!(rows(SortBy::Speed, true, ""), [0, 2, 1]);
        assert_eq!(rows(SortBy::Activity, false, ""), [2, 0, 1], "held, idle, moving");
        assert_eq!(rows(SortBy::Edge, false, ""), [1, 0, 2]);
        assert_eq!(rows(SortBy::Id, false, "hel"), [2]);
        assert_eq!(rows(SortBy::Id, false, "1"), [1]);
        assert_eq!(rows(SortBy::Id, true, " "), [2, 1, 0]);
        assert!(rows(SortBy::Id, false, "nothing").is_empty());
    }

    #[test]
    fn digits_begin_as_their_text_does() {
        for number in [0_u32, 1, 9, 10, 12, 99, 100, 123, 4711, 47_110, u32::MAX] {
            for start in [0_u32, 1, 4, 10, 12, 47, 471, 100, 4_294_967_295] {
                let text = number.to_string().starts_with(&start.to_string());
                assert_eq!(begins_with(number, start), text, "{number} {start}");
            }
        }
    }
}
