use regatta_plugin::order::OrderHeader;

use super::*;

const RUN: u64 = 7;
/// Ten ticks are a second.
const TICK_SECS: f64 = 0.1;

/// Adds records of orders as the first sample of a run, by the second at which they were written.
fn add(tally: &mut OrderTally, run_id: u64, secs: u64, records: &[(u64, OrderKind)]) {
    let records: Vec<_> =
        records.iter().map(|(order, kind)| OrderRecord::new(*order, *kind)).collect();
    let header = OrderHeader { run_id, tick: 10 * secs, sequence: 1, ..OrderHeader::default() };
    tally.add(&Orders { header: &header, records: &records, missed: 0 }, TICK_SECS);
}

fn figures(tally: &OrderTally, secs: u64) -> OrderFigures {
    tally.figures(&RunClock { run_id: RUN, tick: 10 * secs, tick_secs: TICK_SECS })
}

fn is_near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 1e-3 * expected
}

#[test]
fn orders_are_counted_and_timed() {
    use OrderKind::{
        Arrived, Assigned, Cancelled, Created, Failed, Finished, Handled, Stop, Withdrawn,
    };
    let mut tally = OrderTally::default();
    add(&mut tally, RUN, 0, &[(1, Created), (1, Stop), (2, Created), (2, Stop), (3, Created)]);
    add(&mut tally, RUN, 10, &[(1, Assigned), (1, Withdrawn), (2, Assigned)]);
    add(&mut tally, RUN, 30, &[(1, Assigned), (2, Arrived), (2, Handled), (2, Finished)]);
    add(
        &mut tally,
        RUN,
        100,
        &[(1, Finished), (3, Cancelled), (4, Created), (5, Created), (5, Failed)],
    );
    let figures = figures(&tally, 100);
    assert_eq!(
        (figures.created, figures.finished, figures.failed, figures.cancelled),
        (5, 2, 1, 1)
    );
    assert_eq!((figures.open, figures.gaps), (Some(1), 0));
    assert_eq!(
        (figures.service.count, figures.service.mean(), figures.service.longest),
        (2, Some(65.0), 100.0)
    );
    assert!(
        is_near(figures.service.p50, 30.0) && is_near(figures.service.p99, 100.0),
        "{figures:?}"
    );
    assert_eq!(
        (figures.waiting.count, figures.waiting.mean()),
        (2, Some(10.0)),
        "only the first assignment counts"
    );
}

#[test]
fn the_rate_is_that_of_the_last_hour() {
    let mut tally = OrderTally::default();
    add(&mut tally, RUN, 0, &[(0, OrderKind::Created)]);
    let finish = |tally: &mut OrderTally, secs: std::ops::Range<u64>, step: usize| {
        secs.step_by(step).for_each(|secs| add(tally, RUN, secs, &[(secs, OrderKind::Finished)]));
    };
    finish(&mut tally, 0..600, 1);
    let ahead = figures(&tally, 30).finished_per_second.expect("the log is ahead of the frames");
    assert!((ahead - 1.0).abs() < 0.01, "{ahead}");
    assert!(is_near(figures(&tally, 1200).finished_per_second.expect("a rate"), 0.5));
    finish(&mut tally, 600..7200, 4);
    assert!((figures(&tally, 7200).finished_per_second.expect("a rate") - 0.25).abs() < 0.01);
    assert!(tally.finished_by_minute.len() <= 60, "older minutes are forgotten");
    assert_eq!(figures(&tally, 11_000).finished_per_second, Some(0.0));
}

#[test]
fn the_first_minute_has_no_rate() {
    let mut tally = OrderTally::default();
    add(&mut tally, RUN, 1000, &[(1, OrderKind::Finished)]);
    assert_eq!(figures(&tally, 1059).finished_per_second, None);
    assert!(is_near(figures(&tally, 1060).finished_per_second.expect("a rate"), 1.0 / 60.0));
}

#[test]
fn a_reader_that_joins_late_counts_what_it_sees() {
    let mut tally = OrderTally::default();
    let records = [(1, OrderKind::Handled), (2, OrderKind::Assigned), (3, OrderKind::Finished)];
    let records = records.map(|(order, kind)| OrderRecord::new(order, kind));
    let header = OrderHeader { run_id: RUN, tick: 500, sequence: 17, ..OrderHeader::default() };
    tally.add(&Orders { header: &header, records: &records, missed: 0 }, TICK_SECS);
    let seen = figures(&tally, 50);
    assert_eq!((seen.created, seen.finished), (0, 1));
    assert_eq!(seen.open, None, "there may be more than those that were seen");
    assert_eq!((seen.service.count, seen.waiting.count), (0, 0), "their creation was not seen");
}

#[test]
fn another_run_and_a_replay_that_is_wound_back_start_anew() {
    let mut tally = OrderTally::default();
    for (run_id, secs) in [(RUN + 1, 5), (RUN, 9), (RUN, 3)] {
        add(&mut tally, run_id, secs, &[(1, OrderKind::Created), (2, OrderKind::Created)]);
        let clock = RunClock { run_id, tick: 100, tick_secs: TICK_SECS };
        assert_eq!((tally.figures(&clock).created, tally.figures(&clock).open), (2, Some(2)));
    }
    assert_eq!(
        tally.figures(&RunClock { run_id: RUN + 1, tick: 100, tick_secs: 0.1 }),
        OrderFigures::default()
    );
}

#[test]
fn gaps_are_counted_and_unknown_records_ignored() {
    let mut tally = OrderTally::default();
    let header = OrderHeader { run_id: RUN, tick: 1, dropped: 12, sequence: 1 };
    let records = [OrderRecord { kind: 99, ..OrderRecord::new(1, OrderKind::Created) }];
    tally.add(&Orders { header: &header, records: &records, missed: 4 }, TICK_SECS);
    let figures = figures(&tally, 1);
    assert_eq!(figures, OrderFigures { gaps: 5, ..OrderFigures::default() });
}
