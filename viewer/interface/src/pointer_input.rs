//! Input on the picture: mouse, touchpad, and keys that move the camera while they are held.

use egui::{
    Event, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Sense, Ui,
};
use glam::Vec2;

use super::keys;
use super::levels::PictureArea;
use super::state::{Drag, Interface};
use super::view_model::Action;

/// The zoom factor of one notch of the wheel.
const NOTCH: f32 = 1.18;
/// Camera speeds of held keys: distances to the target per second, radians per second, and the
/// natural logarithm of the zoom factor per second.
const TRANSLATE: f32 = 0.7;
const TURN: f32 = 1.2;
const ZOOM: f32 = 1.4;
/// The farthest that the pointer may move in a click, in points, as in egui.
const CLICK: f32 = 6.0;

impl Interface {
    /// Moves the camera by the input on the picture, and requests picks for clicks.
    ///
    /// Returns where the pointer is over it, unless it drags.
    pub(super) fn pointer_input(
        &mut self,
        ui: &Ui,
        area: PictureArea,
        actions: &mut Vec<Action>,
    ) -> Option<Pos2> {
        let PictureArea { picture, visible, whole } = area;
        let response = ui.interact(whole, ui.scope_id().with("picture"), Sense::click_and_drag());
        let size = glam(picture.size());
        self.handle_drag(ui, &response, picture, visible, size);
        let is_in = |at: Option<Pos2>| at.filter(|at| visible.contains(*at));
        if response.contains_pointer() && is_in(response.hover_pos()).is_some() {
            self.wheel(ui, picture, size);
        }
        if let Some(at) = is_in(response.interact_pointer_pos()) {
            let (window, at) = (glam(at.to_vec2()), glam(at - picture.min));
            if response.double_clicked() && self.measuring.is_none() {
                if let Some(place) = self.camera_controller.camera().unproject(at, size) {
                    self.camera_controller.fly_to(place);
                }
            } else if response.secondary_clicked() {
                actions.push(Action::Menu { at, window });
            } else if response.clicked() && self.measuring.is_some() {
                actions.push(Action::Measure { at });
            } else if response.clicked() {
                // The selection's panel must not move what the next click is aimed at.
                self.camera_controller.stay();
                let extend = ui.input(|input| input.modifiers.command);
                actions.push(Action::Pick { at, extend });
            }
        }
        self.held_keys(ui, size);
        is_in(response.hover_pos()).filter(|_| self.drag.is_none())
    }

    /// Handles the pointer event by event: where a picture takes long, a whole drag may happen
    /// between two pictures, which egui does not report as a drag.
    fn handle_drag(
        &mut self,
        ui: &Ui,
        response: &Response,
        picture: Rect,
        visible: Rect,
        size: Vec2,
    ) {
        let events = ui.input(|input| {
            let is_pointer = |event: &&Event| {
                matches!(event, Event::PointerButton { .. } | Event::PointerMoved(_))
            };
            input.events.iter().filter(is_pointer).cloned().collect::<Vec<_>>()
        });
        for event in events {
            match event {
                Event::PointerButton { pos, button, pressed: true, modifiers }
                    if self.drag.is_none() =>
                {
                    let drags_other = ui.ctx().dragged_id().is_some_and(|id| id != response.id);
                    if !drags_other
                        && visible.contains(pos)
                        && ui.ctx().layer_id_at(pos) == Some(ui.layer_id())
                    {
                        let is_plan = self.camera_controller.camera().is_plan();
                        let orbits =
                            button == PointerButton::Primary && !modifiers.shift && !is_plan;
                        self.drag = Some(Drag { button, orbits, at: pos, has_moved: false });
                    }
                }
                Event::PointerButton { pos, button, pressed: false, .. } => {
                    self.drag_to(pos, picture, size);
                    self.drag.take_if(|drag| drag.button == button);
                }
                Event::PointerMoved(pos) => self.drag_to(pos, picture, size),
                _ => {}
            }
        }
        if !ui.input(|input| input.pointer.any_down()) {
            self.drag = None;
        }
    }

    fn drag_to(&mut self, pos: Pos2, picture: Rect, size: Vec2) {
        let Some(drag) = &mut self.drag else { return };
        let delta = pos - drag.at;
        // The pointer may move a little in a click.
        drag.has_moved |= delta.length() > CLICK;
        if !drag.has_moved {
            return;
        }
        let from = std::mem::replace(&mut drag.at, pos);
        if drag.orbits {
            self.camera_controller.orbit(glam(delta));
        } else {
            self.camera_controller.pan(glam(from - picture.min), glam(pos - picture.min), size);
        }
    }

    fn wheel(&mut self, ui: &Ui, picture: Rect, size: Vec2) {
        let (events, pinch, cursor) = ui.input(|input| {
            let wheels = input.events.iter().filter_map(|event| match event {
                Event::MouseWheel { unit, delta, modifiers, source, .. } => {
                    // Not every system reports the device, but only wheels report lines.
                    let is_touchpad =
                        *source == MouseWheelSource::Trackpad || *unit == MouseWheelUnit::Point;
                    Some((is_touchpad, *delta, *modifiers))
                }
                _ => None,
            });
            (wheels.collect::<Vec<_>>(), input.zoom_delta(), input.pointer.hover_pos())
        });
        let cursor = cursor.map(|at| glam(at - picture.min));
        let mut zoomed = false;
        for (is_touchpad, delta, modifiers) in events {
            if !is_touchpad {
                zoomed = true;
                self.camera_controller.zoom(NOTCH.powf(-delta.y), cursor, size);
            } else if !modifiers.command {
                let at = cursor.unwrap_or(size / 2.0);
                self.camera_controller.pan(at, at + glam(delta), size);
            }
        }
        if !zoomed && (pinch - 1.0).abs() > 1e-4 {
            self.camera_controller.zoom(1.0 / pinch, cursor, size);
        }
    }

    fn held_keys(&mut self, ui: &Ui, size: Vec2) {
        let motion = keys::held(ui.ctx());
        if motion == keys::CameraMotion::default() {
            return;
        }
        // The first picture after a pause comes long after the last one.
        let seconds = ui.input(|input| input.stable_dt).min(0.05);
        let [right, forward, left, down, out] = motion.0.map(|part| part * seconds);
        if right != 0.0 || forward != 0.0 {
            self.camera_controller.translate(right * TRANSLATE, forward * TRANSLATE);
        }
        if left != 0.0 || down != 0.0 {
            self.camera_controller.turn(left * TURN, down * TURN);
        }
        if out != 0.0 {
            self.camera_controller.zoom((out * ZOOM).exp(), None, size);
        }
        ui.ctx().request_repaint();
    }
}

fn glam(vector: egui::Vec2) -> Vec2 {
    Vec2::new(vector.x, vector.y)
}
