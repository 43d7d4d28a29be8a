//! The clock, the list of robots, and what the panels tell of a robot.

use std::time::Duration;

use super::*;

#[test]
fn the_clock_is_paused_stepped_and_resumed() {
    let mut harness = harness(Fixture::new(5));
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert_eq!(harness.state().requests(), [(ControlKind::Pause, 0, 0.0)]);
    harness.state_mut().actions.clear();
    harness.state_mut().header.clock = ClockState::Paused as u32;
    settle(&mut harness);
    harness.get_by_label("Step").click();
    settle(&mut harness);
    harness.get_by_label("Resume").click();
    settle(&mut harness);
    assert_eq!(
        harness.state().requests(),
        [(ControlKind::Step, 1, 0.0), (ControlKind::Resume, 0, 0.0)]
    );
}

#[test]
fn keys_send_the_same_requests_as_buttons() {
    let mut harness = harness(Fixture::new(5));
    for key in [Key::Space, Key::CloseBracket, Key::OpenBracket, Key::I] {
        press(&mut harness, key);
    }
    let requests = harness.state().requests();
    let wanted = [
        (ControlKind::Pause, 0, 0.0),
        (ControlKind::Speed, 0, 2.0),
        (ControlKind::Speed, 0, 0.5),
        (ControlKind::Robots, 6, 0.0),
    ];
    assert_eq!(requests, wanted);
}

#[test]
fn a_warm_up_is_told_in_the_place_of_the_fleet() {
    let mut fixture = Fixture::new(5);
    fixture.engine = EngineState::WarmingUp(Duration::from_secs(200));
    let mut harness = harness(fixture);
    settle(&mut harness);
    harness.get_by_label("Warming up: 3:20");
    assert!(harness.query_by_label("idle").is_none(), "no legend of robots");
}

#[test]
fn the_interface_waits_for_an_engine_and_sends_no_requests() {
    let mut fixture = Fixture::new(5);
    (fixture.engine, fixture.status) = (EngineState::Awaited, None);
    let mut harness = harness(fixture);
    settle(&mut harness);
    harness.get_by_label("Waiting for fleet 'test'");
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert!(harness.state().requests().is_empty());
}

#[test]
fn a_robot_is_found_by_its_id_and_flown_to() {
    let mut harness = harness(Fixture::new(500));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.left, Some(LeftPanel::Fleet));
    harness.event(egui::Event::Text("321".into()));
    settle(&mut harness);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(321)));
    harness.run_steps(120);
    is_between_the_panels(&harness, Vec2::new(321.0, -321.0));
    harness.get_by_label("Robot 321");
    assert!(
        harness.state().requests().is_empty(),
        "digits typed into a field trigger no shortcuts"
    );
}

#[test]
fn a_picture_is_saved_and_a_file_opened_while_the_search_field_has_the_focus() {
    let mut harness = harness(Fixture::new(5));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    settle(&mut harness);
    let actions = &harness.state().actions;
    assert!(actions.contains(&Action::WritePicture), "{actions:?}");
    assert!(actions.contains(&Action::Open), "{actions:?}");
    press(&mut harness, Key::Questionmark);
    assert!(harness.query_by_label("this help").is_none(), "signs are typed");
}

#[test]
fn beyond_the_highest_speed_there_is_no_limit() {
    let mut fixture = Fixture::new(5);
    fixture.header.speed = 100.0;
    let mut harness = harness(fixture);
    press(&mut harness, Key::CloseBracket);
    harness.state_mut().header.speed = f32::INFINITY;
    settle(&mut harness);
    press(&mut harness, Key::CloseBracket);
    press(&mut harness, Key::OpenBracket);
    let speeds = [f32::INFINITY, f32::INFINITY, 100.0].map(|speed| (ControlKind::Speed, 0, speed));
    assert_eq!(harness.state().requests(), speeds);
}

#[test]
fn a_second_search_replaces_the_first() {
    let mut harness = harness(Fixture::new(500));
    for robot in [71, 2] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
        settle(&mut harness);
        harness.event(egui::Event::Text(robot.to_string()));
        settle(&mut harness);
        press(&mut harness, Key::Enter);
        assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(robot)));
    }
}

#[test]
fn the_list_of_a_million_robots_shows_the_rows_in_sight() {
    let mut fixture = Fixture::new(1_000_000);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    harness.get_by_label("robot 0");
    assert!(harness.query_by_label("robot 100").is_none());
    harness.get_by_label("sort by id").click();
    settle(&mut harness);
    harness.get_by_label("robot 999999").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(999_999)));
    for _ in 0..3 {
        press(&mut harness, Key::PageDown);
    }
    assert!(harness.query_by_label("robot 999999").is_none(), "three pages further");
    harness.get_by_label("sort by speed").click();
    settle(&mut harness);
    let requested = harness.state().actions.iter().rev().find_map(|action| match action {
        Action::Rows(query) => Some(query.clone()),
        _ => None,
    });
    let query = requested.expect("rows are requested");
    assert_eq!((query.sort, query.descending), (SortBy::Speed, false));
    harness.state_mut().rows = Some(Rows { query, ids: vec![42, 17, 4] });
    settle(&mut harness);
    harness.get_by_label("robot 17");
    assert!(harness.query_by_label("robot 1").is_none());
}

#[test]
fn a_click_on_a_collision_flies_to_it() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Collisions);
    fixture.pairs = vec![ContactRecord {
        robots: [3, 9],
        level: 2,
        x: 30.0,
        y: -12.0,
        ..ContactRecord::default()
    }];
    let mut harness = harness(fixture);
    harness.get_by_label("1");
    harness.get_by_label("robots 3 and 9 touching").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(3)));
    assert_eq!(harness.state().interface.robots(), [3, 9]);
    harness.run_steps(120);
    is_between_the_panels(&harness, Vec2::new(30.0, -12.0));
    // The panel has the height of the window, and all of its rows are in sight.
    harness.state_mut().interface.settings.left = None;
    settle(&mut harness);
    harness.get_by_label("robot 9").click();
    settle(&mut harness);
    assert_eq!(
        harness.state().interface.selection.item,
        Some(Item::Robot(9)),
        "the other robot of the pair"
    );
}

#[test]
fn robots_are_filtered_and_those_that_match_are_counted() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    harness.get_by_label("filter: activity").click();
    settle(&mut harness);
    harness.get_by_label("held").click();
    settle(&mut harness);
    let wanted = Filter { activity: Some(Activity::Held), ..Filter::default() };
    let filters = |actions: &[Action]| -> Vec<Filter> {
        let filters = actions.iter().filter_map(|action| match action {
            Action::Filter(filter) => Some(filter.clone()),
            _ => None,
        });
        filters.collect()
    };
    assert_eq!(filters(&harness.state().actions), std::slice::from_ref(&wanted));
    harness.get_by_label("counting …");
    let held = matches(harness.state(), &[1, 3], false);
    harness.state_mut().matches = Some(held);
    settle(&mut harness);
    harness.get_by_label("2\u{a0}of 5\u{a0}robots match");
    harness.get_by_label("show all").click();
    settle(&mut harness);
    assert_eq!(filters(&harness.state().actions), [wanted, Filter::default()]);
    assert!(harness.query_by_label("2\u{a0}of 5\u{a0}robots match").is_none());
}

#[test]
fn a_filter_moves_no_row_of_the_list_and_ends_without_the_level() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    fixture.interface.set_levels(["ground floor", "attic"].map(str::to_owned).to_vec());
    let mut harness = harness(fixture);
    let row = |harness: &Harness<'_, Fixture>| harness.get_by_label("robot 3").rect();
    let before = row(&harness);
    harness.get_by_label("filter: activity").click();
    settle(&mut harness);
    harness.get_by_label("held").click();
    harness.state_mut().interface.show_level(Some("attic".to_owned()));
    settle(&mut harness);
    assert_eq!(row(&harness), before);
    harness.get_by_label("show all").click();
    settle(&mut harness);
    assert_eq!(row(&harness), before);
    let last = harness.state().actions.iter().rev().find_map(|action| match action {
        Action::Filter(filter) => Some(filter.clone()),
        _ => None,
    });
    assert_eq!(last, Some(Filter { level: Some("attic".to_owned()), ..Filter::default() }));
}

#[test]
fn rows_of_robots_that_do_not_match_are_dimmed() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    let opacity_of = |harness: &Harness<'_, Fixture>, id: &str| {
        let texts = harness.output().shapes.iter().filter_map(|clipped| match &clipped.shape {
            egui::Shape::Text(text) if text.galley.text() == id => Some(text.fallback_color.a()),
            _ => None,
        });
        texts.collect::<Vec<_>>()
    };
    let opaque = opacity_of(&harness, "17");
    assert_eq!((opaque.len(), &opaque), (1, &opacity_of(&harness, "16")));
    let filtered = matches(harness.state(), &[17], false);
    harness.state_mut().matches = Some(filtered);
    settle(&mut harness);
    assert_eq!(opacity_of(&harness, "17"), opaque);
    assert!(opacity_of(&harness, "16")[0] < opaque[0] / 2 && opacity_of(&harness, "16")[0] > 0);
}

#[test]
fn the_panel_reports_a_robot_that_has_left() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Robot(77)));
    settle(&mut harness);
    harness.get_by_label("not in the fleet now");
}

#[test]
fn the_panel_shows_the_rest_of_a_route() {
    let mut fixture = Fixture::new(5);
    let released = RouteLength { edges: 1, metres: 4.25, is_partial: false };
    fixture.route = Some(Remaining {
        released,
        planned: RouteLength { edges: 300, metres: 812.0, is_partial: true },
    });
    fixture.interface.select(Some(Item::Robot(2)));
    let mut harness = harness(fixture);
    settle(&mut harness);
    assert!(harness.query_by_label("1 edge, 4.2 m").is_some());
    assert!(harness.query_by_label("300 edges, > 812.0 m").is_some());
    harness.state_mut().route = Some(Remaining::default());
    settle(&mut harness);
    assert!(harness.query_by_label("no route").is_some());
    harness.state_mut().route = None;
    settle(&mut harness);
    assert!(harness.query_by_label("ROUTE").is_none(), "the route is unknown");
}

#[test]
fn the_panel_tells_a_robots_work() {
    let mut fixture = Fixture::new(5);
    fixture.values = vec![("battery", 74.6), ("goal", 7.0), ("load", 1.5), ("waits-for", 3.0)];
    fixture.activities = vec![f32::from(regatta_plugin::activity::Activity::Queued as u8); 5];
    let next = Some(Stop { node: 8, action: StopAction::Pick });
    fixture.order = Some(RobotOrder { number: 312, stop: [1, 2], next, is_handling: false });
    let mut harness = harness(fixture);
    harness.state_mut().interface.select(Some(Item::Robot(0)));
    settle(&mut harness);
    for text in ["queued", "312", "to pick at node 8", "75 %", "1.500"] {
        harness.get_by_label(text);
    }
    let order = RobotOrder { number: 0, stop: [2, 2], next, is_handling: false };
    let named = NamedOrder { robot: 0, name: "load:1-1".to_owned(), order };
    harness.state_mut().named_order = Some(named);
    settle(&mut harness);
    harness.get_by_label("load:1-1");
    harness.get_by_label_contains("stop 1");
    harness.state_mut().order = None;
    settle(&mut harness);
    harness.get_by_label("load:1-1");
    harness.get_by_label_contains("stop 2");
    harness.get_by_label("robot 3").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(3)));
    harness.get_by_role_and_label(egui::accesskit::Role::Link, "dock 1").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Node(0)));
}

#[test]
fn a_robot_without_work_waits_for_nobody() {
    let mut fixture = Fixture::new(5);
    fixture.values = vec![("activity", 0.0), ("goal", f32::NAN), ("waits-for", f32::NAN)];
    let mut harness = harness(fixture);
    harness.state_mut().interface.select(Some(Item::Robot(1)));
    settle(&mut harness);
    assert!(harness.query_by_label("WORK").is_none(), "nothing to tell");
    harness.state_mut().values = vec![("activity", 0.0), ("goal", 7.0), ("battery", 80.0)];
    settle(&mut harness);
    harness.get_by_label("80 %");
    assert!(harness.query_by_label("goal").is_none(), "an idle robot goes nowhere");
}

#[test]
fn several_robots_are_selected() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    let selected = |harness: &Harness<'_, Fixture>| harness.state().interface.robots();
    let click = |harness: &mut Harness<'_, Fixture>, robot: u32, modifiers: Modifiers| {
        harness.get_by_label(&format!("robot {robot}")).click_modifiers(modifiers);
        settle(harness);
    };
    click(&mut harness, 3, Modifiers::NONE);
    click(&mut harness, 5, Modifiers::COMMAND);
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(selected(&harness), [7, 5, 3]);
    harness.get_by_label("Robot 7");
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(selected(&harness), [5, 3], "a second click removes the robot");
    harness.get_by_label("3").click();
    settle(&mut harness);
    assert_eq!(selected(&harness), [3, 5], "a click on another selected robot shows that one");
    harness.get_by_label("Robot 3");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    harness.event(egui::Event::Text("41".into()));
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    settle(&mut harness);
    assert_eq!(selected(&harness), [41, 3, 5], "added by the keyboard");
    press(&mut harness, Key::Enter);
    assert_eq!(selected(&harness), [41], "selected alone");
    press(&mut harness, Key::Escape);
    assert!(selected(&harness).is_empty());
}

#[test]
fn the_search_finds_places_by_number_and_by_name() {
    for (text, item) in [("n8", Item::Node(1)), ("e34", Item::Edge(0)), ("DOCK 1", Item::Node(0))] {
        let mut harness = harness(Fixture::new(5));
        harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
        settle(&mut harness);
        harness.event(egui::Event::Text(text.to_owned()));
        settle(&mut harness);
        harness.state_mut().rows = Some(Rows {
            query: RowQuery { filter: text.to_owned(), ..RowQuery::default() },
            ids: Vec::new(),
        });
        settle(&mut harness);
        press(&mut harness, Key::Enter);
        assert_eq!(harness.state().interface.selection.item, Some(item), "{text}");
    }
}
