//! Mouse, touchpad and held keys on the picture.

use egui::{Event, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Sense, Ui};
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
/// Points that the pointer may stray in a click, as egui counts it.
const CLICK: f32 = 6.0;

/// A button held on the picture.
#[derive(Debug)]
pub(super) struct Grip {
    button: PointerButton,
    /// Turns the look; else moves it.
    turns: bool,
    at: Pos2,
    moves: bool,
}

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
                let beside = ui.input(|input| input.modifiers.command);
                actions.push(Action::Pick { at, beside });
            }
        }
        self.keys_held(ui, size);
    }

    /// Follows the pointer event by event: where a picture takes long, a whole drag lies between two of them, which egui
    /// takes for none.
    fn drag(&mut self, ui: &Ui, response: &Response, picture: Rect, size: Vec2) {
        let events = ui.input(|input| {
            let pointer = |event: &&Event| matches!(event, Event::PointerButton { .. } | Event::PointerMoved(_));
            input.events.iter().filter(pointer).cloned().collect::<Vec<_>>()
        });
        for event in events {
            match event {
                Event::PointerButton { pos, button, pressed: true, modifiers } if self.grip.is_none() => {
                    let others = ui.ctx().dragged_id().is_some_and(|id| id != response.id);
                    if !others && picture.contains(pos) && ui.ctx().layer_id_at(pos) == Some(ui.layer_id()) {
                        let turns = button == PointerButton::Primary && !modifiers.shift;
                        self.grip = Some(Grip { button, turns, at: pos, moves: false });
                    }
                }
                Event::PointerButton { pos, button, pressed: false, .. } => {
                    self.drag_to(pos, picture, size);
                    self.grip.take_if(|grip| grip.button == button);
                }
                Event::PointerMoved(pos) => self.drag_to(pos, picture, size),
                _ => {}
            }
        }
        if !ui.input(|input| input.pointer.any_down()) {
            self.grip = None;
        }
    }

    fn drag_to(&mut self, pos: Pos2, picture: Rect, size: Vec2) {
        let Some(grip) = &mut self.grip else { return };
        let delta = pos - grip.at;
        // A click may tremble.
        grip.moves |= delta.length() > CLICK;
        if !grip.moves {
            return;
        }
        let from = std::mem::replace(&mut grip.at, pos);
        if grip.turns {
            self.rig.orbit(glam(delta));
        } else {
            self.rig.pan(glam(from - picture.min), glam(pos - picture.min), size);
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
