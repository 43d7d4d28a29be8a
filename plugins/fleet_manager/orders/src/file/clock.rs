//! Times in files: seconds, clock times and dates, as warehouses write them.

use std::fmt;

/// A time of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileTime {
    /// Seconds of simulated time.
    Secs(f64),
    /// A time of day, in seconds after the midnight before the first time of the file.
    Clock(f64),
    /// A date with a time of day where it was written, in seconds since 1970.
    Local(f64),
    /// A date with a time of day and a zone, in seconds since 1970 in UTC.
    Instant(f64),
}

impl FileTime {
    /// The number of seconds.
    pub fn secs(self) -> f64 {
        match self {
            Self::Secs(secs) | Self::Clock(secs) | Self::Local(secs) | Self::Instant(secs) => secs,
        }
    }

    /// The kind, in words.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Secs(_) => "seconds",
            Self::Clock(_) => "a time of day",
            Self::Local(_) => "a date without a zone",
            Self::Instant(_) => "a date with a zone",
        }
    }

    /// The date of a number of days that a workbook has, if this is a number.
    pub fn from_serial(self) -> Self {
        match self {
            Self::Secs(days) => {
                let millis = (days - SERIAL_OF_1970) * DAY_SECS * 1000.0;
                Self::Local(millis.round() / 1000.0)
            }
            other => other,
        }
    }

    /// The time of the next day, if this is a time of day.
    pub fn next_day(self) -> Self {
        match self {
            Self::Clock(secs) => Self::Clock(secs + DAY_SECS),
            other => other,
        }
    }
}

/// Returns the line with the first time after midnight of a file without dates, such as that of a
/// night shift: there alone a time is before that of the row above, by more than half a day, and
/// all later ones are before the first time of the file.
pub fn midnight(times: impl Iterator<Item = (usize, FileTime)>) -> Option<usize> {
    let (mut first, mut last, mut found) = (None, None, None);
    for (line, time) in times {
        let FileTime::Clock(secs) = time else { return None };
        if let Some(last) = last.filter(|last| secs < *last) {
            if found.is_some() || last - secs < HALF_DAY_SECS {
                return None;
            }
            found = Some(line);
        }
        if found.is_some() && secs >= *first.get_or_insert(secs) {
            return None;
        }
        first.get_or_insert(secs);
        last = Some(secs);
    }
    found
}

/// Returns a time of day as one of the next day if it is more than half a day before another one.
pub fn after(time: FileTime, other: FileTime) -> FileTime {
    match time {
        FileTime::Clock(secs) if other.secs() - secs > HALF_DAY_SECS => time.next_day(),
        _ => time,
    }
}

/// Returns the deadline of an order as a time after it: a time of day beside a date is of that day,
/// or of the next one as [`on_day_of`] says; see also [`after`].
pub fn due_after(deadline: FileTime, order: FileTime) -> FileTime {
    match on_same_day(deadline, order) {
        Some(_) => on_day_of(deadline, order),
        None => after(deadline, order),
    }
}

/// Returns a time of day beside a date as one of that day, or of the next one if it is more than
/// half a day before the order.
pub fn on_day_of(time: FileTime, order: FileTime) -> FileTime {
    match on_same_day(time, order) {
        Some(secs) if order.secs() - secs > HALF_DAY_SECS => FileTime::Local(secs + DAY_SECS),
        Some(secs) => FileTime::Local(secs),
        None => time,
    }
}

/// Returns the seconds since 1970 of a time of day on the day of an order with a date. If that has
/// a zone, nothing tells whether the time of day has the same.
fn on_same_day(time: FileTime, order: FileTime) -> Option<f64> {
    let (FileTime::Clock(secs), FileTime::Local(date)) = (time, order) else { return None };
    Some((date / DAY_SECS).floor() * DAY_SECS + secs)
}

impl fmt::Display for FileTime {
    /// Writes the date and the minute.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let secs = self.secs();
        let minutes = (secs.rem_euclid(DAY_SECS) / 60.0) as u32;
        let clock = format!("{:02}:{:02}", minutes / 60, minutes % 60);
        let date = date_text((secs / DAY_SECS).floor() as i64);
        match self {
            Self::Secs(secs) => write!(f, "{secs} s"),
            Self::Clock(_) => f.write_str(&clock),
            Self::Local(_) => write!(f, "{date} {clock}"),
            Self::Instant(_) => write!(f, "{date} {clock} UTC"),
        }
    }
}

/// The reason why a text is no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TimeError {
    /// It has another form.
    #[error("isn't a time: write seconds, 08:30, 2026-11-26 08:30 or 26.11.2026 08:30")]
    Form,
    /// A part is out of range.
    #[error("has an hour, a minute, a day or a month that doesn't exist")]
    Range,
    /// Day and month can't be told apart.
    #[error("may be two dates: write the year first, as in 2026-11-26")]
    Ambiguous,
}

const DAY_SECS: f64 = 86_400.0;
/// The number of 1970-01-01 in workbooks, which count days (ECMA-376, part 1, 18.17.4.1).
const SERIAL_OF_1970: f64 = 25_569.0;
/// The numbers of the days from 2000 to 2099.
pub const SERIALS: std::ops::Range<f64> = 36_526.0..73_051.0;
const HALF_DAY_SECS: f64 = DAY_SECS / 2.0;
/// Two-digit years are those from 2000 on.
const CENTURY: i64 = 2000;

/// Parses a time.
pub fn parse(text: &str) -> Result<FileTime, TimeError> {
    let text = text.trim();
    if let Some(secs) = decimal(text) {
        return if secs >= 0.0 { Ok(FileTime::Secs(secs)) } else { Err(TimeError::Form) };
    }
    let split = text.find(['T', 't', ' ']).filter(|at| text.is_char_boundary(*at));
    let Some(at) = split.filter(|at| text[..*at].contains(['-', '.', '/'])) else {
        return match text.contains(':') {
            true => clock(text).map(FileTime::Clock),
            false => Ok(FileTime::Local(date(text)? as f64 * DAY_SECS)),
        };
    };
    let days = date(&text[..at])?;
    let (time, zone_secs) = zone(text[at + 1..].trim())?;
    let secs = days as f64 * DAY_SECS + clock(time)?;
    Ok(match zone_secs {
        Some(zone_secs) => FileTime::Instant(secs - zone_secs),
        None => FileTime::Local(secs),
    })
}

/// Parses a number with a decimal point or a decimal comma; `None` for other texts.
pub fn decimal(text: &str) -> Option<f64> {
    let text = text.trim();
    let number = match text.parse() {
        Ok(number) => number,
        // A comma before three digits may separate thousands.
        Err(_) if text.matches(',').count() == 1 && !text.contains('.') => {
            text.replace(',', ".").parse().ok()?
        }
        Err(_) => return None,
    };
    Some(number).filter(|number: &f64| number.is_finite())
}

/// Returns the seconds after midnight of a text such as `8:30`, `08:30:15.5` or `8:30 PM`.
fn clock(text: &str) -> Result<f64, TimeError> {
    let upper = text.trim().to_ascii_uppercase();
    let (text, noon) = match (upper.strip_suffix("AM"), upper.strip_suffix("PM")) {
        (Some(text), _) => (text, Some(0)),
        (_, Some(text)) => (text, Some(12)),
        _ => (upper.as_str(), None),
    };
    let mut parts = text.trim().split(':');
    let hour: u32 = number(parts.next())?;
    let minute: u32 = number(parts.next())?;
    let secs = match parts.next() {
        Some(secs) => decimal(secs).ok_or(TimeError::Form)?,
        None => 0.0,
    };
    if parts.next().is_some() {
        return Err(TimeError::Form);
    }
    let hour = match noon {
        Some(noon) if (1..=12).contains(&hour) => hour % 12 + noon,
        Some(_) => return Err(TimeError::Range),
        None => hour,
    };
    if hour > 23 || minute > 59 || !(0.0..60.0).contains(&secs) {
        return Err(TimeError::Range);
    }
    Ok(f64::from(hour * 3600 + minute * 60) + secs)
}

fn number<T: std::str::FromStr>(text: Option<&str>) -> Result<T, TimeError> {
    text.and_then(|text| text.trim().parse().ok()).ok_or(TimeError::Form)
}

/// Splits the zone off a time: `Z`, `+02:00` or `-0530`. Returns its seconds ahead of UTC.
fn zone(text: &str) -> Result<(&str, Option<f64>), TimeError> {
    if let Some(time) = text.strip_suffix(['Z', 'z']) {
        return Ok((time, Some(0.0)));
    }
    let Some(at) = text.find(['+', '-']) else { return Ok((text, None)) };
    let digits: String = text[at + 1..].chars().filter(|letter| *letter != ':').collect();
    if !digits.bytes().all(|digit| digit.is_ascii_digit()) || ![2, 4].contains(&digits.len()) {
        return Err(TimeError::Form);
    }
    let hours: f64 = number(Some(&digits[..2]))?;
    let minutes: f64 = if digits.len() == 4 { number(Some(&digits[2..]))? } else { 0.0 };
    if hours > 14.0 || minutes > 59.0 {
        return Err(TimeError::Range);
    }
    let secs = hours * 3600.0 + minutes * 60.0;
    Ok((&text[..at], Some(if text.as_bytes()[at] == b'-' { -secs } else { secs })))
}

/// Returns the days from 1970-01-01 to a date: `2026-11-26`, `26.11.2026`, `26.11.26` or, where day
/// and month can be told apart, `11/26/2026`.
fn date(text: &str) -> Result<i64, TimeError> {
    let separator = text.find(['-', '.', '/']).ok_or(TimeError::Form)?;
    let separator = char::from(text.as_bytes()[separator]);
    let parts: Vec<&str> = text.split(separator).collect();
    let [first, second, third] = parts[..] else { return Err(TimeError::Form) };
    let [a, b, c]: [i64; 3] = [number(Some(first))?, number(Some(second))?, number(Some(third))?];
    let (year, month, day) = match separator {
        _ if first.len() == 4 => (a, b, c),
        '.' => (full_year(third, c)?, b, a),
        '/' if a > 12 => (full_year(third, c)?, b, a),
        '/' if b > 12 || a == b => (full_year(third, c)?, a, b),
        '/' => return Err(TimeError::Ambiguous),
        _ => return Err(TimeError::Form),
    };
    let is_there = (1..=12).contains(&month) && (1..=days_in(year, month)).contains(&day);
    if is_there { Ok(days_from_1970(year, month, day)) } else { Err(TimeError::Range) }
}

fn full_year(text: &str, year: i64) -> Result<i64, TimeError> {
    match text.len() {
        4 => Ok(year),
        2 => Ok(CENTURY + year),
        _ => Err(TimeError::Form),
    }
}

fn days_in(year: i64, month: i64) -> i64 {
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Returns the days from 1970-01-01 to a date of the Gregorian calendar (Hinnant,
/// "chrono-compatible low-level date algorithms", 2013: `days_from_civil`).
fn days_from_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year - era * 400;
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

/// Returns the date so many days after 1970-01-01, as [`parse`] reads it.
pub(super) fn date_text(days: i64) -> String {
    let (year, month, day) = date_of(days);
    format!("{year}-{month:02}-{day:02}")
}

/// Returns the year, the month and the day of a number of days from 1970-01-01, as above
/// (`civil_from_days`).
fn date_of(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let era = days.div_euclid(146_097);
    let day_of_era = days.rem_euclid(146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * day_of_year + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, day_of_year - (153 * from_march + 2) / 5 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_in_the_forms_of_warehouses() {
        for (text, time) in [
            ("12", FileTime::Secs(12.0)),
            ("12,5", FileTime::Secs(12.5)),
            ("8:30", FileTime::Clock(30_600.0)),
            ("08:30:15,5", FileTime::Clock(30_615.5)),
            ("8:30 pm", FileTime::Clock(73_800.0)),
            ("12:05 AM", FileTime::Clock(300.0)),
            ("1970-01-02 00:00", FileTime::Local(86_400.0)),
            ("2026-11-26T08:30:00", FileTime::Local(1_795_681_800.0)),
            ("26.11.2026 08:30", FileTime::Local(1_795_681_800.0)),
            ("26.11.26 8:30", FileTime::Local(1_795_681_800.0)),
            ("11/26/2026 8:30 AM", FileTime::Local(1_795_681_800.0)),
            ("26/11/2026 08:30", FileTime::Local(1_795_681_800.0)),
            ("2026-11-26T08:30:00Z", FileTime::Instant(1_795_681_800.0)),
            ("2026-11-26T09:30:00+01:00", FileTime::Instant(1_795_681_800.0)),
            ("2026-11-26 03:00-0530", FileTime::Instant(1_795_681_800.0)),
            ("2024-02-29", FileTime::Local(1_709_164_800.0)),
        ] {
            assert_eq!(parse(text), Ok(time), "{text}");
        }
    }

    #[test]
    fn dates_are_written_as_they_were_read() {
        for text in ["1970-01-01 00:00", "2024-02-29 23:59", "2026-11-26 08:30", "1999-12-31 06:00"]
        {
            assert_eq!(parse(text).expect(text).to_string(), text);
        }
        assert_eq!(parse("8:05").expect("a time").to_string(), "08:05");
        let utc = parse("2026-11-26T08:30+01:00").expect("a time").to_string();
        assert_eq!(utc, "2026-11-26 07:30 UTC");
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for (text, error) in [
            ("", TimeError::Form),
            ("-5", TimeError::Form),
            ("soon", TimeError::Form),
            ("1.234,5", TimeError::Form),
            ("25:00", TimeError::Range),
            ("08:60", TimeError::Range),
            ("13:00 PM", TimeError::Range),
            ("2026-02-29 08:00", TimeError::Range),
            ("31.04.2026 08:00", TimeError::Range),
            ("2026-11-26T08:30+99:00", TimeError::Range),
            ("03/04/2026 08:00", TimeError::Ambiguous),
            ("1.2.3.4 08:00", TimeError::Form),
            ("nan", TimeError::Form),
            ("ü-1-1 8:00", TimeError::Form),
        ] {
            assert_eq!(parse(text), Err(error), "{text}");
        }
    }
}
