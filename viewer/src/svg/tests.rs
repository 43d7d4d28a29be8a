use glam::Vec2;
use regatta_plugin::facility::{DoorState, FacilityState};
use regatta_plugin::frame::{
    ColumnsMut, Frame, FrameHeader, Line, NO_EDGE, RobotState, frame_lines, stride_lines,
};
use regatta_plugin::world::{
    CurveRecord, DoorRecord, EdgeRecord, NodeRecord, RobotTypeRecord, Role, StationRecord,
    WorldData,
};
use regatta_scene::palette::{Colouring, Theme};

use super::*;

#[test]
fn scales_are_round_and_the_drawing_fits() {
    for (metres, scale) in
        [(3.8, 10.0), (20.0, 100.0), (70.0, 200.0), (76.0, 200.0), (100.0, 500.0), (900.0, 5000.0)]
    {
        assert_eq!(fitting_scale(metres), scale, "{metres} m");
        assert!(metres * 1000.0 / scale <= LONGEST_MM * 1.01);
    }
}

#[test]
fn a_plan_has_curves_and_outlines_at_their_true_size() {
    let mut world = WorldData {
        robot_types: vec![RobotTypeRecord::new("a <b>", 1.0, 0.5)],
        ..WorldData::default()
    };
    world.nodes = vec![NodeRecord { id: 3, x: 1.0, y: 2.0, ..NodeRecord::default() }];
    let curve = CurveRecord { control_points: [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [4.0, 2.0]] };
    world.add_edge(EdgeRecord { id: 9, ..EdgeRecord::default() }, [curve]);
    let header =
        FrameHeader { robots: 2, stride_lines: stride_lines(2) as u32, ..FrameHeader::default() };
    let mut lines = vec![Line::default(); frame_lines(2)];
    let columns = ColumnsMut::split(&mut lines, 2);
    (columns.x[0], columns.y[0], columns.state[0]) = (2.0, 1.0, RobotState::Driving as u8);
    columns.state[1] = RobotState::Absent as u8;
    let colouring = Colouring::State;
    let legend = colouring.legend(Theme::Light, &[], None);
    let plan = Plan {
        world: world.view(1, 1),
        frame: Some(Frame::new(&header, &lines).expect("a frame")),
        robot_type: None,
        values: None,
        colouring: &colouring,
        legend: &legend,
        theme: Theme::Light,
        closed: &[],
        facilities: &[],
        level: None,
        bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
        offset: Vec2::ZERO,
        scale: Some(50.0),
        name: "A & B",
        seconds: 0.0,
    };
    let text = draw(&plan).expect("a drawing");
    // 4 m and 2 m at 1:50 are 80 mm and 40 mm; margins and the line below come on top.
    assert!(text.contains("width=\"100.00mm\" height=\"74.00mm\""), "{text}");
    assert!(
        text.contains("d=\"M0.0000 0.0000C1.0000 0.0000 1.0000 2.0000 4.0000 2.0000\""),
        "{text}"
    );
    assert!(
        text.contains("points=\"1.5000,0.7500 2.5000,0.7500 2.5000,1.2500 1.5000,1.2500\""),
        "{text}"
    );
    assert!(
        text.contains("id=\"n3\"")
            && !text.contains("robot-1\"")
            && text.contains("A &amp; B, 0.00 s, 1 robot   1:50"),
        "{text}"
    );
    assert!(text.contains("matrix(20 0 0 -20 10.0000 50.0000)"), "{text}");
    assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
    assert!(!text.contains("closed"));
    let text = draw(&Plan { closed: &[0, 7], ..plan }).expect("a drawing");
    let path =
        "<path id=\"closed-e9\" d=\"M0.0000 0.0000C1.0000 0.0000 1.0000 2.0000 4.0000 2.0000\"/>";
    assert!(text.contains(path) && text.contains("stroke-dasharray"), "{text}");
    assert_eq!(
        text.matches("fill=\"#d8232e\"").count(),
        1,
        "a sign for each closed edge that the world has"
    );
    assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
}

#[test]
fn a_plan_has_walls_the_names_of_stations_and_doors_and_the_states_of_doors() {
    let mut world = WorldData::default();
    let [dock, gate] = ["dock <1>", "gate"].map(|name| world.texts.add(name));
    let role = Role::Pick as u32;
    world.nodes = vec![NodeRecord { name: dock, role, ..NodeRecord::default() }];
    world.add_edge(EdgeRecord::default(), []);
    let line = [[0.0, -1.0], [0.0, 1.0]];
    world.add_door(DoorRecord { name: gate, line, ..DoorRecord::default() }, [0]);
    let name = world.texts.add("Storage 01");
    world.add_station(StationRecord { name, x: 3.0, y: 1.0, ..StationRecord::default() }, []);
    world.add_background_line(0, [[0.0, 0.0], [4.0, 0.0]]);
    let colouring = Colouring::State;
    let legend = colouring.legend(Theme::Light, &[], None);
    let open = FacilityState { door: DoorState::Open as u32, ..FacilityState::default() };
    let plan = Plan {
        world: world.view(1, 1),
        frame: None,
        robot_type: None,
        values: None,
        colouring: &colouring,
        legend: &legend,
        theme: Theme::Light,
        closed: &[],
        facilities: &[open],
        level: None,
        bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
        offset: Vec2::ZERO,
        scale: None,
        name: "fleet",
        seconds: 0.0,
    };
    let text = draw(&plan).expect("a drawing");
    assert!(text.contains(">dock &lt;1&gt;</text>") && text.contains(">gate</text>"), "{text}");
    assert_eq!(text.matches("stroke=\"#30b361\"").count(), 2, "its leaves: {text}");
    assert!(text.contains(">Storage 01</text>") && text.contains(">Storage 01</title>"), "{text}");
    assert!(text.contains("id=\"background\""), "{text}");
    assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
}

/// Returns the ids of what a drawing shows, in its order.
fn ids(text: &str) -> Vec<&str> {
    let ids = text.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next());
    ids.filter(|id| id.ends_with(|last: char| last.is_ascii_digit())).collect()
}

#[test]
fn a_plan_of_a_level_has_only_what_is_on_that_level() {
    let mut world = WorldData::default();
    let levels = ["cellar", "ground"].map(|name| world.texts.add(name));
    for (id, level) in (0..).zip(levels) {
        world.nodes.push(NodeRecord { id, level, ..NodeRecord::default() });
        let line = CurveRecord::straight([0.0, 0.0], [4.0, 0.0]);
        world.add_edge(EdgeRecord { id: 10 + id, level, ..EdgeRecord::default() }, [line]);
    }
    // A robot on each level, and one on no edge.
    let header =
        FrameHeader { robots: 3, stride_lines: stride_lines(3) as u32, ..FrameHeader::default() };
    let mut lines = vec![Line::default(); frame_lines(3)];
    let columns = ColumnsMut::split(&mut lines, 3);
    columns.edge[..3].copy_from_slice(&[0, 1, NO_EDGE]);
    columns.state[..3].fill(RobotState::Driving as u8);
    let colouring = Colouring::State;
    let legend = colouring.legend(Theme::Light, &[], None);
    let drawn = |level| {
        let plan = Plan {
            world: world.view(1, 1),
            frame: Some(Frame::new(&header, &lines).expect("a frame")),
            robot_type: None,
            values: None,
            colouring: &colouring,
            legend: &legend,
            theme: Theme::Light,
            closed: &[0, 1],
            facilities: &[],
            level,
            bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
            offset: Vec2::ZERO,
            scale: None,
            name: "fleet",
            seconds: 0.0,
        };
        draw(&plan).expect("a drawing")
    };
    let cellar = drawn(Some("cellar"));
    assert_eq!(ids(&cellar), ["e10", "closed-e10", "n0", "robot-0"]);
    assert_eq!(cellar.matches("fill=\"#d8232e\"").count(), 1);
    assert!(cellar.contains("<title>fleet, cellar, 0.00 s, 1 robot</title>"), "{cellar}");
    assert_eq!(ids(&drawn(Some("ground"))), ["e11", "closed-e11", "n1", "robot-1"]);
    let all = drawn(None);
    let shown =
        ["e10", "e11", "closed-e10", "closed-e11", "n0", "n1", "robot-0", "robot-1", "robot-2"];
    assert_eq!(ids(&all), shown);
}
