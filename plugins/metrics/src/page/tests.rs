use std::collections::BTreeSet;

use super::*;
use crate::testing;

/// Returns the names of all samples, including those of histograms' parts.
fn exported(page: &str) -> BTreeSet<&str> {
    page.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split(['{', ' ']).next()).collect()
}

/// Returns each family as `(name, help, type)`.
fn families(page: &str) -> Vec<(&str, &str, &str)> {
    let mut lines = page.lines().filter(|line| line.starts_with('#'));
    let mut families = Vec::new();
    while let Some(help) = lines.next() {
        let (name, help) = help.strip_prefix("# HELP ").and_then(|rest| rest.split_once(' ')).expect(help);
        let kind = lines.next().and_then(|line| line.strip_prefix("# TYPE ")?.strip_prefix(name)).expect(name);
        families.push((name, help, kind.trim()));
    }
    families
}

fn full_page() -> String {
    page(&testing::snapshot(), Some(RowCounts { written: 5, lost: 1 }))
}

/// Tests the rules of `promtool check metrics`.
#[test]
fn names_and_units_follow_the_rules() {
    let (page, mut seen) = (full_page(), BTreeSet::new());
    let no_base_units = [
        "milliseconds",
        "microseconds",
        "nanoseconds",
        "minutes",
        "hours",
        "ms",
        "us",
        "ns",
        "sec",
        "kilobytes",
        "megabytes",
        "kb",
        "mb",
        "km",
        "m",
        "mm",
        "percent",
        "celsius",
        "fahrenheit",
    ];
    for (name, help, kind) in families(&page) {
        assert!(seen.insert(name), "{name} twice");
        assert!(name.starts_with("regatta_") && !help.is_empty(), "{name}: {help}");
        assert!(name.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{name}");
        assert_eq!(kind == "counter", name.ends_with("_total"), "{name} is a {kind}");
        for word in name.split('_') {
            assert!(!no_base_units.contains(&word), "{name} has {word}");
            assert!(!["counter", "gauge", "histogram", "summary"].contains(&word), "{name} has {word}");
        }
        assert!(!["_count", "_sum", "_bucket"].iter().any(|end| name.ends_with(end)), "{name}");
    }
    assert!(seen.len() > 25, "{seen:?}");
}

#[test]
fn values_equal_those_of_the_snapshot() {
    let page = full_page();
    let wanted = [
        "regatta_up{fleet=\"default\"} 1",
        "regatta_ticks_total{fleet=\"default\"} 123456",
        "regatta_late_ticks_total{fleet=\"default\"} 3",
        "regatta_real_time_ratio{fleet=\"default\"} 0.998",
        "regatta_robots{fleet=\"default\",state=\"driving\"} 812",
        "regatta_driven_metres_total{fleet=\"default\"} 98765.4",
        "regatta_collision_pairs{fleet=\"default\",level=\"touching\"} 12",
        "regatta_collision_robots{fleet=\"default\",level=\"possible\"} 55",
        "regatta_collisions_total{fleet=\"default\",level=\"touching\"} 77",
        "regatta_collision_lag_seconds{fleet=\"default\"} 0.01",
        "regatta_frames_skipped_total{fleet=\"default\"} 6",
        "regatta_process_cpu_seconds_total{fleet=\"default\",name=\"engine\",pid=\"4000000\"} 12.5",
        "regatta_tick_cost_seconds_bucket{fleet=\"default\",le=\"0.0001\"} 10",
        "regatta_tick_cost_seconds_bucket{fleet=\"default\",le=\"+Inf\"} 100",
        "regatta_tick_cost_seconds_count{fleet=\"default\"} 100",
        "regatta_csv_rows_lost_total{fleet=\"default\"} 1",
    ];
    for line in wanted {
        assert!(page.lines().any(|have| have == line), "{line} in\n{page}");
    }
}

#[test]
fn unknown_values_are_left_out() {
    let text = page(&testing::without_engine(), None);
    assert!(text.contains("regatta_up{fleet=\"default\"} 0\n"), "{text}");
    for absent in ["regatta_robots", "regatta_ticks", "regatta_collision", "regatta_csv"] {
        assert!(!text.contains(absent), "{absent} in\n{text}");
    }
}

#[test]
fn a_name_with_quotes_stays_one_label() {
    let mut snapshot = testing::without_engine();
    snapshot.processes[0].name = "a\"b\\c\nd".to_owned();
    let text = page(&snapshot, None);
    assert!(text.contains(r#"name="a\"b\\c\nd""#), "{text}");
}

/// Collects the names of metrics in a dashboard's queries.
fn queried(dashboard: &serde_json::Value, names: &mut BTreeSet<String>) {
    match dashboard {
        serde_json::Value::Object(fields) => {
            for key in ["expr", "query", "definition"] {
                let text = fields.get(key).and_then(serde_json::Value::as_str).unwrap_or_default();
                let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
                names.extend(words.filter(|word| word.starts_with("regatta_")).map(str::to_owned));
            }
            fields.values().for_each(|value| queried(value, names));
        }
        serde_json::Value::Array(values) => values.iter().for_each(|value| queried(value, names)),
        _ => {}
    }
}

#[test]
fn the_dashboard_queries_exactly_the_exported_metrics() {
    let dashboard = serde_json::from_str(include_str!("../../grafana-dashboard.json")).expect("valid JSON");
    let mut names = BTreeSet::new();
    queried(&dashboard, &mut names);
    let page = full_page();
    let exported = exported(&page);
    for name in &names {
        assert!(exported.contains(&**name), "{name} is not exported");
    }
    for (family, ..) in families(&page) {
        assert!(names.iter().any(|name| name.starts_with(family)), "{family} is in no panel");
    }
}
