//! Numbers of tables that are written with a decimal comma (`3,5`), and with points between groups
//! of three digits (`1.000,5`).

/// A number of a table in which other numbers have decimal commas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decimal {
    /// A number that can be read in one way only.
    Plain(f64),
    /// One point before the last three digits, as in `3.000`: it separates thousands, unless other
    /// numbers of the table have decimal points.
    Grouped(f64),
    /// A decimal point.
    Point(f64),
}

impl Decimal {
    /// Reads a number; `None` for other texts.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        if let Some((whole, fraction)) = text.split_once(',') {
            let is_grouped = !whole.contains('.') || groups(whole).is_some();
            let whole = whole.replace('.', "");
            return is_grouped.then(|| finite(&format!("{whole}.{fraction}")))?.map(Self::Plain);
        }
        match groups(text) {
            Some(1) => finite(&text.replace('.', "")).map(Self::Grouped),
            Some(_) => finite(&text.replace('.', "")).map(Self::Plain),
            None if text.contains('.') => finite(text).map(Self::Point),
            None => finite(text).map(Self::Plain),
        }
    }

    /// Whether a text is a number with a decimal comma.
    pub fn has_comma(text: &str) -> bool {
        text.contains(',') && Self::parse(text).is_some()
    }

    /// The number.
    pub fn number(self) -> f64 {
        match self {
            Self::Plain(number) | Self::Grouped(number) | Self::Point(number) => number,
        }
    }
}

/// The number of points of a text that are all followed by three digits, and are behind one to
/// three digits of which the first isn't 0.
fn groups(text: &str) -> Option<usize> {
    let mut groups = text.trim_start_matches(['-', '+']).split('.');
    let first = groups.next().filter(|first| is_digits(first) && !first.starts_with('0'))?;
    let mut count = 0;
    for group in groups {
        if group.len() != 3 || !is_digits(group) {
            return None;
        }
        count += 1;
    }
    (count > 0 && first.len() <= 3).then_some(count)
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|letter| letter.is_ascii_digit())
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_separate_groups_of_exactly_three_digits() {
        for (text, number) in [
            ("3,5", Decimal::Plain(3.5)),
            ("-1.000,5", Decimal::Plain(-1000.5)),
            ("1.234.567", Decimal::Plain(1_234_567.0)),
            ("0,5", Decimal::Plain(0.5)),
            (" 12 ", Decimal::Plain(12.0)),
            ("1e3", Decimal::Plain(1000.0)),
            ("3.000", Decimal::Grouped(3000.0)),
            ("-3.000", Decimal::Grouped(-3000.0)),
            ("0.500", Decimal::Point(0.5)),
            ("1234.567", Decimal::Point(1234.567)),
            ("3.5", Decimal::Point(3.5)),
            ("3.0000", Decimal::Point(3.0)),
        ] {
            assert_eq!(Decimal::parse(text), Some(number), "{text}");
        }
        for text in ["", ",", "1,2,3", "1.2,5", "1.2345,6", "26.11.2026", "1,234.5", "nan", "x"] {
            assert_eq!(Decimal::parse(text), None, "{text}");
        }
        assert!(Decimal::has_comma("1.000,5") && !Decimal::has_comma("A,B"));
        assert!(!Decimal::has_comma("3.000"));
    }
}
