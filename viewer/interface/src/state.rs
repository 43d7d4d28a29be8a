//! The state of the interface: the user's choices and unfinished input. The panels, in files of
//! their own, show and change it.

use egui::{PointerButton, Pos2};
use glam::Vec2;
use regatta_scene::camera::Window;
use regatta_scene::curves::midpoint;
use regatta_scene::palette::Theme;
use regatta_scene::{MAX_SELECTED, Marked};

use super::camera_controller::CameraController;
use super::edge_hover::EdgeHover;
use super::history::{History, Recorder};
use super::levels::SideBySide;
use super::log_panel::LogPanel;
use super::measure::Measuring;
use super::menu::Menu;
use super::minimap::Minimap;
use super::notes::Notes;
use super::placement::Placement;
use super::places::PastPresence;
use super::rows::{RowQuery, Rows};
use super::settings::{LeftPanel, RightPanel, RobotMesh, Settings};
use super::style::{self, ThemeColours};
use super::timeline::TimelineState;
use super::view_model::{Item, ViewModel};
use super::virtual_list::VirtualList;
use crate::cameras::Bookmark;
use crate::robot_filter::Filter;

/// The largest number of messages shown at a time.
const MAX_MESSAGES: usize = 4;

/// The user interface with the user's choices.
#[derive(Debug)]
pub struct Interface {
    /// Choices that are stored from one start to the next.
    pub settings: Settings,
    /// The camera and its motion.
    pub camera_controller: CameraController,
    /// The item that the selection panel describes.
    pub selected: Option<Item>,
    /// More selected robots, if `selected` is a robot.
    pub(super) also_selected: Vec<u32>,
    /// The robots that are not dimmed.
    pub(super) filter: Filter,
    /// An order's number as typed into the filter.
    pub(super) order_number: String,
    pub(super) fleet_list: FleetList,
    pub(super) collision_list: VirtualList,
    pub(super) spot_list: VirtualList,
    /// The place of a hot spot that is marked, in metres.
    pub(super) marked: Option<Vec2>,
    /// The simulated time under the pointer in a plot, in seconds.
    pub(super) hovered_secs: Option<f64>,
    pub(super) history: History,
    pub(super) sliders: SliderDrafts,
    pub(super) files: FileDrafts,
    pub(super) timeline: TimelineState,
    pub(super) notes: Notes,
    /// The panel that was open on the left in the last picture.
    pub(super) left_before: Option<LeftPanel>,
    /// Whether the plots were shown in the last picture.
    pub(super) plots_before: bool,
    /// Whether the help is open.
    pub(super) help: bool,
    pub(super) drag: Option<Drag>,
    /// Whether a text field had the keyboard focus in the last picture.
    pub(super) typing: bool,
    /// The part of the picture that no panel covers.
    pub(super) window: Window,
    /// What lay over the last picture.
    pub(super) placement: Placement,
    pub(super) minimap: Minimap,
    pub(super) edge_hover: EdgeHover,
    pub(super) past_presence: PastPresence,
    /// The recent values of all robots of a fleet that is not too large.
    pub(super) recorder: Recorder,
    /// Keys for the search field that were pressed before it had the focus.
    pub(super) late_input: Option<Vec<egui::Event>>,
    /// The names of the world's levels.
    pub(super) levels: Vec<String>,
    pub(super) side_by_side: SideBySide,
    /// Whether the filter has been changed by something else than its own panel.
    pub(super) is_refiltered: bool,
    /// The named cameras of the scenario.
    pub bookmarks: Vec<Bookmark>,
    /// The ends of what is measured; `None` while nothing is.
    pub(super) measuring: Option<Measuring>,
    pub(super) menu: Option<Menu>,
    pub(super) log_panel: LogPanel,
    pub(super) messages: Vec<Message>,
    /// Theme and scale that the egui context has.
    pub(super) applied_style: Option<(Theme, f32)>,
}

/// The order, the filter and the scroll position of the fleet list.
#[derive(Clone, Debug, Default)]
pub(super) struct FleetList {
    pub query: RowQuery,
    pub list: VirtualList,
    /// Whether the search field requests the keyboard focus.
    pub request_focus: bool,
    /// The rows while the pointer is over them: they don't move then.
    pub held: Option<Rows>,
    /// Where the list was shown last.
    pub area: Option<egui::Rect>,
}

/// Slider values that the engine has not adopted yet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SliderDrafts {
    pub speed: Option<f32>,
    pub robots: Option<u32>,
}

/// File names and mesh parameters as typed, before the files are loaded.
#[derive(Clone, Debug)]
pub(super) struct FileDrafts {
    /// The file that hot spots are written to.
    pub spots: String,
    pub floor: String,
    pub mesh: RobotMesh,
}

/// A pointer button held down on the picture.
#[derive(Debug)]
pub(super) struct Drag {
    pub button: PointerButton,
    /// Whether the drag orbits the camera; otherwise it pans.
    pub orbits: bool,
    /// The last position of the pointer, in points.
    pub at: Pos2,
    /// Whether the pointer has moved farther than in a click.
    pub has_moved: bool,
}

/// A message over the picture.
#[derive(Clone, Debug)]
pub(super) struct Message {
    pub text: String,
    /// The time at which it disappears, in seconds of the egui context; set when it is first shown.
    pub until: Option<f64>,
}

impl FileDrafts {
    fn new(settings: &Settings) -> Self {
        let none = RobotMesh { file: String::new(), scale: 1.0, z: 0.0, yaw: 0.0 };
        let spots = "hot-spots.csv".to_owned();
        Self {
            spots,
            floor: settings.floor_image.clone(),
            mesh: settings.mesh.clone().unwrap_or(none),
        }
    }
}

impl Interface {
    /// Creates an interface with these settings and this camera.
    pub fn new(settings: Settings, camera_controller: CameraController) -> Self {
        // Nothing is selected yet, so that its panel would be empty.
        let right = settings.right.filter(|open| *open != RightPanel::Selection);
        Self {
            files: FileDrafts::new(&settings),
            settings: Settings { right, ..settings },
            camera_controller,
            selected: None,
            also_selected: Vec::new(),
            filter: Filter::default(),
            order_number: String::new(),
            fleet_list: FleetList::default(),
            collision_list: VirtualList::default(),
            spot_list: VirtualList::default(),
            marked: None,
            hovered_secs: None,
            history: History::default(),
            sliders: SliderDrafts::default(),
            timeline: TimelineState::default(),
            notes: Notes::default(),
            left_before: None,
            plots_before: false,
            help: false,
            drag: None,
            typing: false,
            window: Window::whole(16.0 / 9.0),
            placement: Placement::new(egui::Rect::ZERO),
            minimap: Minimap::default(),
            edge_hover: EdgeHover::default(),
            past_presence: PastPresence::default(),
            recorder: Recorder::default(),
            late_input: None,
            levels: Vec::new(),
            side_by_side: SideBySide::default(),
            is_refiltered: false,
            bookmarks: Vec::new(),
            measuring: None,
            menu: None,
            log_panel: LogPanel::default(),
            messages: Vec::new(),
            applied_style: None,
        }
    }

    /// Prepares the interface for another egui context, which does not have its style yet.
    #[must_use]
    pub fn for_new_context(self) -> Self {
        Self { applied_style: None, ..self }
    }

    /// Shows a message for some seconds. A message with the same text is replaced.
    pub fn notify(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.messages.retain(|message| message.text != text);
        self.messages.push(Message { text, until: None });
        let surplus = self.messages.len().saturating_sub(MAX_MESSAGES);
        self.messages.drain(..surplus);
    }

    /// Selects one item or nothing, and opens the selection panel for an item.
    pub fn select(&mut self, item: Option<Item>) {
        self.also_selected.clear();
        self.selected = item;
        if item.is_some() {
            self.settings.right = Some(RightPanel::Selection);
        }
    }

    /// Adds a robot to the selected ones, or removes it from them. Any other item is selected
    /// alone.
    pub fn toggle_selected(&mut self, item: Item) {
        let Item::Robot(id) = item else { return self.select(Some(item)) };
        let mut robots = self.robots();
        if robots.contains(&id) {
            robots.retain(|robot| *robot != id);
        } else {
            robots.insert(0, id);
        }
        robots.truncate(MAX_SELECTED);
        self.select(robots.first().map(|robot| Item::Robot(*robot)));
        self.also_selected = robots.split_off(robots.len().min(1));
    }

    /// Returns the ids of the selected robots, the one in the selection panel first.
    pub fn robots(&self) -> Vec<u32> {
        let Some(Item::Robot(id)) = self.selected else { return Vec::new() };
        [&[id], self.also_selected.as_slice()].concat()
    }

    /// Returns the selected edge or node.
    pub fn marked(&self) -> Option<Marked> {
        match self.selected? {
            Item::Robot(_) => None,
            Item::Edge(index) => Some(Marked::Edge(index)),
            Item::Node(index) => Some(Marked::Node(index)),
        }
    }

    pub(super) fn colours(&self) -> ThemeColours {
        style::colours(self.settings.theme())
    }

    pub(super) fn fly_to_selected(&mut self, model: &ViewModel<'_>) {
        match (self.place_of_selected(model), self.selected) {
            (Some(place), Some(Item::Robot(id))) => self.camera_controller.fly_to_robot(id, place),
            (Some(place), _) => self.camera_controller.fly_to(place),
            (None, _) => {}
        }
    }

    fn place_of_selected(&self, model: &ViewModel<'_>) -> Option<Vec2> {
        let offset = Vec2::from(self.settings.offset);
        match self.selected? {
            Item::Robot(id) => Some(model.pose(id, offset)?.place),
            Item::Node(index) => model
                .world
                .nodes()
                .get(index as usize)
                .map(|node| Vec2::new(node.x, node.y) + offset),
            Item::Edge(index) => {
                let edge = model.world.edges().get(index as usize)?;
                midpoint(&model.world, edge).map(|middle| middle + offset)
            }
        }
    }
}
