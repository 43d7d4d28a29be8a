use std::fs;

use super::*;
use crate::load::Load;
use crate::places::Place;

fn places() -> Places {
    let place = |id, name: &str| Place { id, name: name.to_owned(), ..Place::default() };
    Places::new(vec![place(1, "A"), place(2, "B")])
}

/// A load with a timetable of 200 orders, one every 30 s from 1000 s on, and further keys.
fn load(keys: &str) -> Result<Load, yaml::Error> {
    let rows: String =
        (0..200).map(|row| format!("    o{row},{},A:pick:4 B:drop\n", 1000 + 30 * row)).collect();
    let text = format!("load:\n  timetable: |\n    name,time,stops\n{rows}{keys}");
    Load::parse(&text, &places())
}

fn orders(keys: &str, seed: u64) -> Vec<(f64, NewOrder)> {
    load(keys).expect("a load").timetables[0].orders(seed)
}

#[test]
fn a_day_as_it_is_has_no_chance() {
    let [one, other] = [1, 2].map(|seed| orders("", seed));
    assert_eq!((one.len(), &one), (200, &other));
    assert_eq!((one[7].0, one[7].1.name.as_str()), (1210.0, "o7"));
    let later = orders("  shift: 60\n  deadline: 100\n  dwell: {min: 2, max: 3}\n", 1);
    assert_eq!((later[7].0, later[7].1.deadline_secs), (1270.0, Some(1370.0)));
    let [pick, drop] = [0, 1].map(|stop| later[7].1.stops[stop].dwell_secs);
    assert!(pick == 4.0 && (2.0..=3.0).contains(&drop), "{pick} {drop}");
}

#[test]
fn a_scale_repeats_orders_and_leaves_them_out() {
    for (scale, least, most) in [(1.2, 220, 260), (0.5, 80, 120), (3.0, 600, 600)] {
        let scaled = orders(&format!("  scale: {scale}\n"), 5);
        assert!((least..=most).contains(&scaled.len()), "{scale}: {}", scaled.len());
        assert!(scaled.windows(2).all(|pair| pair[0].0 <= pair[1].0), "by time");
        let names: BTreeSet<_> = scaled.iter().map(|(_, order)| &order.name).collect();
        assert_eq!(names.len(), scaled.len(), "names are new");
    }
}

#[test]
fn each_seed_has_another_day_of_the_same_kind() {
    let days: Vec<_> = (1..=40).map(|seed| orders("  resample: 600\n", seed)).collect();
    assert_eq!(days[3], orders("  resample: 600\n", 4), "the same seed, the same day");
    assert_ne!(days[0], days[1]);
    let mean = days.iter().map(Vec::len).sum::<usize>() as f64 / 40.0;
    assert!((mean - 200.0).abs() < 8.0, "{mean}");
    for (secs, order) in days.iter().flatten() {
        let row = order.name.as_str().trim_start_matches('o').split('~').next().expect("a row");
        let file_secs = 1000.0 + 30.0 * row.parse::<f64>().expect("a number");
        let moved = secs - file_secs;
        assert!([-600.0, 0.0, 600.0].contains(&moved), "whole blocks, to neighbours: {moved}");
    }
}

#[test]
fn orders_of_a_file_lie_beside_the_load() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("day.csv"), "time,stops\n5,A B\n").expect("written");
    let path = folder.path().join("load.yaml");
    fs::write(&path, "load: {generators: [{orders: day.csv}]}\n").expect("written");
    let load = Load::read(&path, &places()).expect("a load");
    assert_eq!(load.timetables[0].orders(0)[0].0, 5.0);
    fs::write(folder.path().join("day.csv"), "time,stops\n5,A C\n").expect("written");
    let error = Load::read(&path, &places()).expect_err("an unknown station").to_string();
    assert!(error.contains("line 2: stop 2 is at `C`"), "{error}");
}

#[test]
fn what_is_wrong_is_told() {
    for (keys, reason) in [
        ("  scale: 0\n", "above 0"),
        ("  scale: 1000\n", "at most 100"),
        ("  resample: 5\n", "at least 60 s"),
        ("  orders: a.csv\n", "not both"),
    ] {
        let error = load(keys).expect_err(keys).to_string();
        assert!(error.contains(reason), "{keys}: {error}");
    }
    for (text, reason) in [
        ("load: {orders: a.csv}", "only a load that is a file"),
        ("load: {per_hour: 3, scale: 2}", "for a load with `orders`"),
        ("load: {timetable: \"time,stops\\n\"}", "no orders"),
        ("load: {timetable: \"time,stops\\n1,X\\n\"}", "line 2: stop 1 is at `X`"),
    ] {
        let error = Load::parse(text, &places()).expect_err(text).to_string();
        assert!(error.contains(reason), "{text}: {error}");
    }
}

#[test]
fn a_time_beyond_all_bounds_is_refused() {
    let load = |secs: &str| {
        let text = format!("load: {{timetable: \"time,stops\\n{secs},A B\\n\", resample: 60}}");
        Load::parse(&text, &places())
    };
    assert_eq!(load("1e9").expect("a load").timetables[0].orders(1).len(), 1);
    let error = load("1e300").expect_err("too late").to_string();
    assert!(error.contains("line 2: `time` is 1"), "{error}");
}
