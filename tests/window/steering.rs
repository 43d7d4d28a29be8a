//! Steering from the picture: the menu of a right click, against a real engine.

use glam::Vec2;
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::{ClosureReader, Participant, Subscriber, WorldReader};
use regatta_viewer::scene::camera::Camera;

use crate::fleet::{Fleet, eventually, unique};
use crate::screen::{self, Screen, Screenshot};
use crate::{close, viewer};

/// A direct way from node 1 to node 2, and one over node 3. A robot stands on node 1.
const GRAPH: &str = "Vertices:
- {Id: 1, X: 0.0, Y: 0.0, Theta: 0.0}
- {Id: 2, X: 20.0, Y: 0.0, Theta: 0.0}
- {Id: 3, X: 10.0, Y: 10.0, Theta: 0.0}
Edges:
- {Id: 10, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 2.0}
- {Id: 11, Origin_ID: 1, Destination_ID: 3, CurveType: Linear, VelocityForward: 2.0}
- {Id: 12, Origin_ID: 3, Destination_ID: 2, CurveType: Linear, VelocityForward: 2.0}
";

/// The picture from above, 24 m high: no menu comes near the panel on the right, which would push
/// it aside.
const MIDDLE: Vec2 = Vec2::new(18.0, 4.0);
const HEIGHT: f32 = 24.0;

/// The place of an entry of a menu, from the place of the right click, in pixels.
fn entry(number: i32) -> [i32; 2] {
    [40, 37 + 25 * number]
}

fn pixel(place: Vec2) -> [i32; 2] {
    let size = Vec2::new(screen::SIZE.0 as f32, screen::SIZE.1 as f32 - 42.0 - 48.0);
    let at =
        Camera::plan_around(MIDDLE, HEIGHT).project(place.extend(0.0), size).expect("in sight");
    (at + Vec2::new(0.0, 42.0)).round().as_ivec2().to_array()
}

fn click(screen: &Screen, [x, y]: [i32; 2], button: &str) {
    screen.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    screen.xdotool(&["click", button]);
}

/// Opens the menu of what is at a place, and clicks an entry.
fn choose(screen: &Screen, place: Vec2, number: i32) {
    let [x, y] = pixel(place);
    let (left, top) = (x as usize + 5, y as usize + 5);
    let changes =
        |before: &Screenshot| screen.screenshot().differing(before, left..left + 60, top..top + 60);
    // On a busy machine, the menu before may still be there, at the same place.
    let before = eventually("nothing changes there", || {
        let before = screen.screenshot();
        screen.xdotool(&["sleep", "0.5"]);
        (changes(&before) == 0).then_some(before)
    });
    click(screen, [x, y], "3");
    eventually("the menu opens", || (changes(&before) > 3000).then_some(()));
    let [right, down] = entry(number);
    click(screen, [x + right, y + down], "1");
}

pub fn an_edge_is_closed_and_a_robot_sent_broken_and_held_by_the_menu() {
    let screen = Screen::start();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("ways.yaml"), GRAPH).expect("written");
    let scenario = folder.path().join("scenario.yaml");
    std::fs::write(&scenario, "graph: ways.yaml\nrobots:\n- node: 1\n").expect("written");
    let fleet = Fleet::restart(unique("steering"), scenario.to_str().expect("a path"), &[]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut closures = ClosureReader::open_on(&participant).expect("a reader");
    let mut frames = Subscriber::open_on(&participant).expect("a reader");
    let run =
        eventually("a frame", || frames.latest().expect("readable").map(|frame| frame.run_id()));
    let mut worlds = WorldReader::open_on(&participant).expect("a reader");
    let direct = eventually("a world", || {
        let world = worlds.latest().ok()??;
        world.edges().iter().position(|edge| edge.id == 10)
    });

    let view = format!("{},{},{HEIGHT}", MIDDLE.x, MIDDLE.y);
    let viewer = viewer(&screen, &fleet.name, &["--camera", &view]);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 60).then_some(()));
    let open = screen.screenshot();
    let on_edge = Vec2::new(10.0, 0.0);
    choose(&screen, on_edge, 0);
    eventually("edge 10 is closed", || {
        closures.take().expect("readable");
        (closures.closed(run).first()?.edge == 10).then_some(())
    });
    let [x, y] = pixel(on_edge).map(|pixel| pixel as usize);
    eventually("a sign is drawn", || {
        (screen.screenshot().differing(&open, x - 60..x + 60, y - 15..y + 15) > 200).then_some(())
    });

    // Sent to node 2, the robot goes over node 3.
    click(&screen, pixel(Vec2::ZERO), "1");
    let title = format!("{}, robot 0", fleet.name);
    eventually("the robot is selected", || screen.try_xdotool(&["search", "--name", &title]));
    choose(&screen, Vec2::new(20.0, 0.0), 0);
    let mut state = |what: &str, wanted: &dyn Fn(RobotState, Vec2) -> bool| {
        eventually(what, || {
            let frame = frames.latest().expect("readable")?;
            let edge = frame.edge()[0];
            assert!(edge == NO_EDGE || edge != direct as u32, "it is on the closed edge");
            wanted(frame.state_of(0), Vec2::new(frame.x()[0], frame.y()[0])).then_some(())
        });
    };
    state("it drives", &|state, _| state == RobotState::Driving);
    state("it arrives", &|state, at| {
        state == RobotState::Idle && at.distance(Vec2::new(20.0, 0.0)) < 0.1
    });

    // Each command is undone by the same menu.
    let at = Vec2::new(20.0, 0.0);
    choose(&screen, at, 0);
    state("it is held", &|state, _| state == RobotState::Held);
    choose(&screen, at, 0);
    state("it is resumed", &|state, _| state == RobotState::Idle);
    choose(&screen, at, 1);
    state("it is broken", &|state, _| state == RobotState::Broken);
    choose(&screen, at, 1);
    state("it is repaired", &|state, _| state == RobotState::Idle);
    choose(&screen, on_edge, 0);
    eventually("edge 10 is open", || {
        closures.take().expect("readable");
        closures.closed(run).is_empty().then_some(())
    });
    // The breakdown is in the log, as an alarm.
    let before = screen.screenshot();
    screen.xdotool(&["key", "9"]);
    eventually("the log opens", || {
        (screen.screenshot().differing(&before, 10..260, 60..300) > 500).then_some(())
    });
    close(&screen, viewer);
    assert_eq!(screen.settings().expect("stored")["left"], "log");
}
