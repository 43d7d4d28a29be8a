//! Tables and lines in which no value is cut: what has no room is left out.

use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Flex, Rect};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Cell, Row, Table};

use super::theme;

/// The least width of the first column, which holds names and may be cut.
const LEAST_NAME: u16 = 9;

/// A column of a table.
pub struct Column {
    title: &'static str,
    values: Vec<Span<'static>>,
    side: Alignment,
}

impl Column {
    /// Creates a column of names, on the left.
    pub fn names(title: &'static str, names: impl Iterator<Item = Span<'static>>) -> Self {
        Self { title, values: names.collect(), side: Alignment::Left }
    }

    /// Creates a column of numbers, on the right.
    pub fn numbers(title: &'static str, numbers: impl Iterator<Item = Span<'static>>) -> Self {
        Self { title, values: numbers.collect(), side: Alignment::Right }
    }

    fn width(&self) -> u16 {
        let widest = self.values.iter().map(Span::width).max().unwrap_or_default();
        widest.max(Span::from(self.title).width()) as u16
    }

    fn cell(&self, text: Span<'static>) -> Cell<'static> {
        Cell::from(Text::from(text).alignment(self.side))
    }
}

/// Draws columns, the most important ones first. The last ones are left out if there is no room.
pub fn draw(frame: &mut Frame<'_>, area: Rect, mut columns: Vec<Column>) {
    let first = columns.first().map_or(0, Column::width);
    let others = |columns: &[Column]| -> u16 {
        columns.iter().skip(1).map(|column| column.width() + 1).sum()
    };
    while columns.len() > 1 && first.min(LEAST_NAME) + others(&columns) > area.width {
        columns.pop();
    }
    let mut widths: Vec<u16> = columns.iter().map(Column::width).collect();
    if let Some(first) = widths.first_mut() {
        *first = (*first).min(area.width.saturating_sub(others(&columns)));
    }
    let header = Row::new(columns.iter().map(|column| column.cell(column.title.into())));
    let rows = (0..columns.first().map_or(0, |column| column.values.len())).map(|row| {
        Row::new(columns.iter().map(move |column| column.cell(column.values[row].clone())))
    });
    let table = Table::new(rows, widths.iter().map(|width| Constraint::Length(*width)))
        .header(header.style(theme::quiet()))
        .flex(Flex::Start);
    frame.render_widget(table, area);
}

/// Leaves out the last parts of a line that have no room.
pub fn fitted(mut line: Line<'_>, width: u16) -> Line<'_> {
    let width = usize::from(width);
    if line.width() <= width {
        return line;
    }
    while line.width() + 2 > width && line.spans.pop().is_some() {}
    line.push_span(Span::styled(" …", theme::quiet()));
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_without_room_are_left_out_whole() {
        let line = || Line::from(vec![Span::from("123"), Span::from(" 4567")]);
        assert_eq!(fitted(line(), 8).to_string(), "123 4567");
        assert_eq!(fitted(line(), 7).to_string(), "123 …");
    }
}
