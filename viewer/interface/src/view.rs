//! The view panel: colours, layers, trails, floor, meshes, lamps and offset.

use std::path::Path;

use egui::{DragValue, Key, Role, Slider, TextEdit, Ui, WidgetInfo};
use glam::Vec3;
use regatta_plugin::column::{GOAL, WAITS_FOR};
use regatta_scene::palette::Colouring;
use regatta_scene::plans::{Coverage, PlanFacts, Waiting};
use regatta_scene::{Light, MAX_LIGHTS};

use super::cameras::{self, Bookmark};
use super::context::PanelContext;
use super::heat;
use super::levels::Levels;
use super::settings::{AUTOMATIC, RobotMesh, Settings};
use super::style::{self, faint, heading};
use super::view_model::ViewModel;
use crate::text::{thousands, with_plural};

/// The view panel: file names and mesh parameters as typed, before the files are loaded.
#[derive(Clone, Debug)]
pub(super) struct ViewPanel {
    floor: String,
    mesh: RobotMesh,
}

impl ViewPanel {
    /// Creates the panel with the files of the settings.
    pub fn new(settings: &Settings) -> Self {
        let none = RobotMesh { file: String::new(), scale: 1.0, z: 0.0, yaw: 0.0 };
        Self { floor: settings.floor_image.clone(), mesh: settings.mesh.clone().unwrap_or(none) }
    }

    /// Shows the panel.
    pub fn show(
        &mut self,
        context: &PanelContext<'_>,
        settings: &mut Settings,
        levels: &Levels,
        bookmarks: &[Bookmark],
        ui: &mut Ui,
    ) {
        heading(ui, "robot colours");
        colour_choice(context, settings, ui);
        ui.horizontal(|ui| {
            ui.selectable_value(&mut settings.light, false, "Dark");
            ui.selectable_value(&mut settings.light, true, "Light");
        });
        cameras::show(context, bookmarks, ui);
        heading(ui, "layers");
        levels.choice(context, ui);
        ui.checkbox(&mut settings.edges, "edges");
        ui.checkbox(&mut settings.nodes, "nodes");
        ui.checkbox(&mut settings.ids, "ids when near");
        ui.checkbox(&mut settings.robot_ids, "ids of robots when near").on_hover_text("Shift+U");
        ui.checkbox(&mut settings.minimap, "minimap").on_hover_text("Shift+M");
        ui.checkbox(&mut settings.grid, "grid");
        ui.checkbox(&mut settings.shadows, "shadows");
        ui.checkbox(&mut settings.density, "density of robots from afar").on_hover_text("Shift+Z");
        plan_layers(context, settings, ui);
        heat::layer(context, settings, ui);
        heading(ui, "trails");
        ui.add(Slider::new(&mut settings.trails, 0..=4096).logarithmic(true).text("points"));
        if (1..settings.trails).contains(&context.model.trail_points) {
            ui.label(faint(
                ui,
                format!(
                    "limited to {} by the graphics adapter",
                    thousands(context.model.trail_points.into())
                ),
            ));
        }
        ui.checkbox(&mut settings.trails_of_selected, "selected robots only");
        heading(ui, "floor");
        let mut is_limited = settings.floor.is_some();
        ui.checkbox(&mut is_limited, "limited size around the origin");
        if is_limited != settings.floor.is_some() {
            let size = context.model.bounds.high - context.model.bounds.low;
            settings.floor = is_limited.then_some(size.ceil() + 10.0);
        }
        if let Some(size) = &mut settings.floor {
            ui.horizontal(|ui| {
                for (metres, name) in [(&mut size.x, "width "), (&mut size.y, "depth ")] {
                    ui.add(
                        DragValue::new(metres)
                            .range(1.0..=1e6)
                            .speed(0.5)
                            .prefix(name)
                            .suffix(" m"),
                    );
                }
            });
        }
        self.floor_file(settings, ui);
        cameras::floor_place(settings, ui);
        heading(ui, "robots");
        self.mesh_file(settings, ui);
        heading(ui, "lamps");
        lamps(ui, &mut settings.lamps, context.model);
        heading(ui, "offset of all positions");
        ui.horizontal(|ui| {
            let offset = &mut settings.offset;
            for (metres, name) in [(&mut offset.x, "x "), (&mut offset.y, "y ")] {
                ui.add(
                    DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name).suffix(" m"),
                );
            }
        });
        heading(ui, "interface");
        let combo =
            egui::ComboBox::from_id_salt("scale").selected_text(percent_text(settings.scale));
        style::choice(ui, "size of the interface", combo, |ui| {
            for scale in [0.75, 0.9, 1.0, 1.15, 1.3, 1.5, 2.0] {
                ui.selectable_value(&mut settings.scale, scale, percent_text(scale));
            }
        });
    }

    /// Uses a file that was dropped on the window: a mesh for the robots, any other file for the
    /// floor.
    pub fn use_file(&mut self, path: &Path, settings: &mut Settings) {
        let extension =
            path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let file = path.display().to_string();
        match extension.as_deref() {
            Some("stl" | "obj" | "gltf" | "glb") => {
                self.mesh.file = file;
                settings.mesh = Some(self.mesh.clone());
            }
            _ => {
                settings.floor_image.clone_from(&file);
                self.floor = file;
            }
        }
    }

    fn floor_file(&mut self, settings: &mut Settings, ui: &mut Ui) {
        let hint = "image or map.yaml";
        if file_line(ui, &mut self.floor, hint, !settings.floor_image.is_empty(), "floor file") {
            settings.floor_image.clone_from(&self.floor);
        }
    }

    fn mesh_file(&mut self, settings: &mut Settings, ui: &mut Ui) {
        if file_line(
            ui,
            &mut self.mesh.file,
            "mesh: STL, OBJ or glTF",
            settings.mesh.is_some(),
            "mesh file",
        ) {
            settings.mesh = (!self.mesh.file.is_empty()).then(|| self.mesh.clone());
        }
        if let Some(mesh) = &mut settings.mesh {
            ui.horizontal_wrapped(|ui| {
                let scale = DragValue::new(&mut self.mesh.scale)
                    .range(1e-6..=1e6)
                    .speed(0.001)
                    .prefix("scale ");
                let z = DragValue::new(&mut self.mesh.z)
                    .range(-100.0..=100.0)
                    .speed(0.01)
                    .prefix("z ")
                    .suffix(" m");
                let yaw = DragValue::new(&mut self.mesh.yaw)
                    .range(-360.0..=360.0)
                    .speed(1.0)
                    .prefix("yaw ")
                    .suffix("°");
                for value in [ui.add(scale.max_decimals(6)), ui.add(z), ui.add(yaw)] {
                    // A change reads the file again, so it is applied only when the value is
                    // released.
                    if value.drag_stopped() || value.lost_focus() {
                        *mesh = RobotMesh { file: mesh.file.clone(), ..self.mesh };
                    }
                }
            });
        }
    }
}

/// Shows the switches of a fleet manager's plans, each with its known facts.
fn plan_layers(context: &PanelContext<'_>, settings: &mut Settings, ui: &mut Ui) {
    let plans = &context.model.plans;
    let robots = if context.filter.has_conditions() { "matching" } else { "all" };
    ui.checkbox(&mut settings.plans, format!("routes and goals of {robots} robots"))
        .on_hover_text("Key H");
    if settings.plans {
        ui.label(faint(ui, routes_text(plans)));
    }
    ui.checkbox(&mut settings.waits, "who waits for whom").on_hover_text("Key B");
    if settings.waits {
        ui.label(faint(ui, waits_text(plans)));
    }
}

/// Shows the choice of colourings of the robots.
fn colour_choice(context: &PanelContext<'_>, settings: &mut Settings, ui: &mut Ui) {
    let combo = egui::ComboBox::from_id_salt("colour").selected_text(&settings.colour).width(110.0);
    style::choice(ui, "robot colours", combo, |ui| {
        for name in colourings(context.model) {
            ui.selectable_value(&mut settings.colour, name.clone(), name);
        }
    });
}

/// Selects the next colouring.
pub(super) fn next_colouring(model: &ViewModel<'_>, settings: &mut Settings) {
    let all = colourings(model);
    let next = all.iter().position(|name| *name == settings.colour).map_or(0, |index| index + 1);
    settings.colour = all[next % all.len()].clone();
}

fn percent_text(scale: f32) -> String {
    format!("{:.0} %", scale * 100.0)
}

/// Returns the coverage of the routes of all robots, or of those that match the filter, as a text.
fn routes_text(plans: &PlanFacts) -> String {
    let goals = if plans.has_goals { "" } else { "; no goals: no fleet manager publishes them" };
    let noun = robot_noun(plans);
    match plans.routes {
        Some(Coverage { known, under_way, round_secs }) if round_secs.is_finite() => {
            let (known, robots) = (thousands(known.into()), with_plural(under_way.into(), noun));
            format!("routes of {known} of {robots} under way, at most {round_secs:.1} s old{goals}")
        }
        Some(Coverage { known, under_way, .. }) => {
            let (known, robots) = (thousands(known.into()), with_plural(under_way.into(), noun));
            format!("routes of {known} of {robots} under way so far{goals}")
        }
        None => "nothing known yet".to_owned(),
    }
}

/// Returns the name of the counted robots.
fn robot_noun(plans: &PlanFacts) -> &'static str {
    if plans.is_filtered { "matching robot" } else { "robot" }
}

/// Returns the number of robots that wait, as a text.
fn waits_text(plans: &PlanFacts) -> String {
    match plans.waiting {
        Some(Waiting { robots: waiting, in_rings }) => {
            let verb = if waiting == 1 { "waits" } else { "wait" };
            let in_rings =
                if in_rings == 0 { "none".to_owned() } else { thousands(in_rings.into()) };
            format!(
                "{} {verb}, {in_rings} of them in rings",
                with_plural(waiting.into(), robot_noun(plans))
            )
        }
        None => "no fleet manager publishes who waits".to_owned(),
    }
}

/// Shows a field for a file name with its buttons; `name` is its accessible name. Returns whether
/// to apply the file name, which is then empty for no file.
fn file_line(ui: &mut Ui, file: &mut String, hint: &str, is_loaded: bool, name: &str) -> bool {
    ui.horizontal(|ui| {
        let line = ui.add(TextEdit::singleline(file).hint_text(hint).desired_width(150.0));
        line.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, name));
        let entered = line.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let load = ui.button("load").on_hover_text("Or drop a file on the window").clicked();
        let remove = is_loaded && ui.button("remove").clicked();
        if remove {
            file.clear();
        }
        entered || load || remove
    })
    .inner
}

fn lamps(ui: &mut Ui, lamps: &mut Vec<Light>, model: &ViewModel<'_>) {
    let mut removed = None;
    for (i, lamp) in lamps.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let at = &mut lamp.position;
            for (metres, name) in [(&mut at.x, "x "), (&mut at.y, "y "), (&mut at.z, "z ")] {
                ui.add(DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name));
            }
            let before = lamp.colour.max_element().max(1e-3);
            let mut brightness = before;
            ui.add(DragValue::new(&mut brightness).range(0.01..=1e3).speed(0.01).prefix("× "));
            if brightness != before {
                lamp.colour *= brightness / before;
            }
            if ui.small_button("remove").clicked() {
                removed = Some(i);
            }
        });
    }
    if let Some(index) = removed {
        lamps.remove(index);
    }
    if lamps.len() < MAX_LIGHTS && ui.button("add a lamp").clicked() {
        let middle = model.bounds.centre();
        lamps.push(Light { position: middle.extend(5.0), colour: Vec3::ONE });
    }
}

/// Returns the names of all colourings: the built-in ones, and the columns that plugins publish.
fn colourings(model: &ViewModel<'_>) -> Vec<String> {
    let built_in = [Colouring::State, Colouring::Speed, Colouring::Type]
        .map(|colouring| colouring.to_string());
    let columns = model.columns.iter().map(ToString::to_string);
    // Ids make no colours, and the names are listed as long as this viewer reads them.
    let ids = [GOAL.name(), WAITS_FOR.name()];
    let columns: Vec<_> =
        columns.filter(|name| !built_in.contains(name) && !ids.contains(&name.as_str())).collect();
    [AUTOMATIC.to_owned()].into_iter().chain(built_in).chain(columns).collect()
}
