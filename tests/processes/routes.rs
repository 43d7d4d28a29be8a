//! The route service: the engine returns the routes that robots have.

use regatta_plugin::command::RouteLeg;
use regatta_plugin::event::EventKind;
use regatta_plugin::route::{LegAhead, RouteResponse};
use regatta_plugin::{
    Commands, EventReader, Participant, ReadError, RouteClient, RouteError, WorldReader,
};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, regatta, unique};
use crate::record::{file, record};

/// Starts an engine with three robots on a square: the first stands on a node, the second drives
/// around the square, and the third follows random routes.
fn square(test: &str, folder: &TempDir) -> Fleet {
    let graph = crate::fleet::graphs("square.yaml");
    let robots =
        "- node: 1\n- route: [1, 11, 2, 12, 3, 13, 4, 14]\n  repeat: loop\n- routes: random\n";
    let path = folder.path().join("square.yaml");
    std::fs::write(&path, format!("graph: {}\nrobots:\n{robots}", graph.display()))
        .expect("written");
    Fleet::restart(unique(test), path.to_str().expect("a path"), &[])
}

/// Returns the ids of the edges by their index in the world.
fn edge_ids(participant: &Participant) -> Vec<u32> {
    let mut worlds = WorldReader::open_on(participant).expect("opened");
    eventually("a world", || {
        let world = worlds.latest().expect("readable")?;
        Some(world.edges().iter().map(|edge| edge.id).collect())
    })
}

fn client(participant: &Participant) -> RouteClient {
    let client = RouteClient::open_on(participant).expect("opened");
    eventually("a process that serves routes", || {
        client.has_routes().then_some(client.has_routes())
    });
    client
}

fn legs(route: &RouteResponse, edges: &[u32]) -> Vec<(u32, bool)> {
    route.legs().map(|leg| (edges[leg.edge as usize], leg.released)).collect()
}

#[test]
fn a_route_is_returned_with_its_base_and_its_horizon() {
    let folder = TempDir::new().expect("a folder");
    let fleet = square("routes", &folder);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut routes = client(&participant);
    let edges = edge_ids(&participant);

    let nothing = routes.route(0).expect("answered");
    assert!(nothing.is_found());
    assert_eq!(
        (nothing.legs, nothing.released, nothing.legs().len()),
        (0, 0, 0),
        "the robot has no route yet"
    );
    let unknown = routes.route(4_000).expect("answered");
    assert!(!unknown.is_found());
    assert_eq!((unknown.robot, unknown.run_id), (4_000, nothing.run_id));

    // A held robot accepts a route and doesn't move.
    let mut events = EventReader::open_on(&participant).expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    commands.hold(0);
    let ahead = [1, 11, 2, 12].map(RouteLeg::forward);
    let token = commands.assign(0, &[ahead[0], ahead[1], ahead[2].horizon(), ahead[3].horizon()]);
    commands.send().expect("sent");
    eventually("the command is taken", || {
        let mut answer = None;
        let taken = events.take(|events| {
            answer = answer.or(events
                .records
                .iter()
                .find(|event| event.token == token)
                .map(|event| event.kind));
            Ok::<_, ReadError>(())
        });
        taken.expect("readable");
        answer.inspect(|kind| assert_eq!(*kind, EventKind::Accepted as u32))
    });
    let route = routes.route(0).expect("answered");
    assert_eq!((route.run_id, route.robot, route.legs, route.released), (nothing.run_id, 0, 4, 2));
    assert_eq!(legs(&route, &edges), [(1, true), (11, true), (2, false), (12, false)]);
    assert!(route.legs().all(|leg: LegAhead| !leg.reverse) && route.tick > nothing.tick);

    let [first, again, lap, random] =
        &routes.routes(&[0, 0, 1, 2], RouteClient::TIMEOUT).expect("answered")[..]
    else {
        panic!("expected as many responses as robots")
    };
    assert_eq!((first.listed, again.listed), (route.listed, route.listed));
    assert_eq!((lap.legs, lap.drives_on()), (8, true), "a loop is returned as one lap");
    assert_eq!(
        (random.legs, random.released),
        (17, 17),
        "a random route is returned as far as it is drawn"
    );
    assert!(random.drives_on() && !first.drives_on());

    // At the end of its base the robot waits for a release of the horizon.
    commands.resume(0);
    commands.send().expect("sent");
    let waiting = eventually("the end of the base", || {
        let route = routes.route(0).expect("answered");
        (route.released == 0).then_some(route)
    });
    assert_eq!(legs(&waiting, &edges), [(2, false), (12, false)]);
    assert!(fleet.engine.interrupt().status.success());
}

#[test]
fn a_paused_engine_returns_routes_and_a_replay_has_none() {
    let folder = TempDir::new().expect("a folder");
    let fleet = square("routes-paused", &folder);
    fleet.control(&["pause"]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let before = client(&participant).route(1).expect("answered");
    assert_eq!(client(&participant).route(1).expect("answered"), before, "no robot moves");

    record("routes-source", "thirty.yaml", 10, &file(&folder), &[]);
    let name = unique("routes-replay");
    let arguments = ["--fleet", &name.to_string(), "--paused"];
    let replay = Process::start(regatta().arg("replay").arg(file(&folder)).args(arguments));
    let mut control = regatta_plugin::Control::open(&name).expect("opened");
    eventually("the replay answers", || control.status().ok());
    let mut routes = RouteClient::open(&name).expect("opened");
    assert_eq!(routes.route(0), Err(RouteError::NoRoutes { fleet: name }));
    assert!(replay.interrupt().status.success());
}
