//! Input on the picture: mouse, touchpad, and keys that move the camera while they are held.

use egui::{
    Event, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Role, Sense, Ui,
    WidgetInfo,
};
use glam::Vec2;

use super::camera_controller::CameraController;
use super::keys;
use super::levels::PictureArea;
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

/// The input on the picture.
#[derive(Debug, Default)]
pub(super) struct PointerInput {
    drag: Option<Drag>,
}

/// A pointer button held down on the picture.
#[derive(Debug)]
struct Drag {
    button: PointerButton,
    /// Whether the drag orbits the camera; otherwise it pans.
    orbits: bool,
    /// The last position of the pointer, in points.
    at: Pos2,
    /// Whether the pointer has moved farther than in a click.
    has_moved: bool,
}

impl PointerInput {
    /// Whether a button is held down on the picture.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// Moves the camera by the input on the picture, and requests picks for clicks.
    ///
    /// Returns where the pointer is over it, unless it drags.
    pub fn handle(
        &mut self,
        ui: &Ui,
        area: PictureArea,
        camera: &mut CameraController,
        is_measuring: bool,
        actions: &mut Vec<Action>,
    ) -> Option<Pos2> {
        let PictureArea { picture, visible, whole } = area;
        let response = ui.interact(whole, ui.scope_id().with("picture"), Sense::click_and_drag());
        let info = || WidgetInfo::labeled(Role::Image, true, "picture of the fleet");
        response.widget_info(info);
        let size = area.size();
        self.drag(ui, &response, area, camera);
        let hovered = response.hover_pos().filter(|at| visible.contains(*at));
        if response.contains_pointer() && hovered.is_some() {
            wheel(ui, picture, size, camera);
        }
        if let Some(at) = response.interact_pointer_pos().filter(|at| visible.contains(*at)) {
            let (window, at) = (glam(at.to_vec2()), glam(at - picture.min));
            if response.double_clicked() && !is_measuring {
                if let Some(place) = camera.camera().unproject(at, size) {
                    camera.fly_to(place);
                }
            } else if response.secondary_clicked() {
                actions.push(Action::Menu { at, window });
            } else if response.clicked() && is_measuring {
                actions.push(Action::Measure { at });
            } else if response.clicked() {
                // The selection's panel must not move the target of the next click.
                camera.stay();
                let extend = ui.input(|input| input.modifiers.command);
                actions.push(Action::Pick { at, extend });
            }
        }
        held_keys(ui, size, camera);
        hovered.filter(|_| self.drag.is_none())
    }

    /// Handles the pointer event by event: where a picture takes long, a whole drag may happen
    /// between two pictures, which egui does not report as a drag.
    fn drag(
        &mut self,
        ui: &Ui,
        response: &Response,
        area: PictureArea,
        camera: &mut CameraController,
    ) {
        let events: Vec<_> = ui.input(|input| {
            let pointer = input.events.iter().filter(|event| {
                matches!(event, Event::PointerButton { .. } | Event::PointerMoved(_))
            });
            pointer.cloned().collect()
        });
        for event in events {
            match event {
                Event::PointerButton { pos, button, pressed: true, modifiers }
                    if self.drag.is_none() =>
                {
                    let drags_other = ui.ctx().dragged_id().is_some_and(|id| id != response.id);
                    if !drags_other
                        && area.visible.contains(pos)
                        && ui.ctx().layer_id_at(pos) == Some(ui.layer_id())
                    {
                        let is_plan = camera.camera().is_plan();
                        let orbits =
                            button == PointerButton::Primary && !modifiers.shift && !is_plan;
                        self.drag = Some(Drag { button, orbits, at: pos, has_moved: false });
                    }
                }
                Event::PointerButton { pos, button, pressed: false, .. } => {
                    self.drag_to(pos, area, camera);
                    self.drag.take_if(|drag| drag.button == button);
                }
                Event::PointerMoved(pos) => self.drag_to(pos, area, camera),
                _ => {}
            }
        }
        if !ui.input(|input| input.pointer.any_down()) {
            self.drag = None;
        }
    }

    fn drag_to(&mut self, pos: Pos2, area: PictureArea, camera: &mut CameraController) {
        let Some(drag) = &mut self.drag else { return };
        let delta = pos - drag.at;
        // The pointer may move a little in a click.
        drag.has_moved |= delta.length() > CLICK;
        if !drag.has_moved {
            return;
        }
        let from = std::mem::replace(&mut drag.at, pos);
        if drag.orbits {
            camera.orbit(glam(delta));
        } else {
            let corner = area.picture.min;
            camera.pan(glam(from - corner), glam(pos - corner), area.size());
        }
    }
}

fn wheel(ui: &Ui, picture: Rect, size: Vec2, camera: &mut CameraController) {
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
            camera.zoom(NOTCH.powf(-delta.y), cursor, size);
        } else if !modifiers.command {
            let at = cursor.unwrap_or(size / 2.0);
            camera.pan(at, at + glam(delta), size);
        }
    }
    if !zoomed && (pinch - 1.0).abs() > 1e-4 {
        camera.zoom(1.0 / pinch, cursor, size);
    }
}

fn held_keys(ui: &Ui, size: Vec2, camera: &mut CameraController) {
    let motion = keys::held(ui.ctx());
    if motion == keys::STILL {
        return;
    }
    // The first picture after a pause comes long after the last one.
    let seconds = ui.input(|input| input.stable_dt).min(0.05);
    if motion.right != 0.0 || motion.forward != 0.0 {
        let step = TRANSLATE * seconds;
        camera.translate(motion.right * step, motion.forward * step);
    }
    if motion.turn_left != 0.0 || motion.tilt_down != 0.0 {
        camera.turn(motion.turn_left * TURN * seconds, motion.tilt_down * TURN * seconds);
    }
    if motion.zoom_out != 0.0 {
        camera.zoom((motion.zoom_out * ZOOM * seconds).exp(), None, size);
    }
    ui.ctx().request_repaint();
}

fn glam(vector: egui::Vec2) -> Vec2 {
    Vec2::new(vector.x, vector.y)
}
