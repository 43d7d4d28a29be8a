//! Edges, the heat map, hot spots and figures over time.

use super::*;

#[test]
fn an_edge_and_its_nodes_link_to_each_other() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Edge(0)));
    settle(&mut harness);
    harness.get_by_label("Edge 34");
    harness.get_by_label("node dock 1").click();
    settle(&mut harness);
    harness.get_by_label("Node dock 1");
    harness.get_by_label("7");
    harness.get_by_label("edge 34").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Edge(0)));
}

#[test]
fn the_heat_map_is_chosen_and_says_what_it_lacks() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.right = Some(RightPanel::View);
    let mut harness = harness(fixture);
    assert!(harness.query_by_label("no figures: regatta plugin traffic").is_none());
    harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    settle(&mut harness);
    harness.get_by_label("no figures: regatta plugin traffic");
    harness.get_by_label("regatta plugin traffic --fleet test");
    harness.get_by_label("heat map: figure").click();
    settle(&mut harness);
    harness.get_by_role_and_label(egui::accesskit::Role::Button, "speed").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.heat_of.to_string(), "speed:10min");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::G);
    settle(&mut harness);
    let heat: Heat = "waiting".parse().expect("a heat map");
    assert!(
        harness.state().interface.settings.heat
            && harness.state().interface.settings.heat_of == heat
    );
    let (ends, has_contacts, has_routes) = ([0.0, 50.0], true, false);
    let facts = HeatFacts {
        heat,
        ends,
        is_exceeded: true,
        edges: 12,
        secs: 240.0,
        has_contacts,
        has_routes,
    };
    harness.state_mut().jams.heat = Some(facts);
    settle(&mut harness);
    harness.get_by_label("last 4\u{a0}min");
    harness.get_by_label("12\u{a0}edges have a value");
    harness.state_mut().interface.settings.heat_of = "routes".parse().expect("a heat map");
    let routes = HeatFacts { heat: "routes".parse().expect("a heat map"), edges: 0, ..facts };
    harness.state_mut().jams.heat = Some(routes);
    settle(&mut harness);
    harness.get_by_label("no routes: not available in lockstep and in recordings");
    harness.state_mut().jams.heat = Some(HeatFacts { has_routes: true, ..routes });
    settle(&mut harness);
    assert!(
        harness.query_by_label("no routes: not available in lockstep and in recordings").is_none()
    );
    harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    settle(&mut harness);
    assert!(!harness.state().interface.settings.heat);
}

#[test]
fn an_edge_tells_its_robots_and_its_traffic() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Edge(0)));
    let present = Presence { robots: 3, waiting: 1, listed: vec![0, 2, 4] };
    let mut facts = EdgeFacts { present, ..EdgeFacts::default() };
    harness.state_mut().jams.edges = vec![facts.clone()];
    settle(&mut harness);
    harness.get_by_label("regatta plugin traffic --fleet test");
    facts.traffic = Some(
        [EdgeTraffic { entered_per_hour: 1234.0, waiting_secs: 56.5, ..EdgeTraffic::default() }; 3],
    );
    harness.state_mut().jams.edges = vec![facts];
    settle(&mut harness);
    assert_eq!(harness.query_all_by_label("1,234").count(), 3);
    assert_eq!(harness.query_all_by_label("56.5").count(), 3);
    harness.get_by_label("robot 4").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(4)));
}

/// The place of a point of the ground in the window.
fn on_screen(harness: &Harness<'_, Fixture>, at: Vec2) -> egui::Pos2 {
    let (camera, picture) =
        (harness.state().interface.camera_controller.camera(), harness.state().picture);
    let at = camera
        .project(at.extend(0.0), Vec2::new(picture.width(), picture.height()))
        .expect("in sight");
    pos2(picture.left() + at.x, picture.top() + at.y)
}

#[test]
fn the_edge_under_the_pointer_tells_its_figures() {
    let mut harness = harness(Fixture::new(5));
    let (edge, beside) =
        (on_screen(&harness, Vec2::new(0.5, 1.0)), on_screen(&harness, Vec2::new(3.0, -3.0)));
    harness.hover_at(edge);
    settle(&mut harness);
    harness.get_by_label("edge 34");
    assert_eq!(
        harness.state().interface.watched_places(),
        (vec![0], None),
        "another thread counts its robots"
    );
    let figures = EdgeTraffic {
        occupancy: 1.5,
        entered_per_hour: 321.0,
        waiting_secs: 56.5,
        ..EdgeTraffic::default()
    };
    let present = Presence { robots: 7, waiting: 4, listed: vec![0] };
    let facts = EdgeFacts { present, ..EdgeFacts::default() };
    harness.state_mut().jams.edges = vec![facts.clone()];
    settle(&mut harness);
    harness.get_by_label("more with: regatta plugin traffic");
    harness.get_by_label("7");
    harness.state_mut().jams.edges = vec![EdgeFacts {
        traffic: Some([figures; 3]),
        period_secs: [65.0, 648.0, 3000.0],
        ..facts
    }];
    settle(&mut harness);
    for label in ["321", "56.5", "7", "4", "last 10\u{a0}min 48\u{a0}s"] {
        harness.get_by_label(label);
    }
    assert!(harness.query_by_label("robots on the edge").is_none(), "not without the heat map");
    let settings = &mut harness.state_mut().interface.settings;
    (settings.heat, settings.heat_of) = (true, "occupancy:run".parse().expect("a heat map"));
    settle(&mut harness);
    for label in ["1.5", "321", "contact, s", "the run so far (50\u{a0}min)"] {
        harness.get_by_label(label);
    }
    harness.state_mut().closed = vec![0];
    settle(&mut harness);
    harness.get_by_label("closed");
    harness.hover_at(beside);
    settle(&mut harness);
    assert!(harness.query_by_label("edge 34").is_none());
    assert_eq!(harness.state().interface.watched_places(), (vec![], None));
}

#[test]
fn in_the_past_only_the_robots_of_an_edge_are_told() {
    let mut fixture = Fixture::new(5);
    (fixture.is_past, fixture.interface.settings.edges) = (true, true);
    let mut harness = harness(fixture);
    let present = Presence { robots: 7, waiting: 4, listed: vec![0] };
    harness.state_mut().jams.edges = vec![EdgeFacts { present, ..EdgeFacts::default() }];
    let edge = on_screen(&harness, Vec2::new(0.5, 1.0));
    harness.hover_at(edge);
    settle(&mut harness);
    harness.get_by_label("edge 34");
    harness.get_by_label("5");
    assert!(harness.query_by_label("7").is_none(), "as many as there are now");
    assert!(harness.query_by_label("more with: regatta plugin traffic").is_none());
}

#[test]
fn a_hot_spot_is_flown_to_and_the_list_is_exported() {
    let mut harness = harness(Fixture::new(5));
    let spot = |x: f32, contact_secs| Spot {
        place: Vec2::new(x, 3.0),
        contact_secs,
        standing_secs: 10.0,
        seen: [61.0, 90.0],
        edges: vec![0],
        trend: Trend::Growing,
    };
    press(&mut harness, Key::Num7);
    harness.get_by_label("no robot has lost time");
    harness.get_by_label("since the start of the run");
    harness.state_mut().jams.known =
        Known { from_secs: 754.0, until_secs: 800.0, is_published: false };
    settle(&mut harness);
    harness.get_by_label("since 12:34, when this window began to watch");
    harness.state_mut().jams.known.is_published = true;
    settle(&mut harness);
    harness.get_by_label("since 12:34, when regatta plugin traffic began");
    harness.state_mut().jams.spots = [spot(40.0, 25.0), spot(7.0, 0.0)].into();
    settle(&mut harness);
    harness.get_by_label("45 robot-seconds lost");
    harness.get_by_label("hot spot 1").click();
    harness.run_steps(120);
    is_between_the_panels(&harness, Vec2::new(40.0, 3.0));
    assert_eq!(harness.state().interface.selection.item, Some(Item::Edge(0)));
    harness.get_by_label("export").click();
    settle(&mut harness);
    let written = harness.state().actions.iter().find_map(|action| match action {
        Action::Write { path, text } => Some((path.clone(), text.clone())),
        _ => None,
    });
    let (path, text) = written.expect("a file");
    assert_eq!((path.to_str(), text.lines().count()), (Some("hot-spots.csv"), 3));
    assert_eq!(text.lines().nth(1), Some("1,40.00,3.00,35.0,25.0,10.0,61.0,90.0,growing,34"));
    assert_eq!(copied(&mut harness, "copy all hot spots as a table"), text);
    harness.state_mut().interface.settings.left = Some(LeftPanel::Fleet);
    settle(&mut harness);
    let robots = copied(&mut harness, "copy these robots as a table");
    let head = "robot,activity,speed_m_s,edge,x_m,y_m,heading_deg,contact";
    assert_eq!((robots.lines().next(), robots.lines().count()), (Some(head), 6), "{robots}");
}

/// Clicks a button, and returns the text that it copies.
fn copied(harness: &mut Harness<'_, Fixture>, label: &str) -> String {
    harness.get_by_label(label).click();
    for _ in 0..4 {
        harness.step();
        for command in &harness.output().platform_output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                return text.clone();
            }
        }
    }
    panic!("{label} copies nothing");
}

/// The ring lies in the layer of the picture, over which panels are drawn: so it must be cut off
/// where they begin.
#[test]
fn the_ring_of_a_hot_spot_lies_over_no_panel() {
    let mut fixture = Fixture::new(5);
    fixture.jams.spots = [Spot {
        place: Vec2::new(40.0, 3.0),
        contact_secs: 25.0,
        standing_secs: 10.0,
        seen: [61.0, 90.0],
        edges: vec![0],
        trend: Trend::Growing,
    }]
    .into();
    fixture.interface.settings.left = Some(LeftPanel::Spots);
    let mut harness = harness(fixture);
    settle(&mut harness);
    let row = harness.get_by_label("hot spot 1");
    let panel = row.rect();
    row.click();
    harness.run_steps(120);
    let spot = on_screen(&harness, Vec2::new(40.0, 3.0));
    let rings = harness.output().shapes.iter().filter(
        |clipped| matches!(&clipped.shape, egui::Shape::Circle(circle) if circle.center.distance(spot) < 2.0 && circle.radius > 10.0),
    );
    let clips: Vec<_> = rings.map(|ring| ring.clip_rect).collect();
    assert!(!clips.is_empty(), "the ring is drawn");
    assert!(clips.iter().all(|clip| !clip.intersects(panel)), "{clips:?} over {panel}");
}

/// A window in which plots are high enough for the values of all lines.
const HIGH: [f32; 2] = [1280.0, 1000.0];

/// Clicks into the middle of the plot of touching pairs, at some time of the shown samples. While
/// the pointer is there, each plot tells that time.
fn click_into_a_plot(harness: &mut Harness<'_, Fixture>) {
    let title = harness.get_by_label("touching pairs").rect();
    let at = pos2(title.left() + 130.0, title.top() + 70.0);
    harness.hover_at(at);
    settle(harness);
    let times = harness.query_all_by_label_contains("at 0:").count()
        + harness.query_all_by_label_contains("at 1:").count();
    assert_eq!(times, 5, "each plot tells the same time");
    harness.drag_at(at);
    harness.drop_at(at);
    settle(harness);
}

/// The figures of a fleet of a hundred robots at a time: one robot more waits each second.
fn sample(second: u32) -> Sample {
    let mut activities = [0; Activity::COUNT];
    activities[Activity::Carrying as usize] = 100 - second;
    activities[Activity::Waiting as usize] = second;
    Sample {
        secs: f64::from(second),
        activities,
        touching: 2,
        mean_speed: 0.75,
        ..Sample::default()
    }
}

#[test]
fn plots_show_the_figures_at_the_time_under_the_pointer_and_a_click_looks_back() {
    let mut fixture = Fixture::new(5);
    fixture.jams.series = (0..=80).map(sample).collect();
    let mut harness = harness_of(HIGH, fixture);
    assert!(harness.query_by_label("mean speed, m/s").is_none());
    press(&mut harness, Key::Num8);
    harness.get_by_label("waiting 80");
    harness.get_by_label("carrying 20");
    harness.get_by_label("0.75");
    harness.get_by_label("not published");
    click_into_a_plot(&mut harness);
    harness.get_by_label("only the part of this run after 01:13.46 is kept");
    harness.state_mut().jams.series = (76..=82).map(sample).collect();
    settle(&mut harness);
    click_into_a_plot(&mut harness);
    let state = harness.state();
    let looks_back =
        |action: &&Action| matches!(action, Action::LookBack(Some(76_000_000_000..82_000_000_000)));
    assert_eq!(state.actions.iter().filter(looks_back).count(), 1, "{:?}", state.actions);
    assert!(
        state.requests().iter().all(|(kind, ..)| *kind != ControlKind::Seek),
        "a live run can't be sent back"
    );
}

#[test]
fn plots_of_a_recording_tell_what_is_shown_and_a_click_goes_there() {
    // The shown frame is at 83.456 s of its run, and at 3.2 s of the recording.
    let mut fixture = replay(3.2);
    fixture.jams.series = (0..=10).map(sample).collect();
    fixture.jams.known = Known { from_secs: 0.0, until_secs: 9.98, is_published: true };
    let mut harness = harness_of(HIGH, fixture);
    press(&mut harness, Key::Num8);
    harness.get_by_label("of the recording, 0:00\u{a0}to 0:10");
    harness.get_by_label("00:03.20");
    harness.get_by_label("waiting 3");
    assert_eq!(harness.query_all_by_label("at 0:03").count(), 5, "the figures at the shown time");
    click_into_a_plot(&mut harness);
    let seeks: Vec<_> = harness
        .state()
        .requests()
        .into_iter()
        .filter(|(kind, ..)| *kind == ControlKind::Seek)
        .collect();
    assert!(seeks.len() == 1 && (1_000_000_000..9_000_000_000).contains(&seeks[0].1), "{seeks:?}");
}
