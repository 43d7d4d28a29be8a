//! Checks of each window: no control, text or element over the picture lies over another one, and
//! none is cut.

use egui::epaint::{ClippedShape, TextShape};
use egui::{Id, Rect, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;

use crate::fixture::{Fixture, window_in_points};

/// Parts of the names of rows of lists.
const ROWS: [&str; 3] = ["'robot ", "'acknowledge ", " broke down "];

/// Checks the controls in panels, of which the ones below the window's end are scrolled to: none is
/// cut at its sides, and no two that are in sight overlap. Returns how many are in sight.
pub fn check_panels(
    harness: &Harness<'_, Fixture>,
    [width, height]: [f32; 2],
    what: &str,
) -> usize {
    let scale = harness.state().interface.settings.scale;
    // Between the bar at the top and the one at the bottom.
    let area =
        Rect::from_min_max(egui::pos2(0.0, 42.0), egui::pos2(width / scale, height / scale - 48.0));
    let in_sight = |rect: &Rect| rect.top() >= area.top() && rect.bottom() <= area.bottom();
    // Rows of lists are drawn beyond the ends of their lists, and cut there.
    let is_row = |name: &str| ROWS.iter().any(|row| name.contains(row));
    let all = controls(harness).into_iter();
    let controls: Vec<_> = all.filter(|(name, rect)| in_sight(rect) && !is_row(name)).collect();
    no_overlap(&controls, area, what);
    controls.len()
}

/// Checks the controls of the bars: they are whole, and don't overlap. `area` is the window, in
/// points.
pub fn check(harness: &Harness<'_, Fixture>, size: [f32; 2], what: &str) {
    let scale = harness.state().interface.settings.scale;
    let area = window_in_points(size, scale);
    let controls = controls(harness);
    assert!(controls.len() > 4, "{what}: {controls:?}");
    no_overlap(&controls, area, what);
    let bars = harness
        .state()
        .panels
        .iter()
        .filter(|(name, _)| ["top", "bottom", "timeline"].contains(name));
    for (bar, place) in bars {
        let of_bar = controls.iter().filter(|(_, rect)| place.contains(rect.center()));
        of_bar.for_each(|(name, rect)| {
            assert!(place.contains_rect(*rect), "{what}: {name} {rect} in {bar} {place}")
        });
    }
}

/// The names and places of all controls.
fn controls(harness: &Harness<'_, Fixture>) -> Vec<(String, Rect)> {
    let is_control = |role: egui::accesskit::Role| {
        use egui::accesskit::Role::{Button, CheckBox, ComboBox, Slider, SpinButton, TextInput};
        matches!(role, Button | CheckBox | ComboBox | Slider | SpinButton | TextInput)
    };
    let mut controls = Vec::new();
    for node in harness.root().children_recursive() {
        let (role, name) =
            (node.accesskit_node().role(), node.accesskit_node().label().unwrap_or_default());
        if is_control(role) && node.rect().is_positive() {
            controls.push((format!("{role:?} '{name}'"), node.rect()));
        }
    }
    controls
}

fn no_overlap(controls: &[(String, Rect)], area: Rect, what: &str) {
    for (i, (name, rect)) in controls.iter().enumerate() {
        assert!(
            area.expand(0.6).contains_rect(*rect),
            "{what}: {name} at {rect:?} is cut by {area:?}"
        );
        for (other, beside) in &controls[..i] {
            let common = rect.intersect(*beside);
            let nested =
                rect.expand(0.5).contains_rect(*beside) || beside.expand(0.5).contains_rect(*rect);
            let overlap = common.width() > 0.6 && common.height() > 0.6 && !nested;
            assert!(!overlap, "{what}: {name} {rect:?} over {other} {beside:?}");
        }
    }
}

/// Checks that what lies over the picture lies over no bar, no panel, no control and nothing else.
pub fn check_placed(harness: &Harness<'_, Fixture>, what: &str) {
    let fixture = harness.state();
    let placed = fixture.interface.placed();
    for (i, (name, place)) in placed.iter().enumerate() {
        let covers = |other: &Rect| {
            let common = place.intersect(*other);
            common.width() > 0.6 && common.height() > 0.6
        };
        // The drawing has the size of its place.
        let area = harness.ctx.memory(|memory| memory.area_rect(Id::unique(*name)));
        assert!(
            area.is_none_or(|area| place.expand(1.0).contains_rect(area)),
            "{what}: {name} {area:?} in {place}"
        );
        let others = fixture.panels.iter().chain(&placed[..i]);
        for (other, at) in others {
            assert!(!covers(at), "{what}: {name} {place} lies over {other} {at}");
        }
        let own = ["minimap", "view cube"];
        for (other, at) in controls(harness) {
            assert!(
                !covers(&at) || own.iter().any(|own| other.contains(own)),
                "{what}: {name} {place} over {other} {at}"
            );
        }
    }
}

/// Checks that no text is cut at its sides, and that no line ends between a number and what
/// follows.
pub fn check_texts(harness: &Harness<'_, Fixture>, what: &str) {
    for (text, place, clip) in texts(harness) {
        let (galley, is_in_sight) = (&text.galley, place.intersects(clip));
        let words = galley.text();
        let is_within = place.left() >= clip.left() - 1.0 && place.right() <= clip.right() + 1.0;
        assert!(!is_in_sight || is_within, "{what}: '{words}' at {place} is cut by {clip}");
        for rows in galley.rows.windows(2) {
            let ends: Vec<char> = rows
                .iter()
                .map(|row| row.text())
                .filter_map(|row| row.trim_end().chars().last())
                .collect();
            let breaks =
                !rows[0].ends_with_newline && ends.first().is_some_and(char::is_ascii_digit);
            assert!(!breaks, "{what}: a line of '{words}' ends with a number");
        }
    }
}

/// All texts, with their places and what they are cut by, in points.
pub fn texts<'a>(harness: &'a Harness<'_, Fixture>) -> Vec<(&'a TextShape, Rect, Rect)> {
    let mut texts = Vec::new();
    for ClippedShape { clip_rect, shape, .. } in &harness.output().shapes {
        collect(shape, *clip_rect, &mut texts);
    }
    texts
}

fn collect<'a>(shape: &'a Shape, clip: Rect, texts: &mut Vec<(&'a TextShape, Rect, Rect)>) {
    match shape {
        Shape::Text(text) => {
            texts.push((text, text.galley.rect.translate(text.pos.to_vec2()), clip))
        }
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, clip, texts)),
        _ => {}
    }
}
