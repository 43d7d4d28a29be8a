//! Layers, files, and programs that are started.

use super::*;

#[test]
fn panels_themes_and_colourings_have_keys_that_the_help_lists() {
    let mut harness = harness(Fixture::new(5));
    for (key, panel) in [
        (Key::Num3, RightPanel::Selection),
        (Key::Num4, RightPanel::View),
        (Key::Num5, RightPanel::Performance),
        (Key::Num6, RightPanel::Connection),
    ] {
        press(&mut harness, key);
        assert_eq!(harness.state().interface.settings.right, Some(panel));
    }
    press(&mut harness, Key::L);
    assert!(harness.state().interface.settings.light);
    let mut colours = Vec::new();
    for _ in 0..5 {
        press(&mut harness, Key::C);
        colours.push(harness.state().interface.settings.colour.clone());
    }
    assert_eq!(colours, ["state", "speed", "type", "battery", "automatic"]);
    press(&mut harness, Key::F1);
    harness.get_by_label("pause, resume");
    press(&mut harness, Key::Escape);
    assert!(harness.query_by_label("pause, resume").is_none());
}

#[test]
fn plans_of_all_robots_are_switched_on_and_say_what_they_lack() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.right = Some(RightPanel::View);
    let mut harness = harness(fixture);
    harness.get_by_label("routes and goals of all robots").click();
    settle(&mut harness);
    assert!(harness.state().interface.settings.plans);
    harness.get_by_label("nothing known yet");
    harness.get_by_label("goals: not published");
    let routes = Coverage { known: 640, under_way: 990, round_secs: f32::INFINITY };
    harness.state_mut().plans =
        PlanFacts { routes: Some(routes), has_goals: true, ..PlanFacts::default() };
    settle(&mut harness);
    harness.get_by_label("routes of 640\u{a0}of 990\u{a0}robots under way so far");
    harness.get_by_label("routes of 640\u{a0}of 990\u{a0}robots");
    harness.get_by_label("planned");
    let routes = Coverage { known: 985, under_way: 990, round_secs: 1.25 };
    harness.state_mut().plans =
        PlanFacts { routes: Some(routes), has_goals: true, ..PlanFacts::default() };
    settle(&mut harness);
    harness.get_by_label("routes of 985\u{a0}of 990\u{a0}robots under way, at most 1.2\u{a0}s old");
    assert!(
        harness.query_by_label("routes of 985\u{a0}of 990\u{a0}robots").is_none(),
        "nothing notable is missing"
    );
    press(&mut harness, Key::H);
    assert!(!harness.state().interface.settings.plans);
    assert!(harness.query_by_label("planned").is_none());
}

#[test]
fn who_waits_is_switched_on_and_counted() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::B);
    assert!(harness.state().interface.settings.waits);
    harness.get_by_label("who waits: not published");
    let waiting = Some(Waiting { robots: 17, in_rings: 4 });
    harness.state_mut().plans = PlanFacts { waiting, ..PlanFacts::default() };
    settle(&mut harness);
    harness.get_by_label("waits for (17)");
    harness.get_by_label("ring of waiting (4)");
    press(&mut harness, Key::Num4);
    harness.get_by_label("17\u{a0}robots wait, 4\u{a0}of them in rings");
}

#[test]
fn counts_of_plans_say_that_they_are_of_robots_that_match() {
    let mut fixture = Fixture::new(5);
    (fixture.interface.settings.plans, fixture.interface.settings.waits) = (true, true);
    fixture.interface.settings.right = Some(RightPanel::View);
    let routes = Coverage { known: 3, under_way: 9, round_secs: f32::INFINITY };
    fixture.plans = PlanFacts {
        is_filtered: true,
        routes: Some(routes),
        has_goals: true,
        waiting: Some(Waiting { robots: 2, in_rings: 0 }),
    };
    let harness = harness(fixture);
    for text in [
        "routes of 3\u{a0}of 9\u{a0}matching robots under way so far",
        "routes of 3\u{a0}of 9\u{a0}matching robots",
        "2\u{a0}matching robots wait, none of them in rings",
        "of matching robots:",
        "waits for (2)",
    ] {
        harness.get_by_label(text);
    }
}

#[test]
fn udp_is_started_with_the_typed_addresses() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::Num6);
    harness.get_by_label("Receive").click();
    settle(&mut harness);
    harness.get_by_label("Send").click();
    settle(&mut harness);
    let wanted = [
        Action::StartUdpSource {
            listen: "127.0.0.1:9870".into(),
            echo_to: None,
            offset: Vec2::ZERO,
        },
        Action::StartUdpSender { to: "127.0.0.1:9870".into() },
    ];
    let started: Vec<_> =
        harness.state().actions.iter().filter(|action| wanted.contains(action)).cloned().collect();
    assert_eq!(started, wanted);
}

#[test]
fn files_for_the_floor_and_the_robots_are_typed_or_dropped() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::Num4);
    harness.get_by_label("floor file").scroll_to_me();
    settle(&mut harness);
    let line = harness.get_by_label("floor file");
    line.focus();
    line.type_text("map.yaml");
    settle(&mut harness);
    harness.get_all_by_label("load").next().expect("a button").scroll_to_me();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "", "the file is not loaded yet");
    harness.get_all_by_label("load").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "map.yaml");
    harness.state_mut().interface.use_file(std::path::Path::new("tug.STL"));
    settle(&mut harness);
    let mesh = harness.state().interface.settings.mesh.clone().expect("a mesh");
    assert_eq!((mesh.file.as_str(), mesh.scale, mesh.z, mesh.yaw), ("tug.STL", 1.0, 0.0, 0.0));
    harness.get_all_by_label("remove").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "");
    assert!(harness.state().interface.settings.mesh.is_some());
    harness.get_by_label("add a lamp").scroll_to_me();
    settle(&mut harness);
    harness.get_by_label("add a lamp").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.lamps.len(), 1);
}

#[test]
fn a_panel_that_opens_in_a_narrow_window_closes_the_one_on_the_other_side() {
    for ([width, height], scale) in [([640.0, 400.0], 1.0), ([1280.0, 720.0], 1.5)] {
        let mut fixture = Fixture::new(5);
        fixture.interface.settings.scale = scale;
        let settings = &mut fixture.interface.settings;
        (settings.left, settings.right) = (Some(LeftPanel::Fleet), Some(RightPanel::View));
        let builder =
            Harness::builder().with_size([width / scale, height / scale]).with_max_steps(64);
        let mut harness =
            builder.build_ui_state(|ui, fixture: &mut Fixture| fixture.show(ui), fixture);
        settle(&mut harness);
        let open = |harness: &Harness<'_, Fixture>| {
            let settings = &harness.state().interface.settings;
            (settings.left, settings.right)
        };
        assert_eq!(open(&harness), (Some(LeftPanel::Fleet), None), "restored");
        press(&mut harness, Key::Num4);
        assert_eq!(open(&harness), (None, Some(RightPanel::View)));
        press(&mut harness, Key::Num2);
        assert_eq!(open(&harness), (Some(LeftPanel::Collisions), None));
    }
}

#[test]
fn the_veil_over_a_fleet_that_has_ended_leaves_the_panels_as_they_are_and_its_robots_are_counted() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    let panel = harness.get_by_label("robot 0").rect();
    (harness.state_mut().engine, harness.state_mut().status) = (EngineState::Gone, None);
    settle(&mut harness);
    harness.get_by_label("The engine has ended");
    let grey = egui::Color32::from_gray(128).gamma_multiply(0.55);
    let veils: Vec<egui::Rect> = harness
        .output()
        .shapes
        .iter()
        .filter_map(|clipped| match &clipped.shape {
            egui::Shape::Rect(shape) if shape.fill == grey => {
                Some(shape.rect.intersect(clipped.clip_rect))
            }
            _ => None,
        })
        .collect();
    assert_eq!(veils.len(), 1);
    assert!(!veils[0].intersects(panel), "{veils:?} {panel}");
    harness.get_by_value("50");
}

#[test]
fn cameras_of_everything_are_flown_to_as_those_of_a_place() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.right = Some(RightPanel::View);
    let bookmarks = ["dock=4,-3,12,1.57,0.9", "hall=fit", "roof=top", "chart=plan"];
    fixture.interface.bookmarks = bookmarks.map(|text| text.parse().expect("a bookmark")).into();
    let mut harness = harness(fixture);
    for (name, is_down, is_plan) in [
        ("dock", false, false),
        ("hall", false, false),
        ("roof", true, false),
        ("chart", true, true),
    ] {
        let before = harness.state().interface.camera_controller.camera();
        harness.get_by_label(name).click();
        harness.run_steps(80);
        let camera = harness.state().interface.camera_controller.camera();
        assert_ne!(camera, before, "{name}");
        assert_eq!((camera.pitch > 1.5, camera.is_plan()), (is_down, is_plan), "{name}");
        let picture = harness.state().picture;
        let corners = [Bounds::default().low, Bounds::default().high].map(|corner| {
            camera
                .project(corner.extend(0.0), Vec2::new(picture.width(), picture.height()))
                .expect("in sight")
        });
        let is_free =
            |at: &Vec2| (0.0..=1000.0).contains(&at.x) && (0.0..=picture.height()).contains(&at.y);
        assert!(name == "dock" || corners.iter().all(is_free), "{name}: {corners:?}");
    }
}

#[test]
fn the_strip_shows_the_figures_of_the_shown_run_only() {
    let mut harness = harness(Fixture::new(5));
    let run_id = harness.state().header.run_id;
    let figures = WorkFigures { orders_per_hour: 7_654.0, ..WorkFigures::default() };
    harness.state_mut().work = Some((run_id, figures));
    harness.run_steps(2);
    assert!(harness.query_by_label("7,654").is_some(), "the figures of this run");
    harness.state_mut().work = Some((run_id + 1, figures));
    harness.run_steps(2);
    assert!(harness.query_by_label("7,654").is_none(), "another run has other figures");
}

#[test]
fn the_strip_is_there_before_the_manager_has_published_its_figures() {
    let mut harness = harness(Fixture::new(5));
    harness.run_steps(2);
    assert!(harness.query_by_label("orders an hour").is_none(), "nobody manages this fleet");
    harness.state_mut().activities = vec![0.0; 5];
    harness.run_steps(2);
    assert!(harness.query_by_label("orders an hour").is_some());
    assert!(harness.query_all_by_label("–").count() >= 6, "nothing is known yet");
}
