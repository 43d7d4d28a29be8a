//! Bars, panels, menus and the help.

use egui::accesskit::{Action, Role};
use egui::{Key, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable, by};
use regatta_interface::settings::{LeftPanel, RightPanel};
use regatta_interface::style::{color32, colours};
use regatta_interface::view_model::Item;
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::{ColumnsMut, RobotState};
use regatta_scene::palette::{Colouring, Scale, Theme};

use crate::checks::{check, check_panels, check_placed, check_texts, texts};
use crate::fixture::{Fixture, PANELS, USUAL, harness, harness_of, window_in_points, windows};
use crate::states::{log, log_of, plots, recording};

#[test]
fn the_bars_fit_into_windows_of_all_sizes() {
    for (size, scale) in windows() {
        let harness = harness(size, scale, |_| {});
        let what = format!("{size:?} at {scale}");
        check(&harness, size, &what);
        check_texts(&harness, &what);
        check_placed(&harness, &what);
    }
}

#[test]
fn panels_fit_into_windows_of_all_sizes() {
    let mut controls = 0;
    for (size, scale) in windows() {
        for right in [
            RightPanel::Performance,
            RightPanel::Selection,
            RightPanel::View,
            RightPanel::Connection,
        ] {
            // A narrow window has room for one panel.
            let left = (size[0] / scale >= 900.0).then_some(LeftPanel::Fleet);
            let harness = harness(size, scale, |interface| {
                interface.select(Some(Item::Robot(3)));
                (interface.settings.left, interface.settings.right) = (left, Some(right));
            });
            let links = harness.query_all_by_label("robot 3").count();
            assert_eq!(links > 0, left.is_some(), "the list of robots: {size:?} at {scale}");
            let what = format!("{right:?}, {size:?} at {scale}");
            controls += check_panels(&harness, size, &what);
            check_texts(&harness, &what);
            check_placed(&harness, &what);
        }
    }
    assert!(controls > 200, "{controls} controls were compared");
}

#[test]
fn everything_that_can_be_clicked_has_a_name() {
    for left in [LeftPanel::Fleet, LeftPanel::Collisions, LeftPanel::Spots, LeftPanel::Log] {
        for right in [
            RightPanel::Performance,
            RightPanel::Selection,
            RightPanel::View,
            RightPanel::Connection,
        ] {
            let harness = harness([1600.0, 1000.0], 1.0, |interface| {
                interface.select(Some(Item::Robot(3)));
                (interface.settings.left, interface.settings.right) = (Some(left), Some(right));
            });
            let nameless = by().recursive(true).predicate(|node| {
                let has_name = node.label().is_some_and(|label| !label.is_empty());
                node.data().supports_action(Action::Click) && !has_name
            });
            let roles: Vec<_> =
                harness.query_all(nameless).map(|node| node.accesskit_node().role()).collect();
            // egui's own scroll bars have none.
            let mut named = roles.iter().filter(|role| **role != Role::ScrollBar);
            assert_eq!(named.next(), None, "{left:?}, {right:?}: {roles:?}");
        }
    }
}

#[test]
fn the_menu_and_the_log_fit_into_windows_of_all_sizes() {
    for (size, scale) in windows() {
        let mut menu = harness(size, scale, |interface| {
            interface.select(Some(Item::Robot(3)));
            interface.settings.right = None;
            interface.open_menu(Some(Item::Robot(3)), egui::pos2(size[0], size[1]) / scale);
        });
        menu.run_steps(4);
        menu.get_by_label("Break down");
        check(&menu, size, &format!("menu, {size:?} at {scale}"));
        let log = harness_of(size, scale, log);
        log.get_by_label("40 alarms");
        log.get_by_label("text of entries");
        check_panels(&log, size, &format!("log, {size:?} at {scale}"));
    }
}

#[test]
fn alarms_that_do_not_fit_have_a_scroll_bar() {
    for (size, scale) in windows() {
        let handles = |alarms: u32| {
            let harness = harness_of(size, scale, |fixture| log_of(fixture, alarms));
            let (colour, panel) =
                (colours(Theme::Dark).text, harness.state().panel("left").expect("it is open"));
            let is_handle = |shape: &Shape| match shape {
                Shape::Rect(bar) => {
                    bar.fill == colour
                        && bar.rect.width() < 8.0
                        && panel.contains(bar.rect.center())
                }
                _ => false,
            };
            harness.output().shapes.iter().filter(|clipped| is_handle(&clipped.shape)).count()
        };
        assert_eq!([handles(1), handles(40)], [0, 1], "{size:?} at {scale}");
    }
}

#[test]
fn lists_fit_into_windows_of_all_sizes() {
    for (size, scale) in windows() {
        for left in [LeftPanel::Fleet, LeftPanel::Collisions, LeftPanel::Spots] {
            let harness = harness(size, scale, |interface| interface.settings.left = Some(left));
            let what = format!("{left:?}, {size:?} at {scale}");
            check_panels(&harness, size, &what);
            check_texts(&harness, &what);
        }
    }
}

/// Long values, and all states.
fn long_list(fixture: &mut Fixture) {
    let columns = ColumnsMut::split(&mut fixture.lines, 20);
    (columns.x[3], columns.y[3], columns.theta[3], columns.speed[3]) =
        (-1234.56, -1234.56, -core::f32::consts::PI, 12.345);
    (0..8).for_each(|state| columns.state[state] = state as u8);
    fixture.world.edges[0].id = 123_456;
    fixture.pairs = vec![ContactRecord { robots: [2, 3], level: 2, ..ContactRecord::default() }];
    fixture.contacts = Some(ContactHeader { touching: 1, ..ContactHeader::default() });
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
}

#[test]
fn the_list_of_robots_tells_what_they_do_and_its_columns_have_gaps() {
    for (size, scale) in windows() {
        let harness = harness_of(size, scale, long_list);
        let panel = harness.state().panel("left").expect("it is open");
        let all = texts(&harness);
        let mut row: Vec<_> = all
            .iter()
            .filter(|(_, place, _)| place.width() >= 1.0 && panel.contains(place.center()))
            .collect();
        row.sort_by(|(_, a, _), (_, b, _)| {
            (a.center().y.round(), a.left())
                .partial_cmp(&(b.center().y.round(), b.left()))
                .expect("numbers")
        });
        for pair in row.windows(2) {
            let [(one, a, _), (other, b, _)] = [pair[0], pair[1]];
            let gap = b.left() - a.right();
            let is_one_row = (a.center().y - b.center().y).abs() < 3.0;
            assert!(
                !is_one_row || gap > 3.0,
                "{size:?} at {scale}: '{}' {gap} '{}'",
                one.galley.text(),
                other.galley.text()
            );
        }
        // The smallest window has room for two rows, which are scrolled.
        let has_room = panel.height() > 250.0;
        let shown: Vec<_> = row
            .iter()
            .filter(|(text, ..)| !text.galley.elided)
            .map(|(text, ..)| text.galley.text())
            .collect();
        for text in ["activity", "speed", "edge", "contact", "moving", "123456"] {
            assert!(shown.contains(&text), "{size:?} at {scale}: {text} in {shown:?}");
        }
        for text in ["12.3", "touching"] {
            assert!(!has_room || shown.contains(&text), "{size:?} at {scale}: {text} in {shown:?}");
        }
    }
}

#[test]
fn the_list_of_robots_has_room_for_each_activity() {
    for (size, scale) in windows() {
        let harness = harness_of(size, scale, |fixture| {
            let columns = ColumnsMut::split(&mut fixture.lines, 20);
            columns.state[..Activity::COUNT].fill(RobotState::Driving as u8);
            fixture.activities = Some((0..20).map(|number| number as f32).collect());
            fixture.interface.settings.left = Some(LeftPanel::Fleet);
        });
        let cut: Vec<_> = texts(&harness)
            .iter()
            .filter(|(text, ..)| text.galley.elided)
            .map(|(text, ..)| text.galley.text().to_owned())
            .collect();
        for activity in Activity::ALL {
            assert!(
                !cut.iter().any(|text| text == activity.name()),
                "{size:?} at {scale}: {cut:?}"
            );
        }
    }
}

#[test]
fn the_arrow_of_the_command_touches_no_heading() {
    for (size, scale) in windows() {
        let mut harness = harness_of(size, scale, long_list);
        for name in ["id", "activity", "speed", "edge"] {
            harness.get_by_label(&format!("sort by {name}")).click();
            harness.run_steps(3);
            let headings: Vec<_> = texts(&harness).iter().map(|(_, place, _)| *place).collect();
            let header = harness.get_by_label("sort by activity").rect();
            let header = header
                .with_min_x(0.0)
                .with_max_x(harness.state().panel("left").expect("it is open").right());
            let arrows =
                harness.output().shapes.iter().filter_map(|clipped| match &clipped.shape {
                    Shape::Path(path) if header.contains(path.visual_bounding_rect().center()) => {
                        Some(path.visual_bounding_rect())
                    }
                    _ => None,
                });
            let arrows: Vec<_> = arrows.collect();
            assert_eq!(arrows.len(), 1, "{size:?} at {scale}: sorted by {name}");
            let touched = headings
                .iter()
                .find(|place| place.shrink2(egui::vec2(0.0, 3.0)).intersects(arrows[0]));
            assert_eq!(touched, None, "{size:?} at {scale}: sorted by {name}, {arrows:?}");
        }
    }
}

#[test]
fn states_have_one_colour_in_lists_and_in_the_picture() {
    for theme in [Theme::Dark, Theme::Light] {
        let harness = harness_of(USUAL, 1.0, |fixture| {
            long_list(fixture);
            fixture.interface.settings.light = theme == Theme::Light;
            fixture.interface.select(Some(Item::Robot(3)));
        });
        let dots: Vec<_> = harness
            .output()
            .shapes
            .iter()
            .filter_map(|clipped| match &clipped.shape {
                Shape::Circle(circle) => Some(circle.fill),
                _ => None,
            })
            .collect();
        let Scale::Categories(states) = Colouring::State.legend(theme, &[], None).scale else {
            panic!("states")
        };
        for (name, colour) in &states {
            assert!(dots.contains(&color32(*colour)), "{name}: {dots:?}");
        }
        // In the list and in the panel of the selection.
        let held = dots.iter().filter(|dot| **dot == color32(states[3].1)).count();
        assert_eq!(held, 2, "{dots:?}");
    }
}

#[test]
fn the_help_fits_into_windows_of_all_sizes() {
    for (size, scale) in windows() {
        let mut harness = harness(size, scale, |_| {});
        harness.key_press(Key::F1);
        harness.run_steps(6);
        let title = harness.get_by_label("Keys and mouse").rect();
        let last = harness.get_by_label("close the window").rect();
        let area = window_in_points(size, scale);
        assert!(area.contains_rect(title), "{size:?} at {scale}: {title:?}");
        // Texts below the window's end are scrolled to; none is beside it.
        assert!(
            last.right() <= area.right() && last.left() >= area.left(),
            "{size:?} at {scale}: {last:?} {area:?}"
        );
    }
}

/// Checks that no bar or panel lies over another one, nor the line at the side of one.
fn check_apart(harness: &Harness<'_, Fixture>, size: [f32; 2], scale: f32, what: &str) {
    let open: Vec<_> =
        PANELS.iter().filter_map(|name| Some((*name, harness.state().panel(name)?))).collect();
    for (i, (name, place)) in open.iter().enumerate() {
        assert!(
            window_in_points(size, scale).expand(0.6).contains_rect(*place),
            "{what}: {name} {place}"
        );
        for (other, at) in &open[..i] {
            let common = place.intersect(*at);
            assert!(
                common.width() < 1.1 || common.height() < 1.1,
                "{what}: {name} {place} over {other} {at}"
            );
        }
    }
}

#[test]
fn panels_and_bars_lie_beside_each_other_in_low_windows() {
    for (size, scale) in windows() {
        for (kind, prepare) in [("live", plots as fn(&mut Fixture)), ("recording", recording)] {
            for left in [LeftPanel::Log, LeftPanel::Fleet] {
                let mut harness = harness_of(size, scale, |fixture| {
                    log(fixture);
                    prepare(fixture);
                    (fixture.interface.settings.left, fixture.interface.settings.plots) =
                        (Some(left), true);
                });
                check_apart(
                    &harness,
                    size,
                    scale,
                    &format!("{left:?}, {kind}, {size:?} at {scale}"),
                );
                for key in [Key::Num9, Key::Num8, Key::Num4, Key::Num8, Key::Num9] {
                    harness.key_press(key);
                    harness.run_steps(4);
                    let what = format!("{left:?}, {kind}, {size:?} at {scale}, after {key:?}");
                    check_apart(&harness, size, scale, &what);
                }
            }
        }
    }
}

#[test]
fn sliders_have_rails_or_are_numbers() {
    for (size, scale) in windows() {
        for (kind, prepare) in [("live", plots as fn(&mut Fixture)), ("recording", recording)] {
            let harness = harness_of(size, scale, prepare);
            let bar = harness.state().panel("bottom").expect("it is shown");
            let sliders = harness
                .root()
                .children_recursive()
                .filter(|node| node.accesskit_node().role() == Role::Slider);
            let rails: Vec<_> = sliders
                .map(|node| node.rect())
                .filter(|rect| bar.contains(rect.center()))
                .collect();
            assert!(
                rails.iter().all(|rail| rail.width() >= 40.0),
                "{kind}, {size:?} at {scale}: {rails:?}"
            );
            assert!(
                kind == "live" || !rails.is_empty(),
                "{kind}, {size:?} at {scale}: there is room"
            );
        }
    }
}

#[test]
fn lists_of_choices_and_hints_are_whole() {
    for scale in [1.0, 1.5] {
        for (left, list, last) in [
            (LeftPanel::Fleet, "filter: activity", "broken"),
            (LeftPanel::Log, "kind of entries", "notes"),
        ] {
            let mut harness =
                harness(USUAL, scale, |interface| interface.settings.left = Some(left));
            harness.get_by_label(list).click();
            harness.run_steps(6);
            let all = texts(&harness);
            let found = all.iter().find(|(text, ..)| text.galley.text() == last);
            let (_, place, clip) = found.unwrap_or_else(|| panic!("{list} at {scale}: {last}"));
            assert!(
                clip.contains_rect(place.shrink(1.0)),
                "{list} at {scale}: {last} {place} is cut by {clip}"
            );
        }
    }
    for (size, scale) in windows() {
        let harness = harness_of(size, scale, log);
        let all = texts(&harness);
        let hint = all
            .iter()
            .find(|(text, ..)| text.galley.text().starts_with("text, or #7"))
            .expect("a hint");
        assert!(!hint.0.galley.elided && hint.2.contains_rect(hint.1), "{size:?} at {scale}");
    }
}
