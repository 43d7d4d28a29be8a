//! Commands by the menu.

use super::*;

fn commands(harness: &Harness<'_, Fixture>) -> Vec<UserCommand> {
    let commands = harness.state().actions.iter().filter_map(|action| match action {
        Action::Command(command) => Some(*command),
        _ => None,
    });
    commands.collect()
}

/// Opens the menu of an item in the middle of the picture, and clicks an entry.
fn choose(harness: &mut Harness<'_, Fixture>, item: Item, entry: &str) {
    harness.state_mut().actions.clear();
    harness.state_mut().interface.open_menu(Some(item), pos2(600.0, 300.0));
    settle(harness);
    harness.get_by_label(entry).click();
    settle(harness);
}

#[test]
fn a_right_click_asks_for_the_menu_and_escape_or_a_click_elsewhere_closes_it() {
    let mut harness = harness(Fixture::new(5));
    let at = pos2(600.0, 300.0);
    harness.hover_at(at);
    harness.run_steps(2);
    for pressed in [true, false] {
        let button = egui::PointerButton::Secondary;
        harness.event(egui::Event::PointerButton {
            pos: at,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(1);
    }
    settle(&mut harness);
    let asked = harness.state().actions.iter().find_map(|action| match action {
        Action::Menu { at, window } => Some((*at, *window)),
        _ => None,
    });
    let (picture, window) = asked.expect("the menu is asked for");
    assert_eq!(window, Vec2::new(600.0, 300.0));
    assert_eq!(
        window - picture,
        Vec2::new(8.0, 50.0),
        "below the top bar, within the harness's margin of 8 points"
    );
    for by_key in [true, false] {
        harness.state_mut().interface.open_menu(Some(Item::Edge(0)), at);
        settle(&mut harness);
        harness.get_by_label("Close edge");
        if by_key {
            press(&mut harness, Key::Escape);
        } else {
            harness.drag_at(pos2(300.0, 500.0));
            harness.drop_at(pos2(300.0, 500.0));
            settle(&mut harness);
        }
        assert!(harness.query_by_label("Close edge").is_none(), "{by_key}");
    }
    assert!(commands(&harness).is_empty());
}

#[test]
fn the_menu_gives_commands_and_undoes_them() {
    let mut harness = harness(Fixture::new(5));
    choose(&mut harness, Item::Robot(2), "Hold");
    assert_eq!(commands(&harness), [UserCommand::Hold(2)]);
    assert!(harness.query_by_label("Break down").is_none(), "the menu is closed");
    choose(&mut harness, Item::Robot(1), "Resume");
    assert_eq!(commands(&harness), [UserCommand::Resume(1)], "this one is held");
    choose(&mut harness, Item::Robot(2), "Break down");
    assert_eq!(commands(&harness), [UserCommand::Break(2)]);
    let fixture = harness.state_mut();
    ColumnsMut::split(&mut fixture.lines, 5).state[2] = RobotState::Broken as u8;
    choose(&mut harness, Item::Robot(2), "Hold");
    assert!(commands(&harness).is_empty(), "a hold couldn't be ended before the repair");
    choose(&mut harness, Item::Robot(2), "Repair");
    assert_eq!(commands(&harness), [UserCommand::Repair(2)]);
    choose(&mut harness, Item::Edge(0), "Close edge");
    assert_eq!(commands(&harness), [UserCommand::Close(34)]);
    harness.state_mut().closed = vec![0];
    choose(&mut harness, Item::Edge(0), "Open edge");
    assert_eq!(commands(&harness), [UserCommand::Open(34)]);
    harness.get_by_label("closed (1)");
}

#[test]
fn selected_robots_are_sent_to_a_node_by_the_manager_if_there_is_one() {
    let mut harness = harness(Fixture::new(5));
    choose(&mut harness, Item::Node(1), "Send here");
    assert!(commands(&harness).is_empty(), "nobody is selected");
    harness.state_mut().interface.select(Some(Item::Robot(4)));
    choose(&mut harness, Item::Node(1), "Send robot 4 here");
    assert_eq!(commands(&harness), [UserCommand::Send { robot: 4, node: 8 }]);
    harness.state_mut().interface.toggle_selected(Item::Robot(2));
    choose(&mut harness, Item::Node(0), "Send 2 robots here");
    assert_eq!(commands(&harness), [2, 4].map(|robot| UserCommand::Send { robot, node: 7 }));
    harness.state_mut().plans.has_goals = true;
    choose(&mut harness, Item::Node(0), "Send 2 robots here");
    assert_eq!(
        commands(&harness),
        [2, 4].map(|robot| UserCommand::SendByManager { robot, node: 7 })
    );
    harness.state_mut().interface.select(None);
    choose(&mut harness, Item::Robot(4), "Recall");
    assert_eq!(commands(&harness), [UserCommand::Recall(4)]);
}

#[test]
fn the_menu_of_a_station_has_its_name_and_its_nodes_behind_it() {
    let mut fixture = Fixture::new(5);
    let [name, level] = ["Storage 01", ""].map(|text| fixture.world.texts.add(text));
    let station =
        StationRecord { name, level, role: Role::Pick as u32, ..StationRecord::default() };
    fixture.world.add_station(station, [0]);
    fixture.world.nodes[1].role = Role::Charge as u32;
    let mut harness = harness(fixture);
    for (node, title) in [(0, "Station Storage 01 (node dock 1)"), (1, "Station charge 8 (node 8)")]
    {
        harness.state_mut().interface.open_menu(Some(Item::Node(node)), pos2(600.0, 300.0));
        settle(&mut harness);
        harness.get_by_label(title);
    }
}

#[test]
fn recordings_and_the_past_take_no_commands() {
    let mut past = Fixture::new(5);
    past.is_past = true;
    let mut gone = Fixture::new(5);
    gone.engine = EngineState::Gone;
    let reasons = ["This is a recording", "This is the past", "The engine has ended."];
    for (fixture, reason) in [replay(1.0), past, gone].into_iter().zip(reasons) {
        let mut harness = harness(fixture);
        choose(&mut harness, Item::Edge(0), "Close edge");
        assert!(commands(&harness).is_empty(), "{reason}");
        harness.get_by_label_contains(reason);
    }
}

#[test]
fn what_breaks_things_is_told_and_undone_by_a_key() {
    let mut harness = harness(Fixture::new(5));
    choose(&mut harness, Item::Edge(0), "Close edge");
    harness.get_by_label("close edge 34: Ctrl+Z undoes it");
    choose(&mut harness, Item::Robot(2), "Break down");
    harness.state_mut().actions.clear();
    for expected in [UserCommand::Repair(2), UserCommand::Open(34)] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        settle(&mut harness);
        assert_eq!(commands(&harness).last(), Some(&expected));
    }
    assert_eq!(commands(&harness).len(), 2, "an undo is no command to be undone");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    harness.get_by_label("there is no command to undo");
}

#[test]
fn the_robots_that_are_removed_come_back() {
    let mut fixture = Fixture::new(5);
    fixture.status = Some(ControlResponse { robots: 5, ..ControlResponse::default() });
    let mut harness = harness(fixture);
    press(&mut harness, Key::K);
    harness.get_by_label("remove 1 of 5 robots: Ctrl+Z undoes it");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut harness);
    let counts = harness.state().actions.iter().filter_map(|action| match action {
        Action::Control(request) if request.kind() == Some(ControlKind::Robots) => {
            Some(request.count)
        }
        _ => None,
    });
    assert_eq!(counts.collect::<Vec<_>>(), [4, 5]);
}
