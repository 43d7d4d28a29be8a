//! Human-readable numbers.

use std::time::Duration;

use regatta_base::thousands;

/// Formats seconds in the unit that gives two or three digits: `12 µs`, `1.23 ms`.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 999.5e-6 => format!("{:.0} µs", s * 1e6),
        s if s < 9.995e-3 => format!("{:.2} ms", s * 1e3),
        s if s < 99.95e-3 => format!("{:.1} ms", s * 1e3),
        s if s < 999.5e-3 => format!("{:.0} ms", s * 1e3),
        s => format!("{s:.1} s"),
    }
}

/// Formats simulated time: `12.34 s`, then `1:02:03.45`.
pub fn clock(time: Duration) -> String {
    let (whole, hundredths) = (time.as_secs(), time.subsec_millis() / 10);
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds}.{hundredths:02} s"),
        (0, _) => format!("{minutes}:{seconds:02}.{hundredths:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}.{hundredths:02}"),
    }
}

/// Formats bytes: `34 MB`.
pub fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 999.5e3 => format!("{:.0} kB", b * 1e-3),
        b if b < 9.995e6 => format!("{:.1} MB", b * 1e-6),
        b if b < 999.5e6 => format!("{:.0} MB", b * 1e-6),
        b => format!("{:.1} GB", b * 1e-9),
    }
}

/// Formats a wanted speed: `×2`, or `max`.
pub fn speed(speed: f32) -> String {
    if speed.is_finite() { format!("×{speed}") } else { "max".to_owned() }
}

/// Formats a real-time factor with three to four significant digits: `0.998`, `12.3`, `5,432`.
pub fn factor(factor: f64) -> String {
    match factor {
        f if f < 9.9995 => format!("{f:.3}"),
        f if f < 999.95 => format!("{f:.1}"),
        f => thousands(f.round() as u64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_human_readable() {
        let times = [0.0, 12.4e-6, 999.4e-6, 999.6e-6, 0.012_34, 0.5, 3.21].map(seconds);
        assert_eq!(times, ["0 µs", "12 µs", "999 µs", "1.00 ms", "12.3 ms", "500 ms", "3.2 s"]);
        let clocks = [1_230, 61_230, 3_723_450].map(|millis| clock(Duration::from_millis(millis)));
        assert_eq!(clocks, ["1.23 s", "1:01.23", "1:02:03.45"]);
        assert_eq!(
            [45_056, 1_600_000, 34_000_000, 6_100_000_000].map(bytes),
            ["45 kB", "1.6 MB", "34 MB", "6.1 GB"]
        );
        assert_eq!([1.0, 0.1, f32::INFINITY].map(speed), ["×1", "×0.1", "max"]);
        assert_eq!([0.998, 12.34, 5_432.1].map(factor), ["0.998", "12.3", "5,432"]);
    }
}
