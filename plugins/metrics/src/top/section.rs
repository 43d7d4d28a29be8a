//! Sections of the screen: a rule with a title above an area.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders};

use super::theme;

/// Draws a rule with a title on the left and a note on the right. Returns the area below it.
pub fn section<'a>(
    frame: &mut Frame<'_>,
    area: Rect,
    title: impl Into<Span<'a>>,
    note: impl Into<Line<'a>>,
) -> Rect {
    let title = Line::from(vec![title.into().style(theme::strong()), " ".into()]);
    let mut note: Line<'_> = note.into();
    if note.width() > 0 {
        note.spans.insert(0, " ".into());
    }
    let block = Block::new().borders(Borders::TOP).border_style(theme::quiet());
    let block = block.title_top(title).title_top(note.right_aligned());
    let inside = block.inner(area);
    frame.render_widget(block, area);
    inside
}
