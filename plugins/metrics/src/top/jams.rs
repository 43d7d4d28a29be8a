//! The edges where robots wait the longest.

use ratatui::Frame;
use ratatui::layout::{Constraint, Flex, Rect};
use ratatui::text::Span;
use ratatui::widgets::{Row, Table};

use super::lists::{draw_hint, left, right};
use super::section::section;
use super::{format, theme};
use crate::snapshot::Jam;

/// Draws the edges where robots waited the longest in the last ten minutes; `None` if nobody
/// publishes them.
pub fn draw(frame: &mut Frame<'_>, area: Rect, jams: Option<&[Jam]>) {
    let area = section(
        frame,
        area,
        "edges with jams",
        Span::styled("of the last ten minutes", theme::quiet()),
    );
    let Some(jams) = jams else {
        return draw_hint(frame, area, "No traffic is published: start `regatta plugin traffic`.");
    };
    if jams.is_empty() {
        return draw_hint(frame, area, "No robot has waited.");
    }
    let header = Row::new([
        left("edge"),
        right("waited"),
        right("robots/h"),
        right("robots"),
        right("speed"),
    ]);
    let widths = [16, 8, 8, 7, 6].map(Constraint::Max);
    let table = Table::new(jams.iter().map(jam), widths)
        .header(header.style(theme::quiet()))
        .flex(Flex::Start);
    frame.render_widget(table, area);
}

fn jam(jam: &Jam) -> Row<'static> {
    let name = match &*jam.name {
        "" => jam.edge.to_string(),
        name => format!("{} {name}", jam.edge),
    };
    Row::new([
        left(name),
        right(format::seconds(jam.figures.waiting_secs.into())),
        right(format::count(jam.figures.entered_per_hour.round() as u64)),
        right(format!("{:.1}", jam.figures.occupancy)),
        right(format!("{:.0} %", 100.0 * jam.figures.relative_speed)),
    ])
}
