//! The names of orders.

use serde::Serialize;

/// The unique name of an order: 1 to [`MAX_CHARS`](Self::MAX_CHARS) characters without `/` and control
/// characters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct OrderName(String);

/// The error of parsing an [`OrderName`].
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Empty or too long.
    #[error(
        "the name of an order has 1 to {max} characters, and this one has {0}",
        max = OrderName::MAX_CHARS
    )]
    Length(usize),
    /// It has an invalid character.
    #[error("the name `{}` has a `/` or a character that can't be seen", .0.escape_default())]
    Character(String),
    /// It would be another path in an address.
    #[error("the name `{}` has `..`, or is `.`", .0.escape_default())]
    Path(String),
    /// It begins with the prefix of generated orders.
    #[error(
        "invalid name `{0}`: names that begin with `{load}` or `{sent}` are reserved for generated \
         orders",
        load = OrderName::GENERATED,
        sent = OrderName::REQUESTED
    )]
    Reserved(String),
}

/// Characters that have no width, or turn the direction of others: with them, a name looks like
/// another one, or like other text.
pub(crate) const UNSEEN: [(char, char); 16] = [
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{2028}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

fn is_unseen(c: char) -> bool {
    UNSEEN.iter().any(|(first, last)| (*first..=*last).contains(&c))
}

impl OrderName {
    /// The largest number of characters of a name.
    pub const MAX_CHARS: usize = 128;
    /// The prefix of names that generators give.
    pub const GENERATED: &str = "load:";
    /// The prefix of the names of orders by which robots are sent somewhere on request.
    pub const REQUESTED: &str = "sent:";

    /// Parses a name that a user gives.
    ///
    /// # Errors
    /// [`NameError`] if it is empty, too long, has characters that names don't have, or belongs to
    /// generated orders.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        if [Self::GENERATED, Self::REQUESTED].into_iter().any(|prefix| text.starts_with(prefix)) {
            return Err(NameError::Reserved(text.to_owned()));
        }
        if text == "." || text.contains("..") {
            return Err(NameError::Path(text.to_owned()));
        }
        if text.contains(is_unseen) {
            return Err(NameError::Character(text.to_owned()));
        }
        Self::stored(text)
    }

    /// Parses the name of an order that exists.
    ///
    /// # Errors
    /// [`NameError`] as [`parse`](Self::parse), but names of generated orders are valid, and those
    /// that earlier versions kept: with `..`, or characters that can't be seen.
    pub fn stored(text: &str) -> Result<Self, NameError> {
        let length = text.chars().count();
        if length == 0 || length > Self::MAX_CHARS {
            return Err(NameError::Length(length));
        }
        if text.contains(|c: char| c.is_control() || c == '/') {
            return Err(NameError::Character(text.to_owned()));
        }
        Ok(Self(text.to_owned()))
    }

    /// Returns the name of the order with this number of a generator. From the second run of a
    /// store on it has the run's number, so that it is new.
    pub(crate) fn generated(generator: &str, number: u64, run: u64) -> Self {
        match run {
            0 | 1 => Self(format!("{}{generator}-{number}", Self::GENERATED)),
            run => Self(format!("{}{run}:{generator}-{number}", Self::GENERATED)),
        }
    }

    /// The name of the order by which a robot is sent somewhere on request: unique in its run and
    /// among runs.
    pub(crate) fn of_request(robot: u32, number: u64, run_id: u64) -> Self {
        Self(format!("{}{robot}-{number}-{run_id:08x}", Self::REQUESTED))
    }

    /// Whether it is the name of an order by which a robot is sent somewhere on request.
    pub(crate) fn is_of_request(&self) -> bool {
        self.0.starts_with(Self::REQUESTED)
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl std::fmt::Display for OrderName {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
}
