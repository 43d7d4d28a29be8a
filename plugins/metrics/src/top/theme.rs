//! Colours, and the sections of the screen. All colours have a medium brightness, so that they are
//! legible on black and on white, as the terminal's background is unknown. The background stays as
//! it is. With `NO_COLOR` set, there are no colours.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Borders};
use regatta_plugin::activity::{Activity, Ground};

use super::table::fitted;

/// The colour of good values.
pub const GOOD: Color = Color::Indexed(28);
/// The colour of values that deserve attention.
pub const WARNING: Color = Color::Indexed(166);
/// The colour of bad values.
pub const BAD: Color = Color::Indexed(160);
/// The colour of values that are neither good nor bad.
pub const NEUTRAL: Color = Color::Indexed(30);
/// The colour of labels.
pub const QUIET: Color = Color::Indexed(243);

/// Returns the colour of an activity, the nearest one that terminals with 256 colours have.
pub const fn of_activity(activity: Activity) -> Color {
    let [red, green, blue] = activity.rgb(Ground::Dark);
    Color::Indexed(16 + 36 * cube(red) + 6 * cube(green) + cube(blue))
}

/// Returns the step of the colour cube that is nearest to a value: its steps are 0, 95, 135, 175,
/// 215 and 255.
const fn cube(value: u8) -> u8 {
    match value {
        0..48 => 0,
        48..115 => 1,
        _ => (value - 35) / 40,
    }
}

/// Returns the style of text of a colour.
pub fn text(colour: Color) -> Style {
    Style::new().fg(colour)
}

/// Returns the style of figures and titles.
pub fn strong() -> Style {
    text(Color::Reset).add_modifier(Modifier::BOLD)
}

/// Returns the style of labels.
pub fn quiet() -> Style {
    text(QUIET)
}

/// Draws a rule with a title on the left and a note on the right. Returns the area below it.
pub fn section<'a>(
    frame: &mut Frame<'_>,
    area: Rect,
    title: impl Into<Span<'a>>,
    note: impl Into<Line<'a>>,
) -> Rect {
    let title = Line::from(vec![title.into().style(strong()), " ".into()]);
    let room = usize::from(area.width).saturating_sub(title.width() + 2);
    let mut note: Line<'_> = fitted(note.into(), room as u16);
    if note.width() > 0 {
        note.spans.insert(0, " ".into());
    }
    let block = Block::new().borders(Borders::TOP).border_style(quiet());
    let block = block.title_top(title).title_top(note.right_aligned());
    let inside = block.inner(area);
    frame.render_widget(block, area);
    inside
}
