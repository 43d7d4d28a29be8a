use std::collections::BTreeSet;

use super::*;
use crate::testing;

/// Returns the names of all samples, including those of histograms' parts.
fn exported(page: &str) -> BTreeSet<&str> {
    page.lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split(['{', ' ']).next())
        .collect()
}

/// Returns each family as `(name, help, type)`.
fn families(page: &str) -> Vec<(&str, &str, &str)> {
    let mut lines = page.lines().filter(|line| line.starts_with('#'));
    let mut families = Vec::new();
    while let Some(help) = lines.next() {
        let (name, help) =
            help.strip_prefix("# HELP ").and_then(|rest| rest.split_once(' ')).expect(help);
        let kind = lines
            .next()
            .and_then(|line| line.strip_prefix("# TYPE ")?.strip_prefix(name))
            .expect(name);
        families.push((name, help, kind.trim()));
    }
    families
}

const EXPORTER: ExporterState =
    ExporterState { rows: Some(RowCounts { written: 5, lost: 1 }), commit: Some("c0ffee") };

fn full_page() -> String {
    page(&testing::snapshot(), &EXPORTER, Format::Prometheus)
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
            assert!(
                !["counter", "gauge", "histogram", "summary"].contains(&word),
                "{name} has {word}"
            );
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
        "regatta_manager_robots{fleet=\"default\",activity=\"carrying\"} 614",
        "regatta_manager_robots{fleet=\"default\",activity=\"fetching\"} 201",
        "regatta_manager_robots{fleet=\"default\",activity=\"held\"} 6",
        "regatta_orders_created_total{fleet=\"default\"} 4389",
        "regatta_orders_total{fleet=\"default\",outcome=\"finished\"} 4321",
        "regatta_orders_total{fleet=\"default\",outcome=\"failed\"} 3",
        "regatta_orders_total{fleet=\"default\",outcome=\"cancelled\"} 7",
        "regatta_orders_open{fleet=\"default\"} 58",
        "regatta_orders_finished_per_second{fleet=\"default\"} 0.125",
        "regatta_order_service_seconds{fleet=\"default\",quantile=\"0.99\"} 120",
        "regatta_order_service_seconds_sum{fleet=\"default\"} 244000",
        "regatta_order_waiting_seconds{fleet=\"default\",quantile=\"0.5\"} 6",
        "regatta_order_waiting_seconds_count{fleet=\"default\"} 4050",
        "regatta_order_longest_service_seconds{fleet=\"default\"} 300",
        "regatta_order_log_gaps_total{fleet=\"default\"} 2",
        "regatta_frames_skipped_total{fleet=\"default\"} 6",
        "regatta_process_cpu_seconds_total{fleet=\"default\",name=\"engine\"} 12.5",
        "regatta_tick_cost_seconds_bucket{fleet=\"default\",le=\"0.0001\"} 10",
        "regatta_tick_cost_seconds_bucket{fleet=\"default\",le=\"+Inf\"} 100",
        "regatta_tick_cost_seconds_count{fleet=\"default\"} 100",
        "regatta_csv_rows_lost_total{fleet=\"default\"} 1",
        &format!(
            "regatta_build_info{{fleet=\"default\",version=\"{}\",commit=\"c0ffee\",contract=\"{CONTRACT_VERSION}\"}} 1",
            env!("CARGO_PKG_VERSION")
        ),
    ];
    for line in wanted {
        assert!(page.lines().any(|have| have == line), "{line} in\n{page}");
    }
}

#[test]
fn unknown_values_are_left_out() {
    let text = page(&testing::without_engine(), &ExporterState::default(), Format::Prometheus);
    assert!(text.contains("regatta_up{fleet=\"default\"} 0\n"), "{text}");
    for absent in [
        "regatta_robots",
        "regatta_ticks",
        "regatta_collision",
        "regatta_manager",
        "regatta_order",
        "regatta_csv",
    ] {
        assert!(!text.contains(absent), "{absent} in\n{text}");
    }
}

#[test]
fn times_of_no_order_have_neither_quantiles_nor_a_longest() {
    let mut snapshot = testing::snapshot();
    snapshot.work = Some(Work::default());
    let text = page(&snapshot, &EXPORTER, Format::Prometheus);
    assert!(text.contains("regatta_order_service_seconds_count{fleet=\"default\"} 0\n"), "{text}");
    for absent in [
        "quantile=",
        "regatta_order_longest",
        "regatta_orders_open",
        "regatta_orders_finished_per_second",
    ] {
        assert!(!text.contains(absent), "{absent} in\n{text}");
    }
}

#[test]
fn processes_of_the_same_name_share_a_series() {
    let mut snapshot = testing::without_engine();
    snapshot.processes.push(Process { pid: 77, ..snapshot.processes[0].clone() });
    let text = page(&snapshot, &EXPORTER, Format::Prometheus);
    assert!(!text.contains("pid="), "{text}");
    for (name, bytes) in [("engine", 34e6), ("metrics", 68e6)] {
        let line = format!(
            "regatta_process_resident_memory_bytes{{fleet=\"default\",name=\"{name}\"}} {bytes}\n"
        );
        assert_eq!(text.matches(&line).count(), 1, "{text}");
    }
    // The processor time of a process is already that of all with its name.
    assert!(
        text.contains(
            "regatta_process_cpu_seconds_total{fleet=\"default\",name=\"metrics\"} 12.5\n"
        ),
        "{text}"
    );
}

/// Tests the rules of OpenMetrics, by which Prometheus parses.
#[test]
fn the_page_in_open_metrics_has_the_same_samples() {
    let (snapshot, prometheus) = (testing::snapshot(), full_page());
    let text = page(&snapshot, &EXPORTER, Format::OpenMetrics);
    // The bounds of buckets are spelled differently: 0.00001 and 1e-05, 1 and 1.0.
    let sample = |line: &str| match line
        .split_once("le=\"")
        .and_then(|(start, rest)| Some((start, rest.split_once('"')?)))
    {
        Some((start, (bound, end))) => {
            format!("{start}{:?}{end}", bound.parse::<f64>().expect("a number"))
        }
        None => line.to_owned(),
    };
    let samples = |text: &str| -> Vec<_> {
        text.lines().filter(|line| !line.starts_with('#')).map(sample).collect()
    };
    assert_eq!(samples(&text), samples(&prometheus));
    for bound in ["1e-05", "2.5e-05", "0.0001", "0.25", "1.0", "10.0", "+Inf"] {
        assert!(text.contains(&format!("le=\"{bound}\"")), "{bound}");
    }
    assert!(text.ends_with("} 1\n# EOF\n") && text.matches("# EOF").count() == 1, "{text}");
    let kinds: Vec<_> = families(text.trim_end_matches("# EOF\n"))
        .into_iter()
        .map(|(name, _, kind)| (name, kind))
        .collect();
    for (name, kind) in &kinds {
        let ending = match *kind {
            "counter" => "_total",
            "info" => "_info",
            "histogram" | "summary" => "_count",
            _ => "",
        };
        assert!(
            !name.ends_with("_total") && text.contains(&format!("\n{name}{ending}{{")),
            "{name} is a {kind}"
        );
    }
    assert!(
        kinds.contains(&("regatta_ticks", "counter")) && kinds.contains(&("regatta_build", "info")),
        "{kinds:?}"
    );
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
    let dashboard =
        serde_json::from_str(include_str!("../../grafana-dashboard.json")).expect("valid JSON");
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
