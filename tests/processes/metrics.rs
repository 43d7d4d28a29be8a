//! `regatta plugin metrics` on a real engine: its page, its CSV file, and clients that misbehave.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;

use regatta_plugin::column::COLLISION;
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
        Self::start_with(regatta(), fleet, args)
    }

    fn start_with(mut command: Command, fleet: &FleetName, args: &[&str]) -> Self {
        command
            .args(["plugin", "metrics", "--fleet", &fleet.to_string(), "--listen", "127.0.0.1:0"])
            .args(args);
        let mut process = Process::start(&mut command);
        let mut line = String::new();
        let stderr = process.0.stderr.take().expect("piped");
        BufReader::new(stderr).read_line(&mut line).expect("a line");
        let address = line
            .split("http://")
            .nth(1)
            .and_then(|rest| rest.split('/').next())
            .expect(&line)
            .to_owned();
        Self { process, address }
    }

    /// Requests the page with further headers. Returns the head of the answer and its body.
    fn answer(&self, headers: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).expect("connected");
        let request =
            format!("GET /metrics HTTP/1.1\r\nConnection: close\r\n{}{headers}\r\n", own_token());
        stream.write_all(request.as_bytes()).expect("requested");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("answered");
        let body =
            answer.windows(4).position(|end| end == b"\r\n\r\n").expect("a head and a body") + 4;
        let head = String::from_utf8_lossy(&answer[..body]).to_lowercase();
        assert!(head.starts_with("http/1.1 200 ok"), "{head}");
        (head, answer.split_off(body))
    }

    /// Requests the page in the text format of Prometheus.
    fn page(&self) -> String {
        String::from_utf8(self.answer("").1).expect("text")
    }

    /// Returns the samples of the page whose name begins so, without their values.
    fn series(&self, name: &str) -> Vec<String> {
        let page = self.page();
        let series = page
            .lines()
            .filter(|line| line.starts_with(name))
            .filter_map(|line| line.rsplit_once(' '));
        series.map(|(series, _)| series.to_owned()).collect()
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

/// The header with the token of this user.
fn own_token() -> String {
    let token = regatta_kit::private::token().expect("a token");
    format!("Authorization: Bearer {token}\r\n")
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
    for state in ["idle", "driving", "waiting", "held", "faulted", "turning", "stalled", "broken"] {
        let labels = format!("state=\"{state}\"");
        assert_eq!(
            metrics.value("regatta_robots", &labels),
            status["robots_by_state"][state].as_f64(),
            "{state}"
        );
    }
    let ticks = metrics.value("regatta_frames_read_total", "").expect("read")
        + metrics.value("regatta_frames_skipped_total", "").expect("skipped");
    assert!(ticks <= status["tick"].as_f64().expect("a tick") + 3.0, "{ticks} frames");
    let engine = "name=\"engine\"";
    assert!(
        metrics.reaches("regatta_process_resident_memory_bytes", engine, |bytes| bytes > 1e6) < 1e9
    );
    metrics.reaches("regatta_process_cpu_seconds_total", engine, |seconds| seconds > 0.0);
    metrics
        .reaches("regatta_process_resident_memory_bytes", "name=\"metrics\"", |bytes| bytes > 1e6);
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
    assert_eq!(
        metrics.value("regatta_robots", "driving"),
        None,
        "a fleet that does not run has no robots"
    );
    let read = metrics.value("regatta_frames_read_total", "").expect("read");
    let _fleet = Fleet::restart(name, "thirty.yaml", &[]);
    metrics.reaches("regatta_frames_read_total", "", |frames| frames > read);
}

#[test]
fn the_page_shows_the_collisions_of_the_checker() {
    let fleet = Fleet::start("metrics-collisions", "thirty.yaml", &[]);
    let metrics = Metrics::start(&fleet.name, &[]);
    let participant = Participant::join(&fleet.name, "checker").expect("joined");
    let mut column = ColumnPublisher::open_on(&participant, COLLISION.name()).expect("a column");
    let mut contacts = ContactPublisher::open_on(&participant).expect("contacts");
    fleet.control(&["pause"]);
    let (run, tick) = eventually("a frame", || {
        let mut frames = fleet.subscriber();
        let frame = frames.latest().ok()??;
        Some((frame.run_id(), frame.tick()))
    });
    let levels = [0.0, 2.0, 2.0, 1.0];
    column.write(run, tick, 4, |values| values.copy_from_slice(&levels)).expect("published");
    let header = ContactHeader {
        run_id: run,
        tick,
        touching: 1,
        possible: 5,
        touching_ever: 9,
        ..Default::default()
    };
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
    let output = Process::start(regatta().args([
        "plugin",
        "metrics",
        "--listen",
        &first.address,
        "--fleet",
        name.as_str(),
    ]));
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
        for k in 0..300 {
            let Ok(mut stream) = TcpStream::connect(&metrics.address) else { continue };
            let start: &[u8] =
                [&b"GET /met"[..], b"\x16\x03\x01\x00\r\n\r\n", b"GET /metrics HTTP/1.1\r\n\r\n"]
                    [k % 3];
            // The connection may be closed already if the plugin has refused it.
            let _ = stream.write_all(start);
            clients.push(stream);
        }
        // Connections of hanging clients are closed, and the next client gets a page.
        eventually("a page", || {
            let mut stream = TcpStream::connect(&metrics.address).ok()?;
            stream
                .write_all(format!("GET /metrics HTTP/1.0\r\n{}\r\n", own_token()).as_bytes())
                .ok()?;
            let mut answer = String::new();
            stream.read_to_string(&mut answer).ok()?;
            answer.contains("regatta_up").then_some(())
        });
        drop(clients);
        assert!(metrics.process.interrupt().status.success());
    });
}

#[test]
fn scrapes_beside_idle_connections_are_all_answered() {
    let metrics = Metrics::start(&unique("metrics-idle"), &[]);
    let idle: Vec<_> =
        (0..400).map(|_| TcpStream::connect(&metrics.address).expect("connected")).collect();
    for _ in 0..20 {
        assert_eq!(metrics.value("regatta_up", ""), Some(0.0));
    }
    // A client that is still connected doesn't delay the end.
    assert!(metrics.process.interrupt().status.success());
    drop(idle);
}

#[test]
fn idle_connections_take_no_files_from_shared_memory() {
    let mut limited = Command::new("sh");
    // iceoryx2 opens its files without O_CLOEXEC, so the program inherits those of the readers in
    // the tests beside this one.
    limited.args(["-c", "ulimit -n 192; exec \"$0\" \"$@\""]).arg(regatta().get_program());
    let name = unique("metrics-few-files");
    let metrics = Metrics::start_with(limited, &name, &[]);
    let idle: Vec<_> =
        (0..300).map(|_| TcpStream::connect(&metrics.address).expect("connected")).collect();
    let _fleet = Fleet::restart(name, "thirty.yaml", &[]);
    metrics.reaches("regatta_up", "", |up| up == 1.0);
    metrics.reaches("regatta_frames_read_total", "", |frames| frames > 10.0);
    assert!(metrics.process.interrupt().status.success());
    drop(idle);
}

#[test]
fn the_format_and_the_encoding_are_those_that_the_client_accepts() {
    let metrics = Metrics::start(&unique("metrics-formats"), &[]);
    let (head, page) = metrics.answer("");
    assert!(head.contains("content-type: text/plain; version=0.0.4; charset=utf-8\r\n"), "{head}");
    assert!(!String::from_utf8_lossy(&page).contains("# EOF"));
    let accept = "Accept: application/openmetrics-text;version=1.0.0;q=0.5,\
        text/plain;version=0.0.4;q=0.2,*/*;q=0.1\r\n";
    let (head, page) = metrics.answer(accept);
    assert!(
        head.contains(
            "content-type: application/openmetrics-text; version=1.0.0; charset=utf-8\r\n"
        ),
        "{head}"
    );
    assert!(page.ends_with(b"# EOF\n"), "{}", String::from_utf8_lossy(&page));
    let (head, page) = metrics.answer("Accept-Encoding: gzip\r\n");
    assert!(head.contains("content-encoding: gzip\r\n"), "{head}");
    assert!(page.windows(2).any(|magic| magic == [0x1f, 0x8b]), "{head}");
    let build = metrics.series("regatta_build_info").join("");
    let contract = format!("contract=\"{}\"", regatta_plugin::frame::CONTRACT_VERSION);
    assert!(
        build.contains(concat!("version=\"", env!("CARGO_PKG_VERSION"), "\""))
            && build.contains(&contract),
        "{build}"
    );
}

#[test]
fn a_restarted_engine_continues_its_series() {
    let name = unique("metrics-series");
    let metrics = Metrics::start(&name, &[]);
    let start = || {
        let fleet = Fleet::restart(name.clone(), "thirty.yaml", &[]);
        let series = eventually("the engine's series", || {
            let series = metrics.series("regatta_process_");
            series.iter().any(|series| series.contains("name=\"engine\"")).then_some(series)
        });
        (
            fleet,
            series
                .into_iter()
                .filter(|series| series.contains("name=\"engine\""))
                .collect::<Vec<_>>(),
        )
    };
    let (fleet, first) = start();
    assert!(fleet.engine.interrupt().status.success());
    eventually("the series end with the engine", || {
        metrics
            .series("regatta_process_")
            .iter()
            .all(|series| !series.contains("engine"))
            .then_some(())
    });
    let (_fleet, second) = start();
    assert_eq!(first, second);
}

/// Returns a CSV file that has a row.
fn rows(path: &Path) -> Option<String> {
    fs::read_to_string(path).ok().filter(|text| text.lines().count() >= 2)
}

#[test]
fn a_rotated_csv_file_is_continued_in_a_new_one() {
    let fleet = Fleet::start("metrics-rotate", "thirty.yaml", &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let (path, old) = (folder.path().join("run.csv"), folder.path().join("run.csv.1"));
    let metrics = Metrics::start(&fleet.name, &["--csv", path.to_str().expect("a path")]);
    let before = eventually("a row", || rows(&path));
    // As logrotate does: once by moving the file away, once by copying and truncating it.
    fs::rename(&path, &old).expect("moved");
    metrics.process.signal(Signal::HUP);
    let after = eventually("a row in a new file", || rows(&path));
    assert!(fs::read_to_string(&old).expect("the old file").starts_with(&before));
    assert_eq!(after.lines().next(), before.lines().next(), "it has the same header");
    fs::OpenOptions::new().write(true).truncate(true).open(&path).expect("truncated");
    let truncated = eventually("a row in the truncated file", || rows(&path));
    assert_eq!(truncated.lines().next(), before.lines().next(), "it has the same header, too");
    assert!(!truncated.contains('\0'));
    assert!(metrics.process.interrupt().status.success());
}

#[test]
fn a_file_of_something_else_is_refused_by_every_plugin_that_appends_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("orders.csv");
    fs::write(&path, "order,robot\n1,2\n").expect("written");
    let path = path.to_str().expect("a path");
    for args in [["metrics", "--csv", path], ["collision", "--log", path]] {
        let name = unique("foreign-file");
        let mut command = regatta();
        command.arg("plugin").args(args).args(["--fleet", name.as_str()]);
        if args[0] == "metrics" {
            command.args(["--listen", "127.0.0.1:0"]);
        }
        let output = Process::start(&mut command).finish();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.lines().count() == 1, "{args:?}: {message}");
        assert!(
            message.contains(path) && message.contains("choose another file"),
            "{args:?}: {message}"
        );
    }
    assert_eq!(fs::read_to_string(path).expect("a file"), "order,robot\n1,2\n");
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
    let runs: Vec<_> =
        lines.clone().filter_map(|row| row.split(',').nth(column("run_id"))).collect();
    let run = fleet.status()["run_id"].as_str().expect("an id").to_owned();
    assert!(
        runs.iter().all(|other| *other == run),
        "the id is spelled as in the status, {run}: {runs:?}"
    );
    let ticks: Vec<u64> =
        lines.filter_map(|row| row.split(',').nth(column("tick"))?.parse().ok()).collect();
    assert!(ticks.len() >= 2 && ticks.is_sorted(), "{text}");
    assert!(
        names.contains(&"tick_cost_max_seconds") && names.contains(&"driven_metres"),
        "{names:?}"
    );
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
