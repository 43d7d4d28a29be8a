//! Numbers in texts for the user.

/// Formats a number with a thin space between groups of three digits.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

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
        assert_eq!(text, ["0 marks", "1 mark", "2 marks", "1\u{2009}000 marks"]);
    }
}
