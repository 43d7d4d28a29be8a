//! Mouse, touchpad and held keys on the picture.

use egui::{Event, MouseWheelSource, MouseWheelUnit, PointerButton, Rect, Response, Sense, Ui};
use glam::Vec2;

use super::Interface;
use super::facts::Action;
use super::keys;

/// How much farther one notch of a wheel goes.
const NOTCH: f32 = 1.18;
/// Speeds of held keys: parts of the distance a second, radians a second, powers of e a second.
const WALK: f32 = 0.7;
const TURN: f32 = 1.2;
const ZOOM: f32 = 1.4;

impl Interface {
    /// Lets the hands that are on the picture move the camera.
    pub(super) fn hands(&mut self, ui: &Ui, picture: Rect, actions: &mut Vec<Action>) {
        let response = ui.interact(picture, ui.scope_id().with("picture"), Sense::click_and_drag());
        let size = glam(picture.size());
        self.drag(ui, &response, picture, size);
        if response.contains_pointer() {
            self.wheel(ui, picture, size);
        }
        if let Some(at) = response.interact_pointer_pos() {
            let at = glam(at - picture.min);
            if response.double_clicked() {
                if let Some(place) = self.rig.camera().unproject(at, size) {
                    self.rig.fly_to(place);
                }
            } else if response.clicked() {
                actions.push(Action::Pick(at));
            }
        }
        self.keys_held(ui, size);
    }

    fn drag(&mut self, ui: &Ui, response: &Response, picture: Rect, size: Vec2) {
        if !response.dragged() {
            return;
        }
        let delta = response.drag_delta();
        let shift = ui.input(|input| input.modifiers.shift);
        if response.dragged_by(PointerButton::Primary) && !shift {
            self.rig.orbit(glam(delta));
        } else if let Some(at) = response.interact_pointer_pos() {
            let to = at - picture.min;
            self.rig.pan(glam(to - delta), glam(to), size);
        }
    }

    fn wheel(&mut self, ui: &Ui, picture: Rect, size: Vec2) {
        let (events, pinch, cursor) = ui.input(|input| {
            let wheels = input.events.iter().filter_map(|event| match event {
                Event::MouseWheel { unit, delta, modifiers, source, .. } => {
                    // Not every system says what it was, but only wheels count in lines.
                    let fingers = *source == MouseWheelSource::Trackpad || *unit == MouseWheelUnit::Point;
                    Some((fingers, *delta, *modifiers))
                }
                _ => None,
            });
            (wheels.collect::<Vec<_>>(), input.zoom_delta(), input.pointer.hover_pos())
        });
        let cursor = cursor.map(|at| glam(at - picture.min));
        let mut zoomed = false;
        for (fingers, delta, modifiers) in events {
            if !fingers {
                zoomed = true;
                self.rig.zoom(NOTCH.powf(-delta.y), cursor, size);
            } else if !modifiers.command {
                let at = cursor.unwrap_or(size / 2.0);
                self.rig.pan(at, at + glam(delta), size);
            }
        }
        if !zoomed && (pinch - 1.0).abs() > 1e-4 {
            self.rig.zoom(1.0 / pinch, cursor, size);
        }
    }

    fn keys_held(&mut self, ui: &Ui, size: Vec2) {
        let hold = keys::held(ui.ctx());
        if hold == keys::Hold::default() {
            return;
        }
        // A first picture after a rest comes long after the last one.
        let seconds = ui.input(|input| input.stable_dt).min(0.05);
        let [right, forward, left, steeper, farther] = hold.0.map(|part| part * seconds);
        if right != 0.0 || forward != 0.0 {
            self.rig.walk(right * WALK, forward * WALK);
        }
        if left != 0.0 || steeper != 0.0 {
            self.rig.turn(left * TURN, steeper * TURN);
        }
        if farther != 0.0 {
            self.rig.zoom((farther * ZOOM).exp(), None, size);
        }
        ui.ctx().request_repaint();
    }
}

fn glam(vector: egui::Vec2) -> Vec2 {
    Vec2::new(vector.x, vector.y)
}
