//! The state and the facts that panels share, and the requests that they make.

use std::cell::RefCell;

use glam::Vec2;
use regatta_scene::camera::{Camera, Window};
use regatta_scene::palette::Theme;
use regatta_scene::{MAX_SELECTED, Marked};

use super::camera_controller::Follow;
use super::keys::Command;
use super::robot_filter::Filter;
use super::style::ThemeColours;
use super::view_model::{Action, Item, ViewModel};

/// The selected items.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// The item that the selection panel describes.
    pub item: Option<Item>,
    /// More selected robots, if `item` is a robot.
    others: Vec<u32>,
}

impl Selection {
    /// Selects one item, or nothing.
    pub fn set(&mut self, item: Option<Item>) {
        *self = Self { item, others: Vec::new() };
    }

    /// Adds a robot, or removes it. Any other item is selected alone.
    pub fn toggle(&mut self, item: Item) {
        let Item::Robot(id) = item else { return self.set(Some(item)) };
        let mut robots = self.robots();
        if robots.contains(&id) {
            robots.retain(|robot| *robot != id);
        } else {
            robots.insert(0, id);
        }
        robots.truncate(MAX_SELECTED);
        self.item = robots.first().map(|robot| Item::Robot(*robot));
        self.others = robots.split_off(robots.len().min(1));
    }

    /// Describes another one of the selected robots in the selection panel.
    pub fn describe(&mut self, id: u32) {
        if let Some(Item::Robot(shown)) = self.item {
            self.others.retain(|robot| *robot != id);
            self.others.insert(0, shown);
            self.item = Some(Item::Robot(id));
        }
    }

    /// Returns the robot that the selection panel describes.
    pub fn robot(&self) -> Option<u32> {
        if let Some(Item::Robot(id)) = self.item { Some(id) } else { None }
    }

    /// Returns the ids of the selected robots, the one in the selection panel first.
    pub fn robots(&self) -> Vec<u32> {
        let Some(id) = self.robot() else { return Vec::new() };
        [&[id], self.others.as_slice()].concat()
    }

    /// Returns the selected robots that the selection panel doesn't describe.
    pub fn others(&self) -> &[u32] {
        &self.others
    }

    /// Returns the selected edge or node.
    pub fn marked(&self) -> Option<Marked> {
        match self.item? {
            Item::Robot(_) => None,
            Item::Edge(index) => Some(Marked::Edge(index)),
            Item::Node(index) => Some(Marked::Node(index)),
        }
    }
}

/// A request of a panel to change something that isn't its own.
#[derive(Debug)]
pub(crate) enum Request {
    /// Leave an action to the caller of the interface.
    Act(Action),
    /// Carry out the command of a key.
    Run(Command),
    /// Select one item or nothing, and open the selection panel for an item.
    Select(Option<Item>),
    /// Select one item or nothing; panels stay as they are.
    SelectQuietly(Option<Item>),
    /// Add a robot to the selected ones, or remove it.
    Toggle(Item),
    /// Describe another one of the selected robots.
    Describe(u32),
    /// Fly to a place, in metres.
    FlyTo(Vec2),
    /// Fly to the selected item.
    FlyToSelected,
    /// Fly to a camera.
    FlyToCamera(Camera),
    /// Move the camera over a place, in metres.
    MoveTo(Vec2),
    /// Turn the camera, in radians.
    Look {
        /// Counter-clockwise from east.
        yaw: f32,
        /// Below the horizon.
        pitch: f32,
    },
    /// Follow a robot, or none.
    Follow(Option<(u32, Follow)>),
    /// Dim robots that don't match.
    Filter(Filter),
    /// Show one level only, or all.
    ShowLevel(Option<String>),
    /// Show all levels side by side, or no longer.
    ShowSideBySide(bool),
    /// Go to a time of the shown clock, in seconds.
    GoToTime(f64),
    /// Show a message.
    Notify(String),
}

/// The facts that a panel reads, and its requests.
#[derive(Debug)]
pub(crate) struct PanelContext<'a> {
    pub model: &'a ViewModel<'a>,
    pub theme: Theme,
    pub colours: ThemeColours,
    /// The offset of all positions, in metres.
    pub offset: Vec2,
    pub selection: Selection,
    pub filter: Filter,
    pub camera: Camera,
    /// The followed robot and the position from which it is followed.
    pub followed: Option<(u32, Follow)>,
    /// The part of the picture that no panel covers.
    pub window: Window,
    /// Whether levels are shown side by side.
    pub is_side_by_side: bool,
    /// Whether a fleet manager steers the robots.
    pub is_managed: bool,
    pub requests: RefCell<Vec<Request>>,
}

impl PanelContext<'_> {
    /// Makes a request, which is carried out as soon as the panel is shown.
    pub fn ask(&self, request: Request) {
        self.requests.borrow_mut().push(request);
    }

    /// Leaves an action to the caller of the interface.
    pub fn act(&self, action: Action) {
        self.ask(Request::Act(action));
    }

    /// Shows a message for some seconds.
    pub fn notify(&self, text: impl Into<String>) {
        self.ask(Request::Notify(text.into()));
    }

    /// The level that alone is shown, or that mouse and panels are about.
    pub fn level(&self) -> Option<&str> {
        self.filter.level.as_deref()
    }
}
