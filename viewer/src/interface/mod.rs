//! The interface over the pictures: panels, keys and hands. It shows [`Facts`], keeps what a person has chosen, and
//! gives [`Action`]s; it draws with egui and knows neither windows nor graphics cards, so tests drive it as it is.

mod bars;
mod collisions;
mod connection;
mod deeds;
pub mod facts;
mod fleet_list;
mod hands;
mod help;
mod icons;
mod keys;
pub mod labels;
mod list;
mod look;
pub mod overlay;
pub mod performance;
pub mod rig;
pub mod rows;
mod selection;
pub mod settings;
pub mod style;
mod transport;

use egui::{CentralPanel, Panel, Rect, ScrollArea, Ui};
use glam::Vec2;

use crate::palette::Theme;
use crate::scene::MAX_SELECTED;
use facts::{Action, Facts, Thing};
use fleet_list::FleetList;
use hands::Grip;
use list::Scroll;
use look::Files;
use rig::Rig;
use selection::History;
use settings::{Left, Right, Settings};
use style::Tones;
use transport::Drafts;

/// Seconds that a message stays.
const NOTICE: f64 = 8.0;
/// Most messages at a time.
const NOTICES: usize = 4;

/// The interface, and what a person has chosen in it.
#[derive(Debug)]
pub struct Interface {
    /// What is kept from one start to the next.
    pub settings: Settings,
    /// What moves the camera.
    pub rig: Rig,
    /// What is selected: what it is stands in a panel.
    pub selected: Option<Thing>,
    /// Robots that are selected beside that robot.
    beside: Vec<u32>,
    list: FleetList,
    collision_scroll: Scroll,
    history: History,
    drafts: Drafts,
    files: Files,
    help: bool,
    grip: Option<Grip>,
    /// Whether a text field had the keys in the last picture.
    typing: bool,
    /// Width over height of the picture.
    aspect: f32,
    /// Messages, and when they go.
    notices: Vec<(String, Option<f64>)>,
    styled: Option<(Theme, f32)>,
}

impl Interface {
    /// Starts with settings and a camera.
    pub fn new(settings: Settings, rig: Rig) -> Self {
        Self {
            files: Files::new(&settings),
            settings,
            rig,
            selected: None,
            beside: Vec::new(),
            list: FleetList::default(),
            collision_scroll: Scroll::default(),
            history: History::default(),
            drafts: Drafts::default(),
            help: false,
            grip: None,
            typing: false,
            aspect: 16.0 / 9.0,
            notices: Vec::new(),
            styled: None,
        }
    }

    /// To be shown by another context: that has to be told again how things look.
    #[must_use]
    pub fn undressed(self) -> Self {
        Self { styled: None, ..self }
    }

    /// Tells something, for some seconds.
    pub fn tell(&mut self, text: impl Into<String>) {
        let text = text.into();
        self.notices.retain(|(other, _)| *other != text);
        self.notices.push((text, None));
        let surplus = self.notices.len().saturating_sub(NOTICES);
        self.notices.drain(..surplus);
    }

    /// Selects something, or nothing, and shows what it is.
    pub fn select(&mut self, thing: Option<Thing>) {
        self.beside.clear();
        self.selected = thing;
        if thing.is_some() {
            self.settings.right = Some(Right::Selection);
        }
    }

    /// Selects a robot beside those that are, or takes it out of them; selects anything else alone.
    pub fn select_beside(&mut self, thing: Thing) {
        let Thing::Robot(id) = thing else { return self.select(Some(thing)) };
        let mut robots = self.robots();
        if robots.contains(&id) {
            robots.retain(|robot| *robot != id);
        } else {
            robots.insert(0, id);
        }
        robots.truncate(MAX_SELECTED);
        self.select(robots.first().map(|robot| Thing::Robot(*robot)));
        self.beside = robots.split_off(robots.len().min(1));
    }

    /// The robots that are selected, the one in the panel first.
    pub fn robots(&self) -> Vec<u32> {
        let Some(Thing::Robot(id)) = self.selected else { return Vec::new() };
        [&[id], self.beside.as_slice()].concat()
    }

    /// Shows everything, and takes what keys and hands do. Returns where the picture is, in points, and what is to
    /// be done.
    pub fn show(&mut self, ui: &mut Ui, facts: &Facts<'_>) -> (Rect, Vec<Action>) {
        let mut actions = Vec::new();
        self.dress(ui);
        self.keys(ui.ctx(), facts, &mut actions);
        self.typing = ui.ctx().egui_wants_keyboard_input();
        self.remember(facts);
        let frame = style::panel(self.settings.theme());
        Panel::top("top").exact_size(42.0).resizable(false).frame(frame).show(ui, |ui| self.top_bar(ui, facts));
        Panel::bottom("bottom")
            .exact_size(48.0)
            .resizable(false)
            .frame(frame)
            .show(ui, |ui| self.transport(ui, facts, &mut actions));
        self.left(ui, facts, &mut actions);
        self.right(ui, facts, &mut actions);
        let picture = CentralPanel::no_frame()
            .show(ui, |ui| {
                let picture = ui.max_rect();
                self.hands(ui, picture, &mut actions);
                picture
            })
            .inner;
        self.overlay(ui.ctx(), picture, facts);
        self.help(ui.ctx());
        self.move_camera(ui, picture, facts);
        (picture, actions)
    }

    fn dress(&mut self, ui: &Ui) {
        let wanted = (self.settings.theme(), self.settings.scale);
        if self.styled != Some(wanted) {
            style::apply(ui.ctx(), wanted.0);
            ui.ctx().set_zoom_factor(wanted.1);
            self.styled = Some(wanted);
        }
    }

    /// Fits all into the picture until somebody moves the camera, and lets it follow and fly.
    fn move_camera(&mut self, ui: &Ui, picture: Rect, facts: &Facts<'_>) {
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        self.rig.advance(seconds.into(), facts.followed);
        if picture.is_positive() {
            self.rig.keep_fitted(facts.bounds, picture.aspect_ratio());
            self.aspect = picture.aspect_ratio();
        }
        if self.rig.is_flying() {
            ui.ctx().request_repaint();
        }
    }

    fn remember(&mut self, facts: &Facts<'_>) {
        if let (Some(Thing::Robot(id)), Some(frame)) = (self.selected, facts.frame) {
            self.history.push(&frame, id);
        }
    }

    fn left(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let Some(shown) = self.settings.left else { return };
        let panel = Panel::left("left").default_size(290.0).size_range(270.0..=460.0);
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| match shown {
            Left::Fleet => self.fleet_list(ui, facts, actions),
            Left::Collisions => self.collisions(ui, facts),
        });
    }

    fn right(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let Some(shown) = self.settings.right else { return };
        let panel = Panel::right("right").default_size(280.0).size_range(220.0..=460.0);
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match shown {
                Right::Selection => self.selection(ui, facts),
                Right::View => self.look(ui, facts),
                Right::Performance => self.performance(ui, facts),
                Right::Connection => self.connection(ui, facts, actions),
            });
        });
    }

    fn tones(&self) -> Tones {
        style::tones(self.settings.theme())
    }

    fn fly_to_selected(&mut self, facts: &Facts<'_>) {
        if let Some(place) = self.place_of_selected(facts) {
            self.rig.fly_to(place);
        }
    }

    fn place_of_selected(&self, facts: &Facts<'_>) -> Option<Vec2> {
        let offset = Vec2::from(self.settings.offset);
        match self.selected? {
            Thing::Robot(id) => Some(facts.pose(id, offset)?.place),
            Thing::Node(index) => facts.nodes.get(index as usize).map(|node| Vec2::new(node.x, node.y) + offset),
            Thing::Edge(index) => {
                let points = facts.edges.get(index as usize)?.control_points.map(Vec2::from);
                // The middle of a cubic Bézier curve.
                Some((points[0] + 3.0 * points[1] + 3.0 * points[2] + points[3]) / 8.0 + offset)
            }
        }
    }
}
