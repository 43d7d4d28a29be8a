//! The fleet list as a table for the clipboard.

use std::fmt::Write;

use regatta_plugin::Frame;
use regatta_plugin::contact::ContactLevel;

use super::{Row, contact_levels};
use crate::context::PanelContext;

/// The largest number of rows that are copied.
pub(super) const MAX_ROWS: usize = 100_000;

/// Returns robots as CSV, with units in the names of the columns.
pub(super) fn csv(
    context: &PanelContext<'_>,
    frame: &Frame<'_>,
    ids: impl Iterator<Item = u32>,
) -> String {
    let levels = contact_levels(context.model);
    let mut text = String::from("robot,activity,speed_m_s,edge,x_m,y_m,heading_deg,contact\n");
    for id in ids.take(MAX_ROWS) {
        let row = Row::new(context, frame, id, &levels);
        let index = id as usize;
        let activity = row.activity.map_or("absent", |activity| activity.name());
        let edge = row.edge.map(|(_, id)| id.to_string()).unwrap_or_default();
        let contact = match row.level {
            Some(ContactLevel::Touching) => "touching",
            Some(ContactLevel::Possible) => "possible",
            _ => "",
        };
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{id},{activity},{:.3},{edge},{:.3},{:.3},{:.1},{contact}",
            frame.speed()[index],
            frame.x()[index] + row.offset.x,
            frame.y()[index] + row.offset.y,
            frame.theta()[index].to_degrees(),
        );
    }
    text
}
