//! Colours. All lie in the middle between black and white, so that each can be told from either: nobody knows what
//! colour a terminal has. The background stays as it is. With `NO_COLOR` set there are none.

use ratatui::style::{Color, Modifier, Style};

/// What is as it should be.
pub const GOOD: Color = Color::Indexed(28);
/// What deserves a look.
pub const WARNING: Color = Color::Indexed(166);
/// What is wrong.
pub const BAD: Color = Color::Indexed(160);
/// What waits.
pub const WAITING: Color = Color::Indexed(33);
/// What is neither good nor bad.
pub const NEUTRAL: Color = Color::Indexed(30);
/// What explains the rest.
pub const QUIET: Color = Color::Indexed(243);

/// Text of a colour.
pub fn text(colour: Color) -> Style {
    Style::new().fg(colour)
}

/// Figures and titles.
pub fn strong() -> Style {
    text(Color::Reset).add_modifier(Modifier::BOLD)
}

/// Names of figures.
pub fn quiet() -> Style {
    text(QUIET)
}
