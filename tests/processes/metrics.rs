//! `regatta plugin metrics` on a real engine: its page, its CSV file, and clients that misbehave.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;

use regatta_plugin::contact::ContactHeader;
use regatta_plugin::{ColumnPublisher, ContactPublisher, FleetName, Participant};
use rustix::process::Signal;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::readers::costs_no_late_tick;

/// The metrics plugin, which listens on a free port.
struct Metrics {
    process: Process,
    address: String,
}

impl Metrics {
    fn start(fleet: &FleetName, args: &[&str]) -> Self {
        let mut command = regatta();
        command.args(["plugin", "metrics", "--fleet", &fleet.to_string(), "--listen", "127.0.0.1:0"]).args(args);
        let mut process = Process::start(&mut command);
        let mut line = String::new();
        let stderr = process.0.stderr.take().expect("piped");
        BufReader::new(stderr).read_line(&mut line).expect("a line");
        let address = line.split("http://").nth(1).and_then(|rest| rest.split('/').next()).expect(&line).to_owned();
        Self { process, address }
    }

    /// Requests the page as Prometheus does.
    fn page(&self) -> String {
        let mut stream = TcpStream::connect(&self.address).expect("connected");
        stream.write_all(b"GET /metrics HTTP/1.1\r\nHost: test\r\n\r\n").expect("requested");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("answered");
        let (head, page) = answer.split_once("\r\n\r\n").expect("a head and a page");
        assert!(head.starts_with("HTTP/1.1 200 OK"), "{head}");
        page.to_owned()
    }

    /// Returns a value of the page by its name and its labels other than `fleet`.
    fn value(&self, name: &str, labels: &str) -> Option<f64> {
        let page = self.page();
        let line = page.lines().find(|line| {
            let labelled = line.strip_prefix(name).and_then(|rest| rest.strip_prefix('{'));
            labelled.is_some_and(|rest| rest.contains(labels))
        });
        line?.rsplit(' ').next()?.parse().ok()
    }

    /// Waits until a value fulfils a condition, and returns it.
    fn reaches(&self, name: &str, labels: &str, condition: impl Fn(f64) -> bool) -> f64 {
        eventually(name, || self.value(name, labels).filter(|&value| condition(value)))
    }
}

#[test]
fn the_page_agrees_with_the_status() {
    let fleet = Fleet::start("metrics", "thirty.yaml", &[]);
    let metrics = Metrics::start(&fleet.name, &[]);
    metrics.reaches("regatta_tick_jitter_seconds_count", "", |count| count > 50.0);
    assert!(metrics.value("regatta_driven_metres_total", "").is_some_and(|metres| metres > 0.0));
    metrics.reaches("regatta_real_time_ratio", "", |ratio| (0.2..5.0).contains(&ratio));
    fleet.control(&["pause"]);
    metrics.reaches("regatta_paused", "", |paused| paused == 1.0);

    let status = fleet.status();
    metrics.reaches("regatta_ticks_total", "", |tick| Some(tick) == status["tick"].as_f64());
    assert_eq!(metrics.value("regatta_late_ticks_total", ""), status["late_ticks"].as_f64());
    let simulated = metrics.value("regatta_simulated_seconds_total", "").expect("a time");
    assert!((simulated - status["sim_time_secs"].as_f64().expect("a time")).abs() < 1e-6);
    for state in ["idle", "driving", "waiting", "held", "faulted"] {
        let labels = format!("state=\"{state}\"");
        assert_eq!(metrics.value("regatta_robots", &labels), status["robots_by_state"][state].as_f64(), "{state}");
    }
    let ticks = metrics.value("regatta_frames_read_total", "").expect("read")
        + metrics.value("regatta_frames_skipped_total", "").expect("skipped");
    assert!(ticks <= status["tick"].as_f64().expect("a tick") + 3.0, "{ticks} frames");
    let engine = format!("name=\"engine\",pid=\"{}\"", status["pid"]);
    assert!(metrics.reaches("regatta_process_resident_memory_bytes", &engine, |bytes| bytes > 1e6) < 1e9);
    metrics.reaches("regatta_process_cpu_seconds_total", &engine, |seconds| seconds > 0.0);
    metrics.reaches("regatta_process_resident_memory_bytes", "name=\"metrics\"", |bytes| bytes > 1e6);
    assert!(metrics.process.interrupt().status.success());
}

#[test]
fn the_plugin_follows_engines_that_end_and_start() {
    let name = unique("metrics-restart");
    let metrics = Metrics::start(&name, &[]);
    assert_eq!(metrics.value("regatta_up", ""), Some(0.0));
    let fleet = Fleet::restart(name.clone(), "thirty.yaml", &[]);
    metrics.reaches("regatta_up", "", |up| up == 1.0);
    fleet.engine.signal(Signal::KILL);
    fleet.engine.finish();
    metrics.reaches("regatta_up", "", |up| up == 0.0);
    assert_eq!(metrics.value("regatta_robots", "driving"), None, "a fleet that does not run has no robots");
    let read = metrics.value("regatta_frames_read_total", "").expect("read");
    let _fleet = Fleet::restart(name, "thirty.yaml", &[]);
    metrics.reaches("regatta_frames_read_total", "", |frames| frames > read);
}

#[test]
fn the_page_shows_the_collisions_of_the_checker() {
    let fleet = Fleet::start("metrics-collisions", "thirty.yaml", &[]);
    let metrics = Metrics::start(&fleet.name, &[]);
    let participant = Participant::join(&fleet.name, "checker").expect("joined");
    let mut column = ColumnPublisher::open_on(&participant, "collision").expect("a column");
    let mut contacts = ContactPublisher::open_on(&participant).expect("contacts");
    fleet.control(&["pause"]);
    let (run, tick) = eventually("a frame", || {
        let mut frames = fleet.subscriber();
        let frame = frames.latest().ok()??;
        Some((frame.run_id(), frame.tick()))
    });
    let levels = [0.0, 2.0, 2.0, 1.0];
    column.write(run, tick, 4, |values| values.copy_from_slice(&levels)).expect("published");
    let header = ContactHeader { run_id: run, tick, touching: 1, possible: 5, touching_ever: 9, ..Default::default() };
    contacts.publish(&header, &[]).expect("published");
    metrics.reaches("regatta_collision_robots", "level=\"touching\"", |robots| robots == 2.0);
    metrics.reaches("regatta_collision_pairs", "level=\"possible\"", |pairs| pairs == 5.0);
    assert_eq!(metrics.value("regatta_collision_robots", "level=\"possible\""), Some(1.0));
    assert_eq!(metrics.value("regatta_collisions_total", "level=\"touching\""), Some(9.0));
}

#[test]
fn a_port_in_use_is_reported_in_one_line() {
    let name = unique("metrics-port");
    let first = Metrics::start(&name, &[]);
    let output =
        Process::start(regatta().args(["plugin", "metrics", "--listen", &first.address, "--fleet", name.as_str()]));
    let output = output.finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.lines().count() == 1, "{message}");
    assert!(message.contains(&first.address) && message.contains("--listen"), "{message}");
}

#[test]
fn many_hanging_and_invalid_clients_stop_neither_the_plugin_nor_the_engine() {
    costs_no_late_tick("metrics-crowd", |fleet| {
        let metrics = Metrics::start(&fleet.name, &[]);
        let mut clients = Vec::new();
        for k in 0..200 {
            let Ok(mut stream) = TcpStream::connect(&metrics.address) else { continue };
            let start: &[u8] = [&b"GET /met"[..], b"\x16\x03\x01\x00\r\n\r\n", b"GET /metrics HTTP/1.1\r\n\r\n"][k % 3];
            // The connection may be closed already if the plugin has refused it.
            let _ = stream.write_all(start);
            clients.push(stream);
        }
        // Connections of hanging clients are closed, and the next client gets a page.
        eventually("a page", || {
            let mut stream = TcpStream::connect(&metrics.address).ok()?;
            stream.write_all(b"GET /metrics HTTP/1.1\r\n\r\n").ok()?;
            let mut answer = String::new();
            stream.read_to_string(&mut answer).ok()?;
            answer.contains("regatta_up").then_some(())
        });
        drop(clients);
        assert!(metrics.process.interrupt().status.success());
    });
}

#[test]
fn a_stopped_and_killed_plugin_costs_no_late_tick() {
    costs_no_late_tick("metrics-killed", |fleet| {
        let metrics = Metrics::start(&fleet.name, &[]);
        metrics.reaches("regatta_up", "", |up| up == 1.0);
        metrics.process.signal(Signal::STOP);
        fleet.let_ticks_pass(60);
        let tick = fleet.tick();
        metrics.process.signal(Signal::CONT);
        metrics.reaches("regatta_ticks_total", "", |now| now > tick as f64);
        metrics.process.signal(Signal::KILL);
    });
}

#[test]
fn the_csv_file_gets_a_row_per_second() {
    let fleet = Fleet::start("metrics-csv", "thirty.yaml", &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.csv");
    let metrics = Metrics::start(&fleet.name, &["--csv", path.to_str().expect("a path")]);
    metrics.reaches("regatta_csv_rows_written_total", "", |rows| rows >= 2.0);
    assert!(metrics.process.interrupt().status.success());
    let text = fs::read_to_string(&path).expect("a file");
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| names.iter().position(|other| *other == name).expect(name);
    let ticks: Vec<u64> = lines.filter_map(|row| row.split(',').nth(column("tick"))?.parse().ok()).collect();
    assert!(ticks.len() >= 2 && ticks.is_sorted(), "{text}");
    assert!(names.contains(&"tick_cost_max_seconds") && names.contains(&"driven_metres"), "{names:?}");
}

#[test]
fn on_a_full_disk_only_rows_are_lost() {
    let fleet = Fleet::start("metrics-full", "thirty.yaml", &[]);
    if Path::new("/dev/full").exists() {
        let metrics = Metrics::start(&fleet.name, &["--csv", "/dev/full"]);
        metrics.reaches("regatta_csv_rows_lost_total", "", |rows| rows >= 2.0);
        assert_eq!(metrics.value("regatta_csv_rows_written_total", ""), Some(0.0));
        assert!(metrics.process.interrupt().status.success());
    }
}
