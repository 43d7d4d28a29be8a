//! The part of the view panel about cameras: the named cameras of the scenario, the plan as a file,
//! and the placement of the floor picture.

use std::str::FromStr;

use egui::{DragValue, Ui};
use glam::{Vec2, Vec3};
use regatta_scene::camera::{Bounds, Camera, Window};

use super::context::{PanelContext, Request};
use super::settings::Settings;
use super::style::{faint, heading};
use super::view_model::Action;

/// The error of parsing an option's value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not {expected}")]
pub struct ParseError {
    /// The text.
    pub text: String,
    /// The text that was expected instead, with an example.
    pub expected: &'static str,
}

/// A named camera, for example `dock=4,-3,12,1.57,0.9`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bookmark {
    /// The name.
    pub name: String,
    /// The camera; never one by name.
    pub view: CameraOption,
}

/// The initial camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraOption {
    /// An orthographic plan of the whole graph.
    Plan,
    /// The camera of a bookmark.
    Named(String),
    /// Shows the whole graph from an angle.
    Fit,
    /// Shows the whole graph straight from above.
    Top,
    /// A camera with a given position and view direction.
    Eye(Camera),
}

/// Parses finite numbers below a million, separated by commas.
pub fn numbers(text: &str, expected: &'static str) -> Result<Vec<f32>, ParseError> {
    let mut numbers = Vec::new();
    for part in text.split(',') {
        match part.trim().parse::<f32>() {
            Ok(number) if number.is_finite() && number.abs() < 1e6 => numbers.push(number),
            _ => return Err(ParseError::new(text, expected)),
        }
    }
    Ok(numbers)
}

impl ParseError {
    fn new(text: &str, expected: &'static str) -> Self {
        Self { text: text.to_owned(), expected }
    }
}

impl FromStr for Bookmark {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let expected = "a named camera such as dock=4,-3,12,1.57,0.9 or hall=20,10,60";
        let (name, view) = text
            .split_once('=')
            .filter(|(name, _)| !name.trim().is_empty())
            .ok_or_else(|| ParseError::new(text, expected))?;
        match view.parse()? {
            CameraOption::Named(_) => Err(ParseError::new(text, expected)),
            view => Ok(Self { name: name.trim().to_owned(), view }),
        }
    }
}

impl FromStr for CameraOption {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let expected = "fit, top, plan, a bookmark's name, x,y,z,yaw,pitch or x,y,height";
        let is_name = !text.contains(',') && text.starts_with(char::is_alphabetic);
        match text {
            "fit" => Ok(Self::Fit),
            "top" => Ok(Self::Top),
            "plan" => Ok(Self::Plan),
            name if is_name => Ok(Self::Named(name.to_owned())),
            eye => match numbers(eye, expected)?[..] {
                [x, y, z, yaw, pitch] => {
                    Ok(Self::Eye(Camera::from_eye(Vec3::new(x, y, z), yaw, pitch)))
                }
                [x, y, height] if height > 0.0 => {
                    Ok(Self::Eye(Camera::plan_around(Vec2::new(x, y), height)))
                }
                _ => Err(ParseError::new(text, expected)),
            },
        }
    }
}

impl CameraOption {
    /// Returns the camera for a picture of a fleet within `bounds`, which fits into the part
    /// `window` of it.
    pub fn camera(&self, bounds: Bounds, window: Window) -> Camera {
        match self {
            Self::Fit | Self::Named(_) => {
                Camera::fit(bounds, window.aspect).fitted_within(bounds, window)
            }
            Self::Top => Camera::top(bounds, window.aspect).fitted_within(bounds, window),
            Self::Plan => Camera::plan(bounds, window),
            Self::Eye(camera) => *camera,
        }
    }

    /// Returns a line for the cameras of a scenario.
    pub fn entry(camera: &Camera) -> String {
        if camera.is_plan() {
            let (at, height) = (camera.target, camera.distance * 2.0 * (camera.fov_y / 2.0).tan());
            return format!(
                "  - {{name: here, x: {:.2}, y: {:.2}, height: {height:.2}}}",
                at.x, at.y
            );
        }
        let (eye, yaw, pitch) = (camera.eye(), camera.yaw, camera.pitch);
        format!(
            "  - {{name: here, x: {:.2}, y: {:.2}, z: {:.2}, yaw: {yaw:.3}, pitch: {pitch:.3}}}",
            eye.x, eye.y, eye.z
        )
    }
}

/// Shows the named cameras, and buttons that copy this camera and write the plan.
pub(super) fn show(context: &PanelContext<'_>, bookmarks: &[Bookmark], ui: &mut Ui) {
    heading(ui, "cameras");
    if bookmarks.is_empty() {
        ui.label(faint(ui, "none named; add them to the scenario as `cameras`"));
    } else {
        ui.horizontal_wrapped(|ui| {
            for bookmark in bookmarks {
                if ui.button(&bookmark.name).clicked() {
                    // Of everything, the part of the picture that no panel covers shows all.
                    let camera = bookmark.view.camera(context.model.bounds, context.window);
                    context.ask(Request::FlyToCamera(camera));
                }
            }
        });
    }
    ui.horizontal_wrapped(|ui| {
        let text = "Copy a line for `cameras` of the scenario";
        if ui.button("Copy this camera").on_hover_text(text).clicked() {
            ui.ctx().copy_text(CameraOption::entry(&context.camera));
            context
                .notify("the camera is on the clipboard, as a line for `cameras` of the scenario");
        }
        if ui
            .button("Plan as SVG")
            .on_hover_text("Write a plan with its scale into the current folder")
            .clicked()
        {
            context.act(Action::WriteSvg);
        }
        let text = "Write a picture of the window into the current folder (Ctrl+S)";
        if ui.button("Picture").on_hover_text(text).clicked() {
            context.act(Action::WritePicture);
        }
    });
}

/// Shows where the floor picture is placed.
pub(super) fn floor_place(settings: &mut Settings, ui: &mut Ui) {
    if settings.floor_image.is_empty() {
        return;
    }
    let mut is_placed = settings.floor_at.is_some();
    ui.checkbox(&mut is_placed, "placed by origin and resolution");
    if is_placed != settings.floor_at.is_some() {
        settings.floor_at = is_placed.then_some([0.0, 0.0, 0.05, 0.0].into());
    }
    let Some(at) = &mut settings.floor_at else { return };
    ui.horizontal_wrapped(|ui| {
        for (metres, name) in [(&mut at.x, "x "), (&mut at.y, "y ")] {
            ui.add(DragValue::new(metres).range(-1e6..=1e6).speed(0.05).prefix(name).suffix(" m"));
        }
        ui.add(
            DragValue::new(&mut at.metres_per_pixel)
                .range(1e-4..=100.0)
                .speed(0.001)
                .max_decimals(4)
                .suffix(" m/pixel"),
        );
        ui.add(
            DragValue::new(&mut at.yaw_degrees)
                .range(-360.0..=360.0)
                .speed(0.5)
                .prefix("yaw ")
                .suffix("°"),
        );
    });
}
