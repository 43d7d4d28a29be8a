//! The dissertation's UDP protocol: an engine's fleet out of one socket and into a second fleet,
//! answers, and other programs at either end, here plain sockets of this test.

use std::io::{BufRead, BufReader, Read};
use std::net::{SocketAddr, UdpSocket};
use std::process::ChildStderr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use regatta_plugin::column::{COLLISION, TYPE};
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::{ColumnReader, Frame, Participant, WorldReader};
use rustix::process::Signal;
use serde_json::Value;

use crate::fleet::{Fleet, Process, TIMEOUT, eventually, regatta, unique};
use crate::readers::costs_no_late_tick;

/// A plugin that has said where it listens.
struct Listener {
    process: Process,
    address: SocketAddr,
    stderr: BufReader<ChildStderr>,
}

impl Listener {
    fn start(args: &[&str]) -> Self {
        let mut process = Process::start(regatta().arg("plugin").args(args));
        let mut stderr = BufReader::new(process.0.stderr.take().expect("piped"));
        let mut line = String::new();
        while !line.contains("listening") {
            line.clear();
            assert_ne!(stderr.read_line(&mut line).expect("readable"), 0, "{args:?} ended");
        }
        let address =
            line.split(' ').find_map(|word| word.trim_end().parse().ok()).expect("an address");
        Self { process, address, stderr }
    }

    /// Ctrl-C; its closing figures and what it said.
    fn interrupt(mut self) -> (Value, String) {
        let output = self.process.interrupt();
        let mut said = String::new();
        self.stderr.read_to_string(&mut said).expect("readable");
        assert!(output.status.success(), "{said}");
        (serde_json::from_slice(&output.stdout).expect("figures"), said)
    }
}

/// A fleet made of what comes in at a port of its own.
struct Second {
    fleet: Fleet,
    address: SocketAddr,
    stderr: BufReader<ChildStderr>,
}

impl Second {
    fn start(test: &str, args: &[&str]) -> Self {
        let name = unique(test);
        let to = ["udp-source", "--listen", "0", "--json", "--fleet", name.as_str()];
        let Listener { process, address, stderr } = Listener::start(&[&to, args].concat());
        Self { fleet: Fleet { name, engine: process }, address, stderr }
    }

    fn interrupt(self) -> (Value, String) {
        Listener { process: self.fleet.engine, address: self.address, stderr: self.stderr }
            .interrupt()
    }
}

/// A socket of this test's own, as the dissertation's programs have.
fn socket() -> (UdpSocket, String) {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.set_read_timeout(Some(TIMEOUT)).expect("set");
    let address = socket.local_addr().expect("an address").to_string();
    (socket, address)
}

/// A port that nobody listens on at the moment.
fn free_port() -> String {
    socket().1.split(':').nth(1).expect("a port").to_owned()
}

fn udp(fleet: &Fleet, to: &str, args: &[&str]) -> Process {
    let fixed = ["plugin", "udp", "--fleet", fleet.name.as_str(), "--to", to, "--json"];
    Process::start(regatta().args(fixed).args(args))
}

fn next_text(socket: &UdpSocket) -> String {
    let mut buffer = vec![0; 65_536];
    let length = socket.recv(&mut buffer).expect("a datagram");
    String::from_utf8(buffer[..length].to_vec()).expect("text")
}

/// As another program would take a line apart.
fn fields(line: &str, separator: char) -> [f64; 4] {
    let fields: Vec<f64> =
        line.split(separator).map(|field| field.parse().expect("a number")).collect();
    fields.try_into().unwrap_or_else(|_| panic!("four fields: {line}"))
}

/// Whether two frames hold the same poses, as far as lines with three decimals can tell.
fn agree(ours: &Frame<'_>, theirs: &Frame<'_>) -> bool {
    const TOLERANCE: f32 = 0.000_51;
    ours.len() == theirs.len()
        && (0..ours.len()).all(|robot| {
            let turn = (ours.theta()[robot] - theirs.theta()[robot]).abs();
            (ours.x()[robot] - theirs.x()[robot]).abs() <= TOLERANCE
                && (ours.y()[robot] - theirs.y()[robot]).abs() <= TOLERANCE
                && turn.min(core::f32::consts::TAU - turn) <= TOLERANCE.to_radians()
        })
}

#[test]
fn a_collision_checker_waits_for_the_robots_of_a_source_without_a_word() {
    let second = Second::start("udp-checked", &[]);
    let checker = second.fleet.plugin("collision");
    let participant = Participant::join(&second.fleet.name, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, COLLISION.name()).expect("opened");
    let robots = eventually("a column", || {
        column.latest().expect("readable").map(|column| column.values.len())
    });
    assert_eq!(robots, 0);
    let output = checker.interrupt();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !said.contains("'type'"), "{said}");
    second.interrupt();
}

#[test]
fn options_that_make_no_sense_are_refused_in_one_line() {
    for (args, wanted) in [
        (&["udp", "--to", "127.0.0.1:0"][..], "port 0"),
        (&["udp", "--to", "127.0.0.1:9001", "--echo-deadline", "2"], "--listen"),
        (&["udp-source", "--listen", "0", "--max-datagram", "0"], "give a number from 1"),
        (&["collision", "--margin", "-1"], "give 0 to 100 metres"),
        (&["collision", "--horizon", "-1"], "give 0 (no prediction) to 60 seconds"),
        (&["record", "--every", "-1"], "--every"),
    ] {
        let fleet = unique("udp-options").to_string();
        let output = regatta()
            .arg("plugin")
            .args(args)
            .args(["--fleet", &fleet])
            .output()
            .expect("regatta starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && said.contains(wanted) && said.lines().count() == 1,
            "{args:?}: {said}"
        );
    }
}

#[test]
fn a_second_fleet_has_the_poses_of_the_first() {
    let first = Fleet::start("udp-first", "thirty.yaml", &[]);
    let second = Second::start("udp-second", &["--robot-length", "1.2", "--robot-width", "0.8"]);
    let _udp = udp(&first, &second.address.to_string(), &["--rate", "all"]);
    first.let_ticks_pass(50);
    first.control(&["pause"]);
    let (mut ours, mut theirs) = (first.subscriber(), second.fleet.subscriber());
    // A datagram may get lost: each step sends them all again.
    eventually("the poses agree", || {
        first.control(&["step"]);
        std::thread::sleep(Duration::from_millis(100));
        let (ours, theirs) =
            (ours.latest().expect("readable")?, theirs.latest().expect("readable")?);
        agree(&ours, &theirs).then_some(())
    });
    let frame = theirs.current().expect("readable").expect("a frame");
    assert!(frame.edge().iter().all(|&edge| edge == NO_EDGE));
    let mut worlds = WorldReader::open(&second.fleet.name).expect("opened");
    let (edges, kind) = eventually("its world", || {
        worlds
            .latest()
            .expect("readable")
            .map(|world| (world.edges().len(), world.robot_types()[0]))
    });
    assert_eq!((edges, kind.length, kind.width), (0, 1.2, 0.8));
    let mut types = ColumnReader::open_on(theirs.participant(), TYPE.name()).expect("a name");
    let types = eventually("types", || {
        types.latest().expect("readable").map(|column| column.values.to_vec())
    });
    assert_eq!(types, [0.0; 30]);
}

#[test]
fn only_the_wanted_robots_are_sent_and_the_others_are_absent() {
    let first = Fleet::start("udp-some", "thirty.yaml", &[]);
    let second = Second::start("udp-some-of", &["--radians"]);
    let _udp = udp(&first, &second.address.to_string(), &["--robots", "10..20", "--radians"]);
    let mut theirs = second.fleet.subscriber();
    let there = eventually("twenty rows", || {
        let frame = theirs.latest().expect("readable").filter(|frame| frame.len() == 20)?;
        Some((0..20).map(|robot| frame.state_of(robot) != RobotState::Absent).collect::<Vec<_>>())
    });
    assert_eq!(there, [[false; 10], [true; 10]].concat());
    let status = second.fleet.status();
    assert_eq!(status["robots"], 10);
}

#[test]
fn answers_with_the_offset_agree_and_without_it_differ() {
    let first = Fleet::start("udp-echo", "thirty.yaml", &[]);
    for (offset, agrees) in [("10,-5.25", true), ("0,0", false)] {
        let port = free_port();
        let second = Second::start(
            "udp-echo-of",
            &["--echo-to", &format!("127.0.0.1:{port}"), "--offset=10,-5.25"],
        );
        let to = second.address.to_string();
        // A busy machine may take its time: that is not what this test looks at.
        let echo = ["--listen", &port, "--echo-offset", offset, "--echo-deadline", "60"];
        let sender = udp(&first, &to, &echo);
        let mut theirs = second.fleet.subscriber();
        eventually("poses", || {
            theirs.latest().expect("readable").filter(|frame| frame.len() == 30).map(|_| ())
        });
        first.let_ticks_pass(50);
        let output = sender.interrupt();
        let figures: Value = serde_json::from_slice(&output.stdout).expect("figures");
        let count = |what: &str| figures["echo"][what].as_u64().expect("a count");
        assert_eq!(count("unknown"), 0, "{figures}");
        assert_eq!((count("differing") == 0, count("answered") > 0), (agrees, agrees), "{figures}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(said.contains("30 robots: 0, 1, 2, 3, 4, …"), !agrees, "{said}");
        second.interrupt();
    }
}

#[test]
fn a_visualiser_of_somebody_else_is_served_and_checked() {
    let first = Fleet::start("udp-viewer", "thirty.yaml", &[]);
    let (viewer, viewer_address) = socket();
    let sender = ["udp", "--fleet", first.name.as_str(), "--to", &viewer_address];
    let options = ["--listen", "0", "--mtu", "300", "--echo-deadline", "60", "--json"];
    let sender = Listener::start(&[&sender[..], &options].concat());
    let mut answered = 0;
    while answered < 600 {
        let text = next_text(&viewer);
        assert!(text.len() <= 300 && text.ends_with('\n'), "{text}");
        let mut answer = String::new();
        for line in text.lines() {
            let [id, x, y, theta] = fields(line, ',');
            assert!((0.0..30.0).contains(&id) && (-180.0..=180.0).contains(&theta), "{line}");
            // Robot 7 is drawn in the wrong place.
            answer += &format!("{id} {} {y} {theta}\n", if id == 7.0 { x + 0.01 } else { x });
            answered += 1;
        }
        viewer.send_to(answer.as_bytes(), sender.address).expect("sent");
    }
    let (figures, said) = sender.interrupt();
    let count = |what: &str| figures["echo"][what].as_u64().expect("a count");
    assert!(count("answered") > 0 && count("unknown") == 0, "{figures}");
    assert!(count("differing") > 0 && said.contains("differing (robot 7)"), "{said}");
}

#[test]
fn a_program_of_somebody_else_makes_a_fleet_and_gets_answers() {
    let (program, program_address) = socket();
    let second =
        Second::start("udp-program", &["--echo-to", &program_address, "--offset", "1.5,-0.25"]);
    program.send_to(b"2,1.0,2,90\r\n0,-7.125,1e1,-180\n", second.address).expect("sent");
    assert_eq!(next_text(&program), "2 2.500 1.750 90.000\n0 -5.625 9.750 -180.000\n");
    let mut frames = second.fleet.subscriber();
    eventually("its poses", || {
        let frame = frames.latest().expect("readable").filter(|frame| frame.len() == 3)?;
        let pose = |robot: usize| [frame.x()[robot], frame.y()[robot], frame.theta()[robot]];
        assert_eq!(pose(2), [2.5, 1.75, core::f32::consts::FRAC_PI_2]);
        assert_eq!(pose(0), [-5.625, 9.75, core::f32::consts::PI]);
        assert_eq!(frame.state_of(1), RobotState::Absent);
        Some(())
    });
}

#[test]
fn what_is_wrong_is_counted_and_ignored() {
    let (program, _) = socket();
    let second = Second::start("udp-wrong", &["--max-robots", "100", "--max-datagram", "500"]);
    let send = |text: &str| {
        program.send_to(text.as_bytes(), second.address).expect("sent");
    };
    send("nonsense\n1,2,3\n1,2,3,4,5\n1 2 3 4\n\u{0}\u{0}");
    send("-1,1,1,1\n100,1,1,1\n99999999999999999999,1,1,1");
    send("3,nan,1,1\n3,1,inf,1\n3,1,1,1e99");
    send(&"4,1,1,1\n".repeat(100));
    for _ in 0..200 {
        send(&"x".repeat(400));
    }
    send("5,8,9,0");
    let mut frames = second.fleet.subscriber();
    eventually("the good line", || {
        let frame = frames.latest().expect("readable").filter(|frame| frame.len() == 6)?;
        assert_eq!((frame.x()[5], frame.state_of(4)), (8.0, RobotState::Absent));
        Some(())
    });
    let (figures, said) = second.interrupt();
    let counts = [
        "malformed",
        "negative_ids",
        "ids_too_large",
        "not_finite",
        "oversized_datagrams",
        "lines",
    ];
    let counts = counts.map(|what| figures[what].as_u64().expect("a count"));
    assert_eq!(counts, [205, 1, 2, 3, 1, 1], "{said}");
    assert!(said.contains("205 malformed lines"), "{said}");
}

#[test]
fn it_pauses_and_resumes_and_refuses_what_it_cannot_do() {
    let (program, _) = socket();
    let second = Second::start("udp-control", &[]);
    program.send_to(b"0,1,2,3\n", second.address).expect("sent");
    eventually("the robot", || (second.fleet.status()["robots"] == 1).then_some(()));
    second.fleet.control(&["pause"]);
    let status = second.fleet.status();
    assert_eq!(status["clock"], "paused");
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(second.fleet.status()["tick"], status["tick"], "no tick while paused");
    let name = second.fleet.name.as_str();
    for refused in [["step", "3"], ["speed", "2"], ["robots", "5"]] {
        let output =
            regatta().args(refused).args(["--fleet", name]).output().expect("regatta starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && message.contains("the sender of the poses"),
            "{message}"
        );
    }
    second.fleet.control(&["resume"]);
    second.fleet.let_ticks_pass(5);

    let output =
        Process::start(regatta().args(["plugin", "udp-source", "--listen", "0", "--fleet", name]))
            .finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("already running"), "{message}");
}

#[test]
fn killed_and_started_again_the_source_goes_on_under_the_same_name() {
    let (program, _) = socket();
    let second = Second::start("udp-restart", &[]);
    let (name, address) = (second.fleet.name.clone(), second.address.to_string());
    second.fleet.engine.signal(Signal::KILL);
    drop(second);
    let again = Listener::start(&["udp-source", "--listen", &address, "--fleet", name.as_str()]);
    let again = Fleet { name, engine: again.process };
    let mut frames = again.subscriber();
    eventually("a robot of the second life", || {
        program.send_to(b"0,1,2,3\n", &address).expect("sent");
        frames.latest().expect("readable").filter(|frame| frame.len() == 1).map(|_| ())
    });
}

#[test]
fn a_killed_sender_costs_the_engine_nothing() {
    let (viewer, address) = socket();
    costs_no_late_tick("udp-killed", |fleet| {
        let sender = udp(fleet, &address, &["--rate", "all"]);
        next_text(&viewer);
        fleet.let_ticks_pass(10);
        sender.signal(Signal::KILL);
    });
}

#[test]
fn mistakes_of_the_command_line_are_one_line() {
    let name = unique("udp-mistakes").to_string();
    for (args, wanted) in [
        (&["udp"][..], "--to"),
        (&["udp", "--to", "nonsense"], "'nonsense'"),
        (&["udp", "--to", "127.0.0.1:9", "--mtu", "100"], "200 to 65507"),
        (&["udp", "--to", "127.0.0.1:9", "--robots", "5"], "A..B"),
        (&["udp", "--to", "127.0.0.1:9", "--decimals", "0"], "1 to 9"),
        (
            &["udp", "--to", "127.0.0.1:9", "--listen", "no.such.host.invalid:1"],
            "no.such.host.invalid",
        ),
        (&["udp-source"], "--listen"),
        (&["udp-source", "--listen", "nonsense"], "'nonsense'"),
        (&["udp-source", "--listen", "0", "--rate", "0"], "0.1 to 1000"),
        (&["udp-source", "--listen", "0", "--robot-length", "1"], "--robot-width"),
        (&["udp-source", "--listen", "0", "--max-robots", "0"], "--max-robots"),
    ] {
        let output =
            Process::start(regatta().arg("plugin").args(args).args(["--fleet", &name])).finish();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(wanted), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// Does something at the end, however it comes.
struct OnDrop<F: Fn()>(F);

impl<F: Fn()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

#[test]
fn a_flood_of_nonsense_takes_neither_time_nor_memory() {
    let (program, _) = socket();
    let second = Second::start("udp-flood", &["--max-robots", "1000"]);
    let before = second.fleet.status()["resident_bytes"].as_u64().expect("a size");
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let nonsense = "-1,2,3,4\n5000000,1,2,3\nnan,nan,nan,nan\n,,,,,,,,,\n".repeat(250);
            while !over.load(Ordering::Relaxed) {
                program.send_to(nonsense.as_bytes(), second.address).expect("sent");
                // A million lines a second are enough: other tests want the processor too.
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let _end = OnDrop(|| over.store(true, Ordering::Relaxed));
        second.fleet.let_ticks_pass(50);
        let mut frames = second.fleet.subscriber();
        eventually("a good line", || {
            let (program, _) = socket();
            program.send_to(b"7,1,2,3\n", second.address).expect("sent");
            frames.latest().expect("readable").filter(|frame| frame.len() == 8).map(|_| ())
        });
    });
    let after = second.fleet.status()["resident_bytes"].as_u64().expect("a size");
    assert!(after < before + (64 << 20), "{before} bytes have become {after}");
    let (figures, said) = second.interrupt();
    assert!(figures["malformed"].as_u64() > Some(1_000), "{figures}");
    // The first is that it listens; a line a second, whatever comes.
    let seconds = figures["wall_secs"].as_f64().expect("a time");
    assert!((said.lines().count() as f64) < seconds + 3.0, "{seconds} s: {said}");
}
