//! The view panel: colours, layers, trails, floor, meshes, lamps and offset.

use std::path::Path;

use egui::{DragValue, Key, Role, Slider, TextEdit, Ui, WidgetInfo};
use glam::Vec3;
use regatta_plugin::column::{GOAL, WAITS_FOR};
use regatta_scene::palette::Colouring;
use regatta_scene::plans::{Coverage, PlanFacts};
use regatta_scene::{Light, MAX_LIGHTS};

use super::settings::RobotMesh;
use super::state::Interface;
use super::style::{faint, heading};
use super::view_model::{Action, ViewModel};
use crate::text::{thousands, with_plural};

impl Interface {
    pub(super) fn view(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let theme = self.settings.theme();
        heading(ui, theme, "robot colours");
        self.colour_choice(ui, model);
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.settings.light, false, "Dark");
            ui.selectable_value(&mut self.settings.light, true, "Light");
        });
        self.cameras(ui, model, actions);
        heading(ui, theme, "layers");
        self.level_choice(ui);
        let settings = &mut self.settings;
        ui.checkbox(&mut settings.edges, "edges");
        ui.checkbox(&mut settings.nodes, "nodes");
        ui.checkbox(&mut settings.ids, "ids when near");
        ui.checkbox(&mut settings.robot_ids, "ids of robots when near").on_hover_text("Shift+U");
        ui.checkbox(&mut settings.minimap, "minimap").on_hover_text("Shift+M");
        ui.checkbox(&mut settings.grid, "grid");
        ui.checkbox(&mut settings.shadows, "shadows");
        ui.checkbox(&mut settings.density, "density of robots from afar").on_hover_text("Shift+Z");
        self.plan_layers(ui, model);
        self.heat_layer(ui, model);
        let settings = &mut self.settings;
        heading(ui, theme, "trails");
        ui.add(Slider::new(&mut settings.trails, 0..=4096).logarithmic(true).text("points"));
        if (1..settings.trails).contains(&model.trail_points) {
            ui.label(faint(
                ui,
                theme,
                format!("limited to {} by the graphics adapter", model.trail_points),
            ));
        }
        ui.checkbox(&mut settings.trails_of_selected, "selected robots only");
        heading(ui, theme, "floor");
        let mut is_limited = settings.floor.is_some();
        ui.checkbox(&mut is_limited, "limited size around the origin");
        if is_limited != settings.floor.is_some() {
            let size = model.bounds.high - model.bounds.low;
            settings.floor = is_limited.then(|| (size.ceil() + 10.0).to_array());
        }
        if let Some(size) = &mut settings.floor {
            ui.horizontal(|ui| {
                for (metres, name) in size.iter_mut().zip(["width ", "depth "]) {
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
        self.floor_file(ui);
        self.floor_place(ui);
        heading(ui, theme, "robots");
        self.mesh_file(ui);
        heading(ui, theme, "lamps");
        lamps(ui, &mut self.settings.lamps, model);
        heading(ui, theme, "offset of all positions");
        let settings = &mut self.settings;
        ui.horizontal(|ui| {
            for (metres, name) in settings.offset.iter_mut().zip(["x ", "y "]) {
                ui.add(
                    DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name).suffix(" m"),
                );
            }
        });
        heading(ui, theme, "interface");
        let percent = |scale: f32| format!("{:.0} %", scale * 100.0);
        let choice = egui::ComboBox::from_id_salt("scale").selected_text(percent(settings.scale));
        let shown = choice.show_ui(ui, |ui| {
            for scale in [0.75, 0.9, 1.0, 1.15, 1.3, 1.5, 2.0] {
                ui.selectable_value(&mut settings.scale, scale, percent(scale));
            }
        });
        shown
            .response
            .widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "size of the interface"));
    }

    /// Shows the switches of what a fleet manager plans, each with what is known of it.
    fn plan_layers(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let (theme, settings, plans) = (self.settings.theme(), &mut self.settings, &model.plans);
        let robots = if self.filter.has_conditions() { "matching" } else { "all" };
        ui.checkbox(&mut settings.plans, format!("routes and goals of {robots} robots"))
            .on_hover_text("Key H");
        if settings.plans {
            ui.label(faint(ui, theme, routes_text(plans)));
        }
        ui.checkbox(&mut settings.waits, "who waits for whom").on_hover_text("Key B");
        if settings.waits {
            ui.label(faint(ui, theme, waits_text(plans)));
        }
    }

    /// Uses a file that was dropped on the window: a mesh for the robots, any other file for the
    /// floor.
    pub fn use_file(&mut self, path: &Path) {
        let extension =
            path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let file = path.display().to_string();
        match extension.as_deref() {
            Some("stl" | "obj" | "gltf" | "glb") => {
                self.files.mesh.file = file;
                self.settings.mesh = Some(self.files.mesh.clone());
            }
            _ => {
                self.settings.floor_image.clone_from(&file);
                self.files.floor = file;
            }
        }
    }

    fn floor_file(&mut self, ui: &mut Ui) {
        let (drafts, settings) = (&mut self.files, &mut self.settings);
        let hint = "image or ROS map.yaml";
        if file_line(ui, &mut drafts.floor, hint, !settings.floor_image.is_empty(), "floor file") {
            settings.floor_image.clone_from(&drafts.floor);
        }
    }

    fn mesh_file(&mut self, ui: &mut Ui) {
        let (drafts, settings) = (&mut self.files, &mut self.settings);
        if file_line(
            ui,
            &mut drafts.mesh.file,
            "mesh: STL, OBJ or glTF",
            settings.mesh.is_some(),
            "mesh file",
        ) {
            settings.mesh = (!drafts.mesh.file.is_empty()).then(|| drafts.mesh.clone());
        }
        if let Some(mesh) = &mut settings.mesh {
            ui.horizontal_wrapped(|ui| {
                let scale = DragValue::new(&mut drafts.mesh.scale)
                    .range(1e-6..=1e6)
                    .speed(0.001)
                    .prefix("scale ");
                let z = DragValue::new(&mut drafts.mesh.z)
                    .range(-100.0..=100.0)
                    .speed(0.01)
                    .prefix("z ")
                    .suffix(" m");
                let yaw = DragValue::new(&mut drafts.mesh.yaw)
                    .range(-360.0..=360.0)
                    .speed(1.0)
                    .prefix("yaw ")
                    .suffix("°");
                for value in [ui.add(scale.max_decimals(6)), ui.add(z), ui.add(yaw)] {
                    // A change reads the file again, so it is applied only when the value is
                    // released.
                    if value.drag_stopped() || value.lost_focus() {
                        *mesh = RobotMesh { file: mesh.file.clone(), ..drafts.mesh };
                    }
                }
            });
        }
    }

    /// Shows the choice of colourings of the robots.
    pub(super) fn colour_choice(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let choice = egui::ComboBox::from_id_salt("colour")
            .selected_text(&self.settings.colour)
            .width(110.0);
        let shown = choice.show_ui(ui, |ui| {
            for name in colourings(model) {
                ui.selectable_value(&mut self.settings.colour, name.clone(), name);
            }
        });
        shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "robot colours"));
    }

    /// Selects the next colouring.
    pub(super) fn next_colouring(&mut self, model: &ViewModel<'_>) {
        let all = colourings(model);
        let next =
            all.iter().position(|name| *name == self.settings.colour).map_or(0, |index| index + 1);
        self.settings.colour = all[next % all.len()].clone();
    }
}

/// Returns what is known of the routes of all robots, or of those that match the filter.
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

/// Returns what the robots are that are counted.
fn robot_noun(plans: &PlanFacts) -> &'static str {
    if plans.is_filtered { "matching robot" } else { "robot" }
}

/// Returns how many robots wait.
fn waits_text(plans: &PlanFacts) -> String {
    match plans.waiting {
        Some([waiting, in_rings]) => {
            let verb = if waiting == 1 { "waits" } else { "wait" };
            let in_rings =
                if in_rings == 0 { "none".to_owned() } else { thousands(in_rings.into()) };
            format!(
                "{} {verb}, {in_rings} of them in rings",
                with_plural(waiting.into(), robot_noun(plans))
            )
        }
        None => "no fleet manager says who waits".to_owned(),
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
    let built_in = [Colouring::default(), Colouring::State, Colouring::Speed, Colouring::Type]
        .map(|colouring| colouring.to_string());
    let columns = model.columns.iter().map(ToString::to_string);
    // Ids make no colours, and the names are listed as long as this viewer reads them.
    let ids = [GOAL.name(), WAITS_FOR.name()];
    let columns: Vec<_> =
        columns.filter(|name| !built_in.contains(name) && !ids.contains(&name.as_str())).collect();
    built_in.into_iter().chain(columns).collect()
}
