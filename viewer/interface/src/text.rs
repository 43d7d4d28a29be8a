//! Numbers in texts for the user.

pub use regatta_base::thousands;

/// A space at which no line ends. The thin one, U+202F, doesn't keep egui from it.
pub const NO_BREAK_SPACE: char = '\u{a0}';

/// Formats a number of things. The noun takes an s unless there is exactly one.
pub fn with_plural(number: u64, noun: &str) -> String {
    format!("{} {noun}{}", thousands(number), if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_thing_is_in_the_singular() {
        let text = [0, 1, 2, 1000].map(|number| with_plural(number, "mark"));
        assert_eq!(text, ["0 marks", "1 mark", "2 marks", "1,000 marks"]);
    }
}
