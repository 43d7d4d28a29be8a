//! How things are drawn: colours, layers, floor, offset, trails.

use std::path::Path;

use egui::{DragValue, Key, Role, Slider, TextEdit, Ui, WidgetInfo};

use super::Interface;
use super::facts::Facts;
use super::settings::{RobotMesh, Settings};
use super::style::{faint, heading};
use crate::palette::Colouring;
use crate::scene::MAX_LIGHTS;

impl Interface {
    pub(super) fn look(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let theme = self.settings.theme();
        heading(ui, theme, "colour of the robots");
        self.colour_choice(ui, facts);
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.settings.light, false, "Dark");
            ui.selectable_value(&mut self.settings.light, true, "Light");
        });
        heading(ui, theme, "layers");
        let settings = &mut self.settings;
        ui.checkbox(&mut settings.edges, "edges");
        ui.checkbox(&mut settings.nodes, "nodes");
        ui.checkbox(&mut settings.ids, "ids, when near");
        ui.checkbox(&mut settings.grid, "grid");
        ui.checkbox(&mut settings.shadows, "shadows");
        heading(ui, theme, "trails");
        ui.add(Slider::new(&mut settings.trails, 0..=4096).logarithmic(true).text("points"));
        if (1..settings.trails).contains(&facts.trail_points) {
            ui.label(faint(ui, theme, format!("the adapter has room for {}", facts.trail_points)));
        }
        ui.checkbox(&mut settings.trails_of_selected, "of the selected robots alone");
        heading(ui, theme, "floor");
        let mut sized = settings.floor.is_some();
        ui.checkbox(&mut sized, "of a size, around the origin");
        if sized != settings.floor.is_some() {
            let size = facts.bounds.high - facts.bounds.low;
            settings.floor = sized.then(|| (size.ceil() + 10.0).to_array());
        }
        if let Some(size) = &mut settings.floor {
            ui.horizontal(|ui| {
                for (metres, name) in size.iter_mut().zip(["width ", "depth "]) {
                    ui.add(DragValue::new(metres).range(1.0..=1e6).speed(0.5).prefix(name).suffix(" m"));
                }
            });
        }
        self.floor_file(ui);
        heading(ui, theme, "robots");
        self.mesh_file(ui);
        heading(ui, theme, "lamps");
        lamps(ui, &mut self.settings.lamps, facts);
        heading(ui, theme, "offset of all positions");
        let settings = &mut self.settings;
        ui.horizontal(|ui| {
            for (metres, name) in settings.offset.iter_mut().zip(["x ", "y "]) {
                ui.add(DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name).suffix(" m"));
            }
        });
        heading(ui, theme, "interface");
        let percent = |scale: f32| format!("{:.0} %", scale * 100.0);
        egui::ComboBox::from_id_salt("scale").selected_text(percent(settings.scale)).show_ui(ui, |ui| {
            for scale in [0.75, 0.9, 1.0, 1.15, 1.3, 1.5, 2.0] {
                ui.selectable_value(&mut settings.scale, scale, percent(scale));
            }
        });
    }

    /// Takes a file that was dropped on the window: a mesh is for robots, anything else for the floor.
    pub fn take_file(&mut self, path: &Path) {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
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
        let hint = "image, or a ROS map.yaml";
        if file_line(ui, &mut drafts.floor, hint, !settings.floor_image.is_empty(), "floor file") {
            settings.floor_image.clone_from(&drafts.floor);
        }
    }

    fn mesh_file(&mut self, ui: &mut Ui) {
        let (drafts, settings) = (&mut self.files, &mut self.settings);
        if file_line(ui, &mut drafts.mesh.file, "mesh: STL, OBJ or glTF", settings.mesh.is_some(), "mesh file") {
            settings.mesh = (!drafts.mesh.file.is_empty()).then(|| drafts.mesh.clone());
        }
        if let Some(mesh) = &mut settings.mesh {
            ui.horizontal(|ui| {
                let scale = DragValue::new(&mut drafts.mesh.scale).range(1e-6..=1e6).speed(0.001).prefix("scale ");
                let z = DragValue::new(&mut drafts.mesh.z).range(-100.0..=100.0).speed(0.01).prefix("z ").suffix(" m");
                for value in [ui.add(scale.max_decimals(6)), ui.add(z)] {
                    // The file is read anew: once, when the hand lets go.
                    if value.drag_stopped() || value.lost_focus() {
                        *mesh = RobotMesh { file: mesh.file.clone(), ..drafts.mesh };
                    }
                }
            });
        }
    }

    /// The choice of what the robots' colours tell.
    pub(super) fn colour_choice(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        egui::ComboBox::from_id_salt("colour").selected_text(&self.settings.colour).width(110.0).show_ui(ui, |ui| {
            for name in colourings(facts) {
                ui.selectable_value(&mut self.settings.colour, name.clone(), name);
            }
        });
    }

    /// Takes the next of the colourings.
    pub(super) fn next_colouring(&mut self, facts: &Facts<'_>) {
        let all = colourings(facts);
        let now = all.iter().position(|name| *name == self.settings.colour).map_or(0, |now| now + 1);
        self.settings.colour = all[now % all.len()].clone();
    }
}

/// What is typed of files, before they are read.
#[derive(Clone, Debug)]
pub struct Files {
    floor: String,
    mesh: RobotMesh,
}

impl Files {
    /// Those that the settings name.
    pub fn new(settings: &Settings) -> Self {
        let none = RobotMesh { file: String::new(), scale: 1.0, z: 0.0 };
        Self { floor: settings.floor_image.clone(), mesh: settings.mesh.clone().unwrap_or(none) }
    }
}

/// A file's name, with what loads it and what takes it away. True when the name is to be taken; it is empty then for
/// none.
fn file_line(ui: &mut Ui, file: &mut String, hint: &str, is_there: bool, name: &str) -> bool {
    ui.horizontal(|ui| {
        let line = ui.add(TextEdit::singleline(file).hint_text(hint).desired_width(150.0));
        line.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, name));
        let entered = line.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let load = ui.button("load").on_hover_text("or drop a file on the window").clicked();
        let away = is_there && ui.button("remove").clicked();
        if away {
            file.clear();
        }
        entered || load || away
    })
    .inner
}

fn lamps(ui: &mut Ui, lamps: &mut Vec<[f32; 6]>, facts: &Facts<'_>) {
    let mut gone = None;
    for (i, lamp) in lamps.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let [x, y, z, colour @ ..] = lamp;
            for (metres, name) in [(x, "x "), (y, "y "), (z, "z ")] {
                ui.add(DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name));
            }
            let before = colour.iter().copied().fold(1e-3, f32::max);
            let mut bright = before;
            ui.add(DragValue::new(&mut bright).range(0.01..=1e3).speed(0.01).prefix("× "));
            if bright != before {
                colour.iter_mut().for_each(|part| *part *= bright / before);
            }
            if ui.small_button("remove").clicked() {
                gone = Some(i);
            }
        });
    }
    if let Some(gone) = gone {
        lamps.remove(gone);
    }
    if lamps.len() < MAX_LIGHTS && ui.button("add a lamp").clicked() {
        let middle = facts.bounds.centre();
        lamps.push([middle.x, middle.y, 5.0, 1.0, 1.0, 1.0]);
    }
}

/// All that robots can be coloured by.
fn colourings(facts: &Facts<'_>) -> Vec<String> {
    let own = [Colouring::default(), Colouring::State, Colouring::Speed, Colouring::Type].map(|own| own.to_string());
    let columns = facts.columns.iter().map(ToString::to_string);
    let columns: Vec<_> = columns.filter(|name| !own.contains(name)).collect();
    own.into_iter().chain(columns).collect()
}
