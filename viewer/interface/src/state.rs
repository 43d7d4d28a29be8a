//! The state of the interface: the user's choices, which panels share, and the panels, each of
//! which owns its state.

use std::cell::RefCell;
use std::path::Path;

use egui::Rect;
use glam::Vec2;
use regatta_scene::Marked;
use regatta_scene::camera::{Camera, Window};
use regatta_scene::curves::midpoint;
use regatta_scene::palette::Theme;

use super::camera_controller::CameraController;
use super::cameras::Bookmark;
use super::collisions::CollisionsPanel;
use super::commands::UserCommand;
use super::context::{PanelContext, Request, Selection};
use super::edge_hover::EdgeHover;
use super::fleet_list::FleetPanel;
use super::help::Help;
use super::legend::{LEGEND_ROOM, LegendRoom};
use super::levels::Levels;
use super::log::FleetLog;
use super::log_panel::LogPanel;
use super::measure::{End, Measuring};
use super::menu::Menu;
use super::minimap::Minimap;
use super::overlay::Messages;
use super::placement::Placement;
use super::plots::PlotsPanel;
use super::pointer_input::PointerInput;
use super::robot_filter::Filter;
use super::selection::SelectionPanel;
use super::settings::{LeftPanel, RightPanel, Settings};
use super::spots::SpotsPanel;
use super::style;
use super::timeline::TimelinePanel;
use super::transport::TransportBar;
use super::undo::Undo;
use super::view::ViewPanel;
use super::view_model::{Action, Item, ViewModel};

/// The user interface with the user's choices.
#[derive(Debug)]
pub struct Interface {
    /// Choices that are stored from one start to the next.
    pub settings: Settings,
    /// The camera and its motion.
    pub camera_controller: CameraController,
    /// The selected items.
    pub selection: Selection,
    /// The named cameras of the scenario.
    pub bookmarks: Vec<Bookmark>,
    /// The robots that are not dimmed, and the level.
    pub(super) filter: Filter,
    pub(super) levels: Levels,
    /// The ends of the measurement; `None` without one.
    pub(super) measuring: Option<Measuring>,
    pub(super) fleet: FleetPanel,
    pub(super) collisions: CollisionsPanel,
    pub(super) spots: SpotsPanel,
    pub(super) log: LogPanel,
    pub(super) selection_panel: SelectionPanel,
    pub(super) view: ViewPanel,
    pub(super) plots: PlotsPanel,
    pub(super) timeline: TimelinePanel,
    pub(super) transport: TransportBar,
    pub(super) pointer: PointerInput,
    pub(super) edge_hover: EdgeHover,
    pub(super) minimap: Minimap,
    pub(super) menu: Menu,
    pub(super) help: Help,
    pub(super) messages: Messages,
    pub(super) undo: Undo,
    /// The actions that undo others, which this picture returns.
    pub(super) undoing: Vec<Action>,
    pub(super) last: LastPicture,
    /// Keys for the search field that were pressed before it had the focus.
    pub(super) late_input: Option<Vec<egui::Event>>,
    /// Theme and scale that the egui context has.
    pub(super) applied_style: Option<(Theme, f32)>,
}

/// Facts about the last picture.
#[derive(Debug)]
pub(super) struct LastPicture {
    /// The panel that was open on the left.
    pub left: Option<LeftPanel>,
    /// Whether the plots were shown.
    pub plots: bool,
    /// Whether a text field had the keyboard focus.
    pub typing: bool,
    /// The part of the picture that no panel covered.
    pub window: Window,
    /// The camera with which the elements over the picture were drawn.
    pub camera: Camera,
    /// The elements over the picture.
    pub placement: Placement,
    /// The room of the legend, also where there is none for it.
    pub legend: LegendRoom,
    /// Whether the selected item is to be in sight.
    pub reveals: bool,
}

impl Interface {
    /// Creates an interface with these settings and this camera.
    pub fn new(settings: Settings, camera_controller: CameraController) -> Self {
        // Nothing is selected yet, so that its panel would be empty.
        let right = settings.right.filter(|open| *open != RightPanel::Selection);
        let camera = camera_controller.camera();
        Self {
            view: ViewPanel::new(&settings),
            settings: Settings { right, ..settings },
            camera_controller,
            selection: Selection::default(),
            bookmarks: Vec::new(),
            filter: Filter::default(),
            levels: Levels::default(),
            measuring: None,
            fleet: FleetPanel::default(),
            collisions: CollisionsPanel::default(),
            spots: SpotsPanel::default(),
            log: LogPanel::default(),
            selection_panel: SelectionPanel::default(),
            plots: PlotsPanel::default(),
            timeline: TimelinePanel::default(),
            transport: TransportBar::default(),
            pointer: PointerInput::default(),
            edge_hover: EdgeHover::default(),
            minimap: Minimap::default(),
            menu: Menu::default(),
            help: Help::default(),
            messages: Messages::default(),
            undo: Undo::default(),
            undoing: Vec::new(),
            last: LastPicture {
                left: None,
                plots: false,
                typing: false,
                window: Window::whole(16.0 / 9.0),
                camera,
                placement: Placement::new(Rect::ZERO),
                legend: LegendRoom { left: LEGEND_ROOM, below: 0.0 },
                reveals: false,
            },
            late_input: None,
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
        self.messages.add(text.into());
    }

    /// Hides a message.
    pub fn dismiss(&mut self, text: &str) {
        self.messages.remove(text);
    }

    /// The camera of the picture that was shown last. The elements over it were drawn with it,
    /// while a click on one of them may already have moved the camera on.
    pub fn shown_camera(&self) -> Camera {
        self.last.camera
    }

    /// Selects one item or nothing, and opens the selection panel for an item. The camera stays
    /// where it is, since the next click is aimed at what is there.
    pub fn select(&mut self, item: Option<Item>) {
        self.selection.set(item);
        self.open_selection();
        self.stay();
    }

    /// Selects a robot and shows where it is.
    pub fn show_robot(&mut self, robot: u32) {
        self.select_in_sight(Some(Item::Robot(robot)));
    }

    /// As [`Self::select`], by a key or in a panel: the item may be out of sight, and a camera that
    /// shows everything goes on to do so.
    pub(super) fn select_in_sight(&mut self, item: Option<Item>) {
        self.selection.set(item);
        self.open_selection();
        self.last.reveals = item.is_some();
    }

    /// Adds a robot to the selected ones, or removes it from them. Any other item is selected
    /// alone.
    pub fn toggle_selected(&mut self, item: Item) {
        self.selection.toggle(item);
        self.open_selection();
        self.stay();
    }

    fn open_selection(&mut self) {
        if self.selection.item.is_some() {
            self.settings.right = Some(RightPanel::Selection);
        }
    }

    fn stay(&mut self) {
        if self.selection.item.is_some() {
            self.camera_controller.stay();
        }
    }

    /// Returns the ids of the selected robots, the one in the selection panel first.
    pub fn robots(&self) -> Vec<u32> {
        self.selection.robots()
    }

    /// Returns the selected edge or node.
    pub fn marked(&self) -> Option<Marked> {
        self.selection.marked()
    }

    /// Opens the menu of the item under a right click, in points of the window.
    pub fn open_menu(&mut self, item: Option<Item>, at: egui::Pos2) {
        self.menu.open(item, at);
    }

    /// Uses a file that was dropped on the window: a mesh for the robots, any other file for the
    /// floor.
    pub fn use_file(&mut self, path: &Path) {
        self.view.use_file(path, &mut self.settings);
    }

    /// The log of the fleet.
    pub fn log(&mut self) -> &mut FleetLog {
        &mut self.log.log
    }

    /// Shows the reason for which a command of the user came to nothing, and keeps it in the log.
    pub fn tell_refusal(&mut self, command: UserCommand, text: String, time_nanos: u64) {
        self.notify(text.clone());
        self.log.add_refusal(command, text, time_nanos);
    }

    /// Adds an end to the measurement.
    pub fn measure_to(&mut self, end: End) {
        self.measuring.get_or_insert_default().add(end);
    }

    /// The edges and the node whose robots are shown, by their indices in the world.
    pub fn watched_places(&self) -> (Vec<u32>, Option<u32>) {
        let (edge, node) = match self.selection.marked() {
            Some(Marked::Edge(edge)) => (Some(edge), None),
            Some(Marked::Node(node)) => (None, Some(node)),
            None => (None, None),
        };
        let hovered = self.edge_hover.edge().filter(|hovered| Some(*hovered) != edge);
        (edge.into_iter().chain(hovered).collect(), node)
    }

    /// The names and the places of the elements over the picture, in points.
    pub fn placed(&self) -> &[(&'static str, Rect)] {
        self.last.placement.taken()
    }

    /// Lets a panel show itself, and carries out its requests.
    pub(super) fn present<R>(
        &mut self,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
        show: impl FnOnce(&mut Self, &PanelContext<'_>) -> R,
    ) -> R {
        let context = self.context(model);
        let shown = show(self, &context);
        for request in context.requests.into_inner() {
            self.carry_out(request, model, actions);
        }
        shown
    }

    fn context<'a>(&self, model: &'a ViewModel<'a>) -> PanelContext<'a> {
        let theme = self.settings.theme();
        PanelContext {
            model,
            theme,
            colours: style::colours(theme),
            offset: self.settings.offset,
            selection: self.selection.clone(),
            filter: self.filter.clone(),
            camera: self.camera_controller.camera(),
            followed: self.camera_controller.followed(),
            window: self.last.window,
            is_side_by_side: !self.parts().is_empty(),
            is_managed: self.log.log.is_managed(),
            requests: RefCell::default(),
        }
    }

    fn carry_out(&mut self, request: Request, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let camera = &mut self.camera_controller;
        match request {
            Request::Act(action) => actions.push(action),
            Request::Run(command) => self.run(command, model, actions),
            Request::Select(item) => self.select_in_sight(item),
            Request::SelectQuietly(item) => self.selection.set(item),
            Request::Toggle(item) => self.toggle_selected(item),
            Request::Describe(robot) => self.selection.describe(robot),
            Request::FlyTo(place) => camera.fly_to(place),
            Request::FlyToSelected => self.fly_to_selected(model),
            Request::FlyToCamera(wanted) => camera.fly_to_camera(wanted),
            Request::MoveTo(place) => camera.move_to(place),
            Request::Look { yaw, pitch } => camera.look(yaw, pitch),
            Request::Follow(follow) => camera.follow(follow),
            Request::Filter(filter) => {
                self.filter = filter.clone();
                actions.push(Action::Filter(filter));
            }
            Request::ShowLevel(level) => self.show_level(level),
            Request::ShowSideBySide(is_on) => self.show_side_by_side(is_on),
            Request::GoToTime(secs) => self.present(model, actions, |interface, context| {
                interface.timeline.go_to_time(context, secs);
            }),
            Request::Notify(text) => self.notify(text),
        }
    }

    pub(super) fn fly_to_selected(&mut self, model: &ViewModel<'_>) {
        let Some(place) = self.place_of_selected(model) else { return };
        match self.selection.robot() {
            Some(id) => self.camera_controller.fly_to_robot(id, place),
            None => self.camera_controller.fly_to(place),
        }
    }

    pub(super) fn place_of_selected(&self, model: &ViewModel<'_>) -> Option<Vec2> {
        let (offset, world) = (self.settings.offset, &model.world);
        match self.selection.item? {
            Item::Robot(id) => Some(model.pose(id, offset)?.place),
            Item::Node(index) => {
                world.nodes().get(index as usize).map(|node| Vec2::new(node.x, node.y) + offset)
            }
            Item::Edge(index) => {
                let edge = world.edges().get(index as usize)?;
                midpoint(world, edge).map(|middle| middle + offset)
            }
        }
    }
}
