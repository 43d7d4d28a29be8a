//! A YAML scalar of any type, with its conversions.

use std::borrow::Cow;

use regatta_base::yaml::Content;

/// A value that a route graph file can use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value<'text> {
    Number(f64),
    Text(Cow<'text, str>),
    /// `null`, `~` or no value at all.
    Null,
    /// A value that no key accepts: its description, with an article.
    Other(&'static str),
}

impl<'text> From<Content<'text>> for Value<'text> {
    fn from(content: Content<'text>) -> Self {
        match content {
            Content::Null => Self::Null,
            Content::Bool(true) => Self::Other("`true`"),
            Content::Bool(false) => Self::Other("`false`"),
            // Integers above 2⁵³ are rounded; they are far outside of every valid range.
            Content::Integer(number) => Self::Number(number as f64),
            Content::Float(number) => Self::Number(number),
            Content::Text(text) => Self::Text(text),
            Content::Tagged => Self::Other("a tagged value"),
            Content::List(_) => Self::Other("a list"),
            Content::Map(_) => Self::Other("a map"),
        }
    }
}

impl Value<'_> {
    /// Returns a description for messages.
    pub fn describe(&self) -> Cow<'static, str> {
        match self {
            Self::Number(number) => format!("{number}").into(),
            Self::Text(text) => format!("`{}`", shorten(text)).into(),
            Self::Null => "empty".into(),
            Self::Other(what) => (*what).into(),
        }
    }

    /// Returns a text trimmed and in lower case; an empty text if the value is something else.
    pub fn lowercase(&self) -> String {
        match self {
            Self::Text(text) => text.trim().to_ascii_lowercase(),
            _ => String::new(),
        }
    }

    /// Returns a text, a number or a truth value as trimmed text.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text.trim().to_owned()),
            Self::Number(number) => Some(number.to_string()),
            Self::Other(word) => {
                word.strip_prefix('`').and_then(|word| word.strip_suffix('`')).map(str::to_owned)
            }
            Self::Null => None,
        }
    }

    /// Returns the number, even if it is written as text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
            _ => None,
        }
    }
}

/// Returns at most 40 characters of a text, with control characters escaped.
pub(crate) fn shorten(text: &str) -> String {
    let mut characters = text.chars();
    let mut start = String::new();
    for letter in characters.by_ref().take(40) {
        match letter {
            '\'' => start.push(letter),
            _ => start.extend(letter.escape_debug()),
        }
    }
    let dots = if characters.next().is_some() { "…" } else { "" };
    format!("{start}{dots}")
}

/// The longest number that is written in full.
const MOST_DIGITS: usize = 24;

/// Writes the numbers of a message with exponents if they are too long to read: `1e300`.
pub(crate) fn with_short_numbers(message: String) -> String {
    if !digits_and_others(&message).any(|(number, _)| number.len() > MOST_DIGITS) {
        return message;
    }
    let mut short = String::new();
    for (number, others) in digits_and_others(&message) {
        match number.parse::<f64>() {
            Ok(value) if number.len() > MOST_DIGITS => short.push_str(&format!("{value:e}")),
            _ => short.push_str(number),
        }
        short.push_str(others);
    }
    short
}

/// Splits a text into its runs of digits and points, each with the text behind it.
fn digits_and_others(mut text: &str) -> impl Iterator<Item = (&str, &str)> {
    std::iter::from_fn(move || {
        if text.is_empty() {
            return None;
        }
        let (number, rest) =
            text.split_at(text.find(|letter| !is_digit(letter)).unwrap_or(text.len()));
        let (others, rest) = rest.split_at(rest.find(is_digit).unwrap_or(rest.len()));
        text = rest;
        Some((number, others))
    })
}

/// Whether a letter is a part of a number without a sign.
fn is_digit(letter: char) -> bool {
    letter.is_ascii_digit() || letter == '.'
}

/// Returns a number of things in words.
pub(crate) fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Returns a time of so many seconds in words, rounded to two units: `1 h 7 min`.
pub(crate) fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60) {
        (0, 0) => format!("{seconds:.0} s"),
        (0, minutes) => format!("{minutes} min {} s", whole % 60),
        (hours, minutes) if hours < 48 => format!("{hours} h {} min", minutes % 60),
        (hours, _) => format!("{} days {} h", hours / 24, hours % 24),
    }
}

#[cfg(test)]
mod tests {
    use super::with_short_numbers;

    #[test]
    fn long_numbers_have_an_exponent() {
        let long = format!("X is -{} m, over 8000.5 m: {}", 1e300, 1e-300);
        assert_eq!(with_short_numbers(long), "X is -1e300 m, over 8000.5 m: 1e-300");
        let short = "X is 4294967295 and 1.2.3…, or 0.30000000000000004";
        assert_eq!(with_short_numbers(short.to_owned()), short);
    }
}
