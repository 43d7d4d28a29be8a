//! Colours. All have a medium brightness, so that they are legible on black and on white, as the
//! terminal's background is unknown. The background stays as it is. With `NO_COLOR` set, there are
//! no colours.

use ratatui::style::{Color, Modifier, Style};

/// The colour of good values.
pub const GOOD: Color = Color::Indexed(28);
/// The colour of values that deserve attention.
pub const WARNING: Color = Color::Indexed(166);
/// The colour of bad values.
pub const BAD: Color = Color::Indexed(160);
/// The colour of waiting robots.
pub const WAITING: Color = Color::Indexed(33);
/// The colour of values that are neither good nor bad.
pub const NEUTRAL: Color = Color::Indexed(30);
/// The colour of labels.
pub const QUIET: Color = Color::Indexed(243);

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
