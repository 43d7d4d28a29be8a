//! Bars, panels, menus and the help.

use egui::accesskit::Role;
use egui::{Key, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::ColumnsMut;
use regatta_viewer::interface::settings::{LeftPanel, RightPanel};
use regatta_viewer::interface::style::{color32, colours};
use regatta_viewer::interface::view_model::Item;
use regatta_viewer::palette::{Colouring, Scale, Theme};

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
        for right in [RightPanel::Performance, RightPanel::Selection, RightPanel::View, RightPanel::Connection] {
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
            let (colour, panel) = (colours(Theme::Dark).text, harness.state().panel("left").expect("it is open"));
            let is_handle = |shape: &Shape| match shape {
                Shape::Rect(bar) => bar.fill == colour && bar.rect.width() < 8.0 && panel.contains(bar.rect.center()),
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
        assert!(last.right() <= area.right() && last.left() >= area.left(), "{size:?} at {scale}: {last:?} {area:?}");
    }
}
