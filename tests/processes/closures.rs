//! Closed edges on real engines: nobody enters them, with or without a fleet manager, and late
//! readers know them.

use std::path::Path;
use std::process::Output;
use std::time::Duration;

use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::frame::NO_EDGE;
use regatta_plugin::{ClosureReader, Control, FleetName, Participant, Subscriber, WorldReader};

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};
use crate::record::{file, recorder};

fn command(fleet: &Fleet, arguments: &[&str]) -> Output {
    let mut command = regatta();
    command.arg("command").args(arguments).args(["--fleet", &fleet.name.to_string()]);
    command.output().expect("the program starts")
}

fn accepted(fleet: &Fleet, arguments: &[&str]) {
    let output = command(fleet, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "accepted");
}

/// Reads the closed edges of a fleet as one who joins now.
fn closed(fleet: &FleetName) -> Vec<ClosedEdge> {
    let participant = Participant::join(fleet, "late").expect("joined");
    let mut closures = ClosureReader::open_on(&participant).expect("a reader");
    let mut frames = Subscriber::open_on(&participant).expect("a reader");
    eventually("the closed edges", || {
        let run = frames.latest().expect("readable")?.run_id();
        closures.take().expect("readable").then(|| closures.closed(run).to_vec())
    })
}

/// The most driven edges: their indices and ids.
fn busy_edges(fleet: &Fleet, most: usize) -> Vec<(u32, u32)> {
    let mut frames = fleet.subscriber();
    let mut worlds = eventually("a world", || WorldReader::open(&fleet.name).ok());
    let ids: Vec<u32> = eventually("a world", || {
        let world = worlds.latest().expect("readable")?;
        Some(world.edges().iter().map(|edge| edge.id).collect())
    });
    let mut robots = vec![0_u32; ids.len()];
    for _ in 0..200 {
        let frame = eventually("a frame", || {
            frames.latest().expect("readable").map(|frame| frame.edge().to_vec())
        });
        frame
            .into_iter()
            .filter(|edge| *edge != NO_EDGE)
            .for_each(|edge| robots[edge as usize] += 1);
    }
    let mut edges: Vec<u32> = (0..ids.len() as u32).collect();
    edges.sort_by_key(|edge| std::cmp::Reverse(robots[*edge as usize]));
    edges.into_iter().take(most).map(|edge| (edge, ids[edge as usize])).collect()
}

/// Watches a fleet for some ticks. Returns how many robots entered another edge, and how many one
/// of `watched`.
fn entries(fleet: &Fleet, ticks: u64, watched: &[(u32, u32)]) -> [usize; 2] {
    let mut frames = fleet.subscriber();
    let mut before: Vec<u32> = Vec::new();
    let (from, mut entries) = (fleet.tick(), [0; 2]);
    loop {
        let (tick, now) = eventually("a frame", || {
            frames.latest().expect("readable").map(|frame| (frame.tick(), frame.edge().to_vec()))
        });
        for (now, _) in now.iter().zip(&before).filter(|(now, before)| now != before) {
            entries[usize::from(watched.iter().any(|(edge, _)| edge == now))] += 1;
        }
        before = now;
        if tick > from + ticks {
            return entries;
        }
    }
}

#[test]
fn walkers_enter_a_closed_edge_only_after_it_is_opened_again() {
    let fleet =
        Fleet::start("closures", "warehouse-1000.yaml", &["--robots", "200", "--speed", "5"]);
    let edges = busy_edges(&fleet, 3);
    for (_, id) in &edges {
        accepted(&fleet, &["close", &id.to_string()]);
    }
    let mut ids: Vec<u32> = edges.iter().map(|(_, id)| *id).collect();
    ids.sort_unstable();
    assert_eq!(closed(&fleet.name).iter().map(|closed| closed.edge).collect::<Vec<_>>(), ids);
    let [others, none] = entries(&fleet, 3_000, &edges);
    assert!(others > 100 && none == 0, "{others} entered other edges, {none} closed ones");
    let refused = command(&fleet, &["assign", "0", "--edges", &ids[0].to_string()]);
    assert!(!refused.status.success());
    let unknown =
        String::from_utf8_lossy(&command(&fleet, &["close", "999999"]).stderr).into_owned();
    assert!(unknown.contains("there is no edge 999999"), "{unknown}");
    for (_, id) in &edges {
        accepted(&fleet, &["open", &id.to_string()]);
    }
    assert_eq!(closed(&fleet.name), []);
    let [_, again] = entries(&fleet, 3_000, &edges);
    assert!(again > 0, "they are driven again");
    assert!(fleet.engine.interrupt().status.success());
}

/// Robots that wait for commands, and a load that keeps them busy.
fn managed(folder: &Path) -> (Fleet, Process) {
    let scenario = format!(
        "graph: {}\nrate: 50\npublish_rate: 10\nseed: 3\n\
         robot_types:\n- {{name: amr, length: 0.9, width: 0.6}}\n\
         robots:\n- {{count: 60, routes: none}}\n",
        graphs("warehouse.yaml").display()
    );
    std::fs::write(folder.join("scenario.yaml"), scenario).expect("written");
    std::fs::write(folder.join("load.yaml"), "load: {seed: 5, endless: robots, dwell: 2}\n")
        .expect("written");
    let path = folder.join("scenario.yaml").display().to_string();
    let fleet = Fleet::restart(unique("closures-managed"), &path, &["--speed", "5"]);
    let manager = manager(&fleet, folder);
    (fleet, manager)
}

fn manager(fleet: &Fleet, folder: &Path) -> Process {
    let mut command = regatta();
    command.args([
        "plugin",
        "fleet-manager",
        "--summary",
        "--fleet",
        &fleet.name.to_string(),
        "--load",
    ]);
    Process::start(command.arg(folder.join("load.yaml")))
}

#[test]
fn a_fleet_manager_goes_round_closed_edges_also_one_that_comes_later() {
    let folder = tempfile::tempdir().expect("a folder");
    let (fleet, first) = managed(folder.path());
    eventually("robots drive", || (entries(&fleet, 200, &[])[0] > 60).then_some(()));
    let edges = busy_edges(&fleet, 2);
    for (_, id) in &edges {
        accepted(&fleet, &["close", &id.to_string()]);
    }
    let [others, none] = entries(&fleet, 3_000, &edges);
    assert!(others > 100 && none == 0, "{others} entered other edges, {none} closed ones");
    assert!(first.interrupt().status.success());
    let second = manager(&fleet, folder.path());
    eventually("robots drive", || (entries(&fleet, 200, &[])[0] > 60).then_some(()));
    let [others, none] = entries(&fleet, 2_000, &edges);
    assert!(
        others > 100 && none == 0,
        "with the second manager: {others} entered other edges, {none} closed ones"
    );
    assert!(second.interrupt().status.success() && fleet.engine.interrupt().status.success());
}

#[test]
fn a_replay_shows_which_edges_were_closed_at_any_time() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let fleet = Fleet::start(
        "closures-recorded",
        "warehouse-1000.yaml",
        &["--robots", "20", "--speed", "5"],
    );
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    fleet.let_ticks_pass(200);
    let id = busy_edges(&fleet, 1)[0].1;
    accepted(&fleet, &["close", &id.to_string()]);
    fleet.let_ticks_pass(200);
    let status = fleet.status();
    let later = Duration::from_secs_f64(status["sim_time_secs"].as_f64().expect("seconds"));
    fleet.let_ticks_pass(200);
    assert!(recorder.interrupt().status.success() && fleet.engine.interrupt().status.success());

    let name = unique("closures-replayed");
    let mut command = regatta();
    let replay =
        command.arg("replay").arg(file(&folder)).args(["--paused", "--fleet", &name.to_string()]);
    let replay = Process::start(replay);
    let mut control = eventually("control", || Control::open(&name).ok());
    let start = eventually("the replay answers", || control.status().ok());
    // A jump over the event, and back to before it.
    control.seek(later).expect("gone there");
    let closed_now = || closed(&name).iter().map(|closed| closed.edge).collect::<Vec<_>>();
    eventually("it is closed", || (closed_now() == [id]).then_some(()));
    control.seek(Duration::from_nanos(start.sim_time_nanos)).expect("gone there");
    let participant = Participant::join(&name, "test").expect("joined");
    let mut closures = ClosureReader::open_on(&participant).expect("a reader");
    let mut frames = Subscriber::open_on(&participant).expect("a reader");
    let run =
        eventually("a frame", || frames.latest().expect("readable").map(|frame| frame.run_id()));
    closures.take().expect("readable");
    assert_eq!(closures.closed(run), [], "it was open before");
    assert!(replay.interrupt().status.success());
}
