//! The fuzz target of datagrams: none makes the UDP plugins panic, hang or exhaust memory.

use std::time::{Duration, Instant};

use regatta_plugin::frame::{Columns, ColumnsMut, Line, frame_lines};
use regatta_udp::echo::{EchoCheck, EchoRules};
use regatta_udp::line::{AngleUnit, LineFormat, PoseLine, Separator, lines};
use regatta_udp::source::intake::Intake;

const MAX_ROBOTS: u32 = 1_000;
const DEADLINE: Duration = Duration::from_millis(50);

/// Treats the datagrams of an input, which are separated by zero bytes.
pub fn read(options: u8, bytes: &[u8]) {
    let unit = if options & 1 == 0 { AngleUnit::Degrees } else { AngleUnit::Radians };
    let datagrams = bytes.split(|&byte| byte == 0);
    for line in datagrams.clone().flat_map(lines) {
        assert_round_trip(line, Separator::Comma);
        assert_round_trip(line, Separator::Space);
    }
    check_source(datagrams.clone(), unit, options);
    check_answers(datagrams, unit);
}

fn assert_round_trip(line: &[u8], separator: Separator) {
    let Ok(read) = PoseLine::parse(line, separator) else { return };
    assert!(read.x.is_finite() && read.y.is_finite() && read.theta.is_finite());
    let format = LineFormat { separator, decimals: 9, theta_decimals: 9 };
    let mut text = Vec::new();
    read.write(&mut text, format);
    let again =
        PoseLine::parse(text.trim_ascii_end(), separator).expect("a written line can be parsed");
    let (x, y, theta) = (again.x - read.x, again.y - read.y, again.theta - read.theta);
    assert!(again.id == read.id && [x, y, theta].iter().all(|difference| difference.abs() <= 1e-9));
}

fn check_source<'a>(datagrams: impl Iterator<Item = &'a [u8]>, unit: AngleUnit, options: u8) {
    let offset = if options & 2 == 0 { [0.0, 0.0] } else { [1e38, -0.5] };
    let mut intake = Intake::new(unit, offset, 300, MAX_ROBOTS);
    let (mut now, mut used) = (Duration::ZERO, 0);
    for datagram in datagrams {
        now += Duration::from_millis(60);
        intake.take(datagram, now, |_| used += 1);
        intake.robots.forget(Duration::from_secs(1), now);
    }
    let rows = intake.robots.len();
    assert!(rows <= MAX_ROBOTS as usize && used == intake.lines);
    let mut lines = vec![Line::default(); frame_lines(rows)];
    intake.robots.write(&mut ColumnsMut::split(&mut lines, rows), now);
    let columns = Columns::split(&lines, rows).expect("enough lines");
    for column in [columns.x, columns.y, columns.theta, columns.speed] {
        assert!(column.iter().all(|value| value.is_finite()));
    }
    let pi = core::f32::consts::PI;
    assert!(columns.theta.iter().all(|theta| -pi < *theta && *theta <= pi));
}

/// Sends the lines of every other datagram, and treats those of the others as answers.
fn check_answers<'a>(datagrams: impl Iterator<Item = &'a [u8]>, unit: AngleUnit) {
    let format = LineFormat::new(Separator::Comma, 3, unit);
    let mut check = EchoCheck::new(EchoRules::new(format, 3, unit, [0.0; 2], DEADLINE));
    let mut now = Instant::now();
    for (number, datagram) in datagrams.enumerate() {
        now += DEADLINE / 3;
        if number % 2 == 0 {
            let mut sent = check.frame(2, now);
            let all =
                lines(datagram).filter_map(|line| PoseLine::parse(line, Separator::Comma).ok());
            all.filter(|line| line.id < MAX_ROBOTS).for_each(|line| sent.push(&line));
            check.note(sent);
        } else {
            let answers =
                lines(datagram).filter_map(|line| PoseLine::parse(line, Separator::Space).ok());
            answers.for_each(|line| check.judge(&line, now));
        }
        check.pass_time(now);
    }
    // This subtraction would overflow if a line were counted twice.
    let open = check.totals().open();
    assert!(open <= check.totals().sent && !check.to_string().is_empty());
    check.pass_time(now + 3 * DEADLINE);
    assert_eq!(check.totals().open(), 0);
}
