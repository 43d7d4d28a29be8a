//! Checks of a visualiser that loses, delays, repeats and falsifies lines.

use proptest::prelude::*;

use super::*;
use crate::line::{AngleUnit, LineFormat, Separator};

const DEADLINE: Duration = Duration::from_secs(1);
const PERIOD: Duration = Duration::from_millis(20);

fn check(offset: [f64; 2]) -> EchoCheck {
    let format = LineFormat::new(Separator::Comma, 3, AngleUnit::Degrees);
    EchoCheck::new(EchoRules::new(format, 9, AngleUnit::Degrees, offset, DEADLINE))
}

/// Returns a robot's pose in a frame. No two frames have the same pose.
fn pose(id: u32, frame: u32) -> PoseLine {
    PoseLine { id, x: id as f32 + frame as f32 * 0.01, y: -3.25, theta: 179.999 }
}

fn send(check: &mut EchoCheck, lines: &[PoseLine], at: Instant) {
    let mut frame = check.frame(lines.first().map_or(0, |line| line.id), at);
    lines.iter().for_each(|line| frame.push(line));
    check.note(frame);
}

#[test]
fn each_line_is_counted_once() {
    let (mut check, start) = (check([0.0; 2]), Instant::now());
    let sent: Vec<_> = [1, 2, 3, 4, 6].map(|id| pose(id, 0)).to_vec();
    send(&mut check, &sent, start);
    let soon = start + DEADLINE / 2;
    check.judge(&sent[0], soon);
    check.judge(&sent[0], soon);
    check.judge(&PoseLine { y: 9.0, ..sent[1] }, soon);
    for unknown in [0, 5, 7, u32::MAX] {
        check.judge(&pose(unknown, 0), soon);
    }
    assert_eq!(check.totals().open(), 3);
    let after = start + DEADLINE + PERIOD;
    check.pass_time(after);
    check.judge(&sent[2], after);
    let expected = EchoTotals {
        sent: 5,
        answered: 1,
        repeated: 1,
        differing: 1,
        unknown: 4,
        late: 1,
        missing: 2,
        unchecked: 0,
    };
    assert_eq!((check.totals(), check.totals().open()), (expected, 0));
    check.pass_time(start + 3 * DEADLINE);
    assert_eq!((check.totals(), check.lines), (expected, 0));
    let text = check.to_string();
    assert!(
        text.contains("2 missing (2 robots: 4, 6), 1 late (robot 3), 1 differing (robot 2)"),
        "{text}"
    );
}

#[test]
fn an_answer_is_late_even_if_deadlines_were_not_checked_before() {
    let (mut check, start) = (check([0.0; 2]), Instant::now());
    send(&mut check, &[pose(0, 0)], start);
    check.judge(&pose(0, 0), start + DEADLINE + PERIOD);
    assert_eq!((check.totals().late, check.totals().missing), (1, 0));
    check.pass_time(start + 5 * DEADLINE);
    assert_eq!((check.totals().late, check.totals().missing), (1, 0));
}

#[test]
fn the_visualisers_offset_and_a_full_turn_make_no_difference() {
    let (mut check, start) = (check([10.0, -5.5]), Instant::now());
    send(&mut check, &[pose(3, 0)], start);
    check.judge(&PoseLine { x: 13.0, y: -8.75, theta: -180.001, id: 3 }, start);
    assert_eq!(check.totals().answered, 1);
    send(&mut check, &[pose(3, 1)], start);
    check.judge(&pose(3, 1), start);
    assert_eq!(check.totals().differing, 1, "without the offset");
}

#[test]
fn equal_lines_of_a_standing_robot_are_counted_separately() {
    let (mut check, start) = (check([0.0; 2]), Instant::now());
    for frame in 0..10 {
        send(&mut check, &[pose(0, 0)], start + PERIOD * frame);
    }
    for _ in 0..8 {
        check.judge(&pose(0, 0), start + PERIOD * 10);
    }
    check.pass_time(start + 3 * DEADLINE);
    assert_eq!((check.totals().answered, check.totals().missing), (8, 2));
}

#[test]
fn memory_is_bounded() {
    let (mut check, start) = (check([0.0; 2]), Instant::now());
    check.max_lines = 1_000;
    let lines: Vec<_> = (0..100).map(|id| pose(id, 0)).collect();
    for _ in 0..50 {
        send(&mut check, &lines, start);
        assert!(check.lines <= 1_000);
    }
    assert_eq!((check.totals().unchecked, check.totals().open()), (4_000, 1_000));
}

proptest! {
    #[test]
    fn losses_delays_and_repetitions_of_any_lines_are_counted(
        behaviours in prop::collection::vec(prop::collection::vec(0_u8..5, 1..30), 1..20)
    ) {
        let (mut check, start) = (check([0.0; 2]), Instant::now());
        let mut due = Vec::new();
        let mut expected = EchoTotals::default();
        for (number, behaviours) in (0..).zip(&behaviours) {
            let at = start + PERIOD * number;
            let lines: Vec<_> = (0..behaviours.len() as u32).map(|id| pose(id, number)).collect();
            send(&mut check, &lines, at);
            expected.sent += lines.len() as u64;
            for (line, behaviour) in lines.into_iter().zip(behaviours) {
                match behaviour {
                    0 => { expected.answered += 1; due.push((at + PERIOD / 2, line)); }
                    1 => { expected.missing += 1; }
                    2 => { expected.late += 1; due.push((at + DEADLINE + PERIOD / 2, line)); }
                    3 => {
                        (expected.answered, expected.repeated) = (expected.answered + 1, expected.repeated + 1);
                        due.extend([(at, line), (at + PERIOD, line)]);
                    }
                    // At the deadline, which is still in time.
                    _ => { expected.answered += 1; due.push((at + DEADLINE, line)); }
                }
            }
        }
        due.sort_by_key(|(at, _)| *at);
        for (at, answer) in due {
            check.pass_time(at);
            check.judge(&answer, at);
        }
        check.pass_time(start + 10 * DEADLINE);
        prop_assert_eq!(check.totals(), expected);
        prop_assert_eq!((check.lines, check.totals().open()), (0, 0));
    }
}
