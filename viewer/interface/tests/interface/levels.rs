//! Levels side by side.

use super::*;

/// A harness of a world with three levels, side by side, and their parts.
fn side_by_side() -> (Harness<'static, Fixture>, Vec<(String, egui::Rect)>) {
    let mut fixture = Fixture::new(5);
    fixture.interface.set_levels(["cellar", "ground", "first"].map(str::to_owned).to_vec());
    fixture.interface.show_side_by_side(true);
    let mut harness = harness(fixture);
    settle(&mut harness);
    let parts = harness.state().interface.parts().to_vec();
    (harness, parts)
}

fn levels_of_filters(harness: &Harness<'_, Fixture>) -> Vec<Option<String>> {
    let filters = harness.state().actions.iter().filter_map(|action| match action {
        Action::Filter(filter) => Some(filter.level.clone()),
        _ => None,
    });
    filters.collect()
}

#[test]
fn the_levels_divide_the_picture_and_the_first_is_the_current_one() {
    let (harness, parts) = side_by_side();
    let state = harness.state();
    assert_eq!(
        parts.iter().map(|(level, _)| level.as_str()).collect::<Vec<_>>(),
        ["cellar", "ground", "first"]
    );
    assert_eq!((state.interface.level(), state.picture), (Some("cellar"), parts[0].1));
    assert_eq!(state.interface.levels_beside().collect::<Vec<_>>(), ["ground", "first"]);
    for ((_, part), (_, next)) in parts.iter().zip(&parts[1..]) {
        assert!(!part.shrink(0.1).intersects(*next) && part.size() == next.size(), "{part} {next}");
    }
    assert_eq!(
        levels_of_filters(&harness).last(),
        Some(&Some("cellar".to_owned())),
        "robots of other levels are hidden"
    );
}

/// A click selects what is there, in the level of the part: when that level is the one that is
/// picked from.
#[test]
fn a_click_into_another_part_moves_on_to_its_level_and_selects_there() {
    let (mut harness, parts) = side_by_side();
    let (_, part) = parts[2];
    let at = part.center() + egui::vec2(30.0, -20.0);
    harness.hover_at(at);
    settle(&mut harness);
    assert_eq!(harness.state().interface.level(), Some("cellar"), "the pointer may pass");
    harness.state_mut().actions.clear();
    // Both between two pictures.
    harness.drag_at(at);
    harness.drop_at(at);
    harness.step();
    assert_eq!((harness.state().interface.level(), harness.state().picture), (Some("first"), part));
    settle(&mut harness);
    let kinds: Vec<_> = harness.state().actions.iter().collect();
    let pick =
        kinds.iter().position(|action| matches!(action, Action::Pick { .. })).expect("a pick");
    let filter =
        kinds.iter().position(|action| matches!(action, Action::Filter(_))).expect("a filter");
    let Action::Pick { at: picked, .. } = kinds[pick] else { unreachable!("a pick") };
    let expected = at - part.min;
    assert!((*picked - Vec2::new(expected.x, expected.y)).length() < 1e-3, "{picked} {expected:?}");
    assert!(pick <= filter + 1, "with the first picture of that level: {kinds:?}");
    assert_eq!(levels_of_filters(&harness), [Some("first".to_owned())]);
}

/// Beside the levels is the legend.
#[test]
fn a_click_beside_all_levels_selects_nothing() {
    let (mut harness, parts) = side_by_side();
    let at = pos2(parts[0].1.left() - 20.0, 200.0);
    assert!(at.x > 100.0, "the legend has room: {at}");
    harness.hover_at(at);
    settle(&mut harness);
    harness.drag_at(at);
    harness.drop_at(at);
    settle(&mut harness);
    let actions = &harness.state().actions;
    assert!(!actions.iter().any(|action| matches!(action, Action::Pick { .. })), "{actions:?}");
    assert_eq!(harness.state().interface.level(), Some("cellar"));
}

#[test]
fn the_wheel_zooms_about_the_pointer_in_its_part() {
    let (mut harness, parts) = side_by_side();
    let (_, part) = parts[1];
    let before = harness.state().interface.camera_controller.camera();
    harness.hover_at(part.center());
    settle(&mut harness);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    settle(&mut harness);
    let after = harness.state().interface.camera_controller.camera();
    assert_eq!(harness.state().interface.level(), Some("ground"));
    assert!(
        after.distance < before.distance && after.target.distance(before.target) < 1e-3,
        "{before:?} {after:?}"
    );
}

#[test]
fn levels_are_chosen_in_the_view_panel() {
    let mut fixture = Fixture::new(5);
    fixture.interface.set_levels(["cellar", "ground"].map(str::to_owned).to_vec());
    fixture.interface.settings.right = Some(RightPanel::View);
    let mut harness = harness(fixture);
    let choose = |harness: &mut Harness<'_, Fixture>, name: &str| {
        harness.get_by_label("level").click();
        settle(harness);
        harness.get_by_label(name).click();
        settle(harness);
    };
    choose(&mut harness, "side by side");
    let state = harness.state();
    assert_eq!((state.interface.parts().len(), state.interface.level()), (2, Some("cellar")));
    choose(&mut harness, "ground");
    let state = harness.state();
    assert_eq!(
        (state.interface.parts().len(), state.interface.level()),
        (0, Some("ground")),
        "one alone"
    );
    choose(&mut harness, "all levels");
    assert_eq!(harness.state().interface.level(), None);
    let wanted = [Some("cellar"), Some("ground"), None].map(|level| level.map(str::to_owned));
    let mut levels = levels_of_filters(&harness);
    levels.dedup();
    assert!(levels.ends_with(&wanted), "{levels:?}");
}

/// The texts of the last picture that float over it.
fn floating_texts(harness: &Harness<'_, Fixture>) -> Vec<String> {
    let texts = harness.output().shapes.iter().filter_map(|clipped| match &clipped.shape {
        egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
        _ => None,
    });
    texts.collect()
}

#[test]
fn a_selected_robot_is_named_only_in_the_picture_of_its_level() {
    let (mut harness, parts) = side_by_side();
    let fixture = harness.state_mut();
    // Robot 0 is on the only edge, which is in the cellar, in the middle of the picture.
    let level = fixture.world.texts.add("cellar");
    fixture.world.edges[0].level = level;
    fixture.interface.select(Some(Item::Robot(0)));
    settle(&mut harness);
    let is_named =
        |harness: &Harness<'_, Fixture>| floating_texts(harness).contains(&"robot 0".to_owned());
    assert!(is_named(&harness), "{:?}", floating_texts(&harness));
    harness.hover_at(parts[1].1.center());
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 0.1),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    settle(&mut harness);
    assert_eq!(harness.state().interface.level(), Some("ground"));
    assert!(!is_named(&harness), "the robot is in the cellar");
}

#[test]
fn levels_side_by_side_are_no_filter_of_robots() {
    let mut fixture = Fixture::new(5);
    fixture.interface.set_levels(["cellar", "ground"].map(str::to_owned).to_vec());
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    fixture.interface.show_side_by_side(true);
    let mut harness = harness(fixture);
    settle(&mut harness);
    assert_eq!(harness.state().interface.parts().len(), 2);
    let counts = MatchCounts { matching: 5, on_level: 1, all: 5 };
    harness.state_mut().matches = Some(Matches { counts, ..Matches::default() });
    settle(&mut harness);
    let counted = "1\u{a0}of 5\u{a0}robots on this level";
    assert!(harness.query_by_label(counted).is_none(), "all robots are shown, in their parts");
    harness.state_mut().interface.show_side_by_side(false);
    settle(&mut harness);
    assert_eq!(harness.state().interface.level(), Some("cellar"));
    harness.get_by_label(counted);
}

#[test]
fn robots_that_match_are_counted_on_all_levels_side_by_side() {
    let (mut harness, _) = side_by_side();
    harness.state_mut().interface.settings.left = Some(LeftPanel::Fleet);
    settle(&mut harness);
    harness.get_by_label("filter: activity").click();
    settle(&mut harness);
    harness.get_by_label("held").click();
    let elsewhere = matches(harness.state(), &[3], true);
    harness.state_mut().matches = Some(elsewhere);
    settle(&mut harness);
    harness.get_by_label("1\u{a0}of 5\u{a0}robots matches");
    harness.state_mut().interface.show_side_by_side(false);
    settle(&mut harness);
    harness.get_by_label("0\u{a0}of 5\u{a0}robots match");
}

#[test]
fn another_world_without_the_level_is_shown_as_a_whole() {
    let (mut harness, _) = side_by_side();
    let show = |harness: &mut Harness<'_, Fixture>, levels: &[&str]| {
        harness
            .state_mut()
            .interface
            .set_levels(levels.iter().map(|level| (*level).to_owned()).collect());
        settle(harness);
        let interface = &harness.state().interface;
        (interface.level().map(str::to_owned), interface.parts().len())
    };
    assert_eq!(show(&mut harness, &[]), (None, 0));
    assert_eq!(levels_of_filters(&harness).last(), Some(&None), "no robot is hidden");
    assert!(
        harness.query_by_label_contains("there is no level").is_none(),
        "the user has chosen none"
    );
    assert_eq!(
        show(&mut harness, &["attic", "ground"]),
        (Some("attic".to_owned()), 2),
        "side by side again"
    );
    harness.state_mut().interface.show_side_by_side(false);
    assert_eq!(show(&mut harness, &["attic", "ground"]), (Some("attic".to_owned()), 0));
    assert_eq!(show(&mut harness, &["ground"]), (None, 0));
    harness.get_by_label_contains("there is no level 'attic'; all are shown");
}
