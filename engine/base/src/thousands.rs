//! Numbers for people to read.

/// The number of digits of a group.
const GROUP: usize = 3;

/// Formats a number with a comma between groups of three digits: `12,345`.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / GROUP);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(GROUP) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Formats a number with decimals, and with a comma between groups of three digits before them:
/// `-12,345.6`.
pub fn grouped(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    let digits = text.trim_start_matches('-');
    let (whole, rest) = digits.split_at(digits.find('.').unwrap_or(digits.len()));
    match whole.parse() {
        Ok(whole) => format!("{}{}{rest}", &text[..text.len() - digits.len()], thousands(whole)),
        // Infinite, or more than a million million million.
        Err(_) => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_separate_groups_of_three_digits() {
        let numbers = [0, 7, 999, 1_000, 12_345, 1_234_567, u64::MAX];
        let texts = ["0", "7", "999", "1,000", "12,345", "1,234,567", "18,446,744,073,709,551,615"];
        assert_eq!(numbers.map(thousands), texts);
    }

    #[test]
    fn decimals_and_signs_stay_as_they_are() {
        for (number, decimals, text) in [
            (0.0, 1, "0.0"),
            (999.96, 1, "1,000.0"),
            (-123_456.0, 0, "-123,456"),
            (1_234_567.891, 2, "1,234,567.89"),
            (f64::INFINITY, 1, "inf"),
            (f64::NAN, 0, "NaN"),
        ] {
            assert_eq!(grouped(number, decimals), text);
        }
    }
}
