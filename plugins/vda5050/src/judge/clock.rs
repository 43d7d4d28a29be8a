//! Times of messages: texts in ISO 8601, and seconds since 1970.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The latest time that is read: the end of the year 9999.
const LATEST_SECONDS: f64 = 253_402_300_799.0;

/// The seconds since 1970 of a text in ISO 8601 and UTC; `None` for other texts.
pub fn seconds(text: &str) -> Option<f64> {
    let time = humantime::parse_rfc3339(text).ok().filter(|_| text.ends_with('Z'))?;
    time.duration_since(UNIX_EPOCH).ok().map(|since| since.as_secs_f64())
}

/// The seconds since 1970 of a text in ISO 8601 with any zone: `2026-01-31T10:00:00+0100`.
pub fn seconds_with_zone(text: &str) -> Option<f64> {
    if text.ends_with('Z') {
        return seconds(text);
    }
    let at = text.rfind(['+', '-']).filter(|at| *at > 10)?;
    let (local, zone) = text.split_at(at);
    // mosquitto_sub writes both: `2026-01-31T09:00:00.000000Z+0000`.
    let local = local.trim_end_matches('Z');
    let sign = if zone.starts_with('-') { -1.0 } else { 1.0 };
    let digits = zone[1..].replace(':', "");
    let hours: u16 = digits.get(..2)?.parse().ok()?;
    let minutes: u16 = digits.get(2..).filter(|rest| rest.len() == 2)?.parse().ok()?;
    let offset = sign * (f64::from(hours) * 3600.0 + f64::from(minutes) * 60.0);
    Some(seconds(&format!("{local}Z"))? - offset)
}

/// Writes seconds since 1970 as a text in ISO 8601 and UTC, with milliseconds.
pub fn text(seconds: f64) -> String {
    let since = Duration::try_from_secs_f64(seconds.clamp(0.0, LATEST_SECONDS)).unwrap_or_default();
    humantime::format_rfc3339_millis(SystemTime::UNIX_EPOCH + since).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_their_zones() {
        assert_eq!(seconds("1970-01-01T00:00:01.25Z"), Some(1.25));
        assert_eq!(seconds("1970-01-01T00:00:01+00:00"), None);
        assert_eq!(seconds_with_zone("1970-01-01T01:00:01+0100"), Some(1.0));
        assert_eq!(seconds_with_zone("1970-01-01T00:00:01-00:30"), Some(1801.0));
        for text in ["", "-", "1970-01-01", "1970-01-01T00:00:00+1", "1970-01-01T00:00:00+01€0"] {
            assert_eq!(seconds_with_zone(text), None, "{text}");
        }
        assert_eq!(text(1.25), "1970-01-01T00:00:01.250Z");
        assert_eq!(text(f64::MAX), "9999-12-31T23:59:59.000Z");
        assert_eq!(text(f64::NAN), "1970-01-01T00:00:00.000Z");
    }
}
