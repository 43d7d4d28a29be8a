//! The keyboard shortcuts by group, and the gestures of mouse and touchpad, with their texts.

use egui::{Key, Modifiers};

use super::Command;

/// Gestures of mouse and touchpad, for the help: gesture, effect.
pub(super) const POINTER_GESTURES: &[(&str, &str)] = &[
    ("left drag", "orbit around the target"),
    ("right or Shift drag", "pan over the ground"),
    ("wheel, pinch", "zoom in or out at the cursor"),
    ("two fingers", "pan over the ground"),
    ("click", "select a robot, edge or node"),
    ("Ctrl or Cmd click", "add or remove a robot"),
    ("Enter in search", "select it; with Ctrl, add it"),
    ("right click", "menu of a robot, node or edge"),
    ("double click", "fly there"),
    ("left drag in plan", "pan"),
    ("click in measuring", "one end, then the other"),
];

/// A keyboard shortcut.
pub(super) struct Shortcut {
    pub modifiers: Modifiers,
    pub key: Key,
    pub command: Command,
    /// The text in the help; empty for a second key of the command above.
    pub text: &'static str,
}

const fn shortcut(
    modifiers: Modifiers,
    key: Key,
    command: Command,
    text: &'static str,
) -> Shortcut {
    Shortcut { modifiers, key, command, text }
}

pub(super) const NONE: Modifiers = Modifiers::NONE;
pub(super) const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// The shortcuts by group, in the order of the help.
pub(super) const GROUPS: &[(&str, &[Shortcut])] = &[
    ("Time", TIME),
    ("Robots and places", ROBOTS),
    ("Camera", CAMERA),
    ("Panels", PANELS),
    ("Picture", PICTURE),
    ("Window", WINDOW),
];

/// The group to which held keys belong.
pub(super) const CAMERA_GROUP: &str = "Camera";

const TIME: &[Shortcut] = &[
    shortcut(NONE, Key::Space, Command::Pause, "pause, resume"),
    shortcut(NONE, Key::Period, Command::Step, "advance one tick"),
    shortcut(NONE, Key::Comma, Command::StepBack, "one frame back (recordings, past)"),
    shortcut(NONE, Key::X, Command::NextMark, "next mark (in a live run, the next note)"),
    shortcut(NONE, Key::Z, Command::PreviousMark, "previous mark"),
    shortcut(SHIFT, Key::N, Command::Note, "write a note at this time"),
    shortcut(NONE, Key::Y, Command::Loop, "loop: from here, to here, off (recordings)"),
    shortcut(NONE, Key::U, Command::Past, "the last ten minutes (live runs)"),
    shortcut(NONE, Key::OpenBracket, Command::Slower, "half the speed"),
    shortcut(NONE, Key::CloseBracket, Command::Faster, "twice the speed"),
];

const ROBOTS: &[Shortcut] = &[
    shortcut(CTRL, Key::F, Command::Find, "find a robot, place or order"),
    shortcut(NONE, Key::N, Command::Next, "next robot"),
    shortcut(NONE, Key::P, Command::Previous, "previous robot"),
    shortcut(NONE, Key::F, Command::Follow, "follow the robot: behind, above, off"),
    shortcut(NONE, Key::J, Command::Fly, "fly to the selection"),
    shortcut(NONE, Key::Escape, Command::Deselect, "deselect, close"),
    shortcut(NONE, Key::M, Command::Measure, "measure distance and clearance"),
    shortcut(NONE, Key::K, Command::FewerRobots, "20 % fewer robots"),
    shortcut(NONE, Key::I, Command::MoreRobots, "25 % more robots"),
    shortcut(CTRL, Key::Z, Command::Undo, "undo the last command to the fleet"),
];

const CAMERA: &[Shortcut] = &[
    shortcut(NONE, Key::Home, Command::Fit, "fit everything"),
    shortcut(NONE, Key::T, Command::Top, "view from above"),
    shortcut(NONE, Key::O, Command::Plan, "plan (orthographic) or perspective"),
    shortcut(SHIFT, Key::M, Command::Minimap, "minimap"),
];

const PANELS: &[Shortcut] = &[
    shortcut(NONE, Key::Num1, Command::Fleet, "fleet"),
    shortcut(NONE, Key::Num2, Command::Collisions, "collisions"),
    shortcut(NONE, Key::Num3, Command::Selection, "selection"),
    shortcut(NONE, Key::Num4, Command::View, "view"),
    shortcut(NONE, Key::Num5, Command::Performance, "performance"),
    shortcut(NONE, Key::Num6, Command::Connection, "connection"),
    shortcut(NONE, Key::Num7, Command::Spots, "hot spots"),
    shortcut(NONE, Key::Num8, Command::Plots, "figures over time"),
    shortcut(NONE, Key::Num9, Command::Log, "log and alarms"),
    shortcut(NONE, Key::PageUp, Command::PageUp, "list: page up"),
    shortcut(NONE, Key::PageDown, Command::PageDown, "list: page down"),
];

const PICTURE: &[Shortcut] = &[
    shortcut(NONE, Key::C, Command::Colour, "next colouring"),
    shortcut(NONE, Key::L, Command::Theme, "light or dark theme"),
    shortcut(NONE, Key::G, Command::Graph, "show or hide the graph"),
    shortcut(NONE, Key::H, Command::Plans, "routes and goals of all robots"),
    shortcut(NONE, Key::B, Command::Waits, "who waits for whom"),
    shortcut(SHIFT, Key::U, Command::RobotIds, "ids of robots"),
    shortcut(SHIFT, Key::Z, Command::Density, "density of robots from afar"),
    shortcut(SHIFT, Key::H, Command::Heat, "heat map of the edges"),
    shortcut(SHIFT, Key::G, Command::NextFigure, "heat map: next figure"),
];

const WINDOW: &[Shortcut] = &[
    shortcut(NONE, Key::Questionmark, Command::Help, "this help"),
    shortcut(SHIFT, Key::Questionmark, Command::Help, ""),
    shortcut(SHIFT, Key::Slash, Command::Help, ""),
    shortcut(NONE, Key::F1, Command::Help, ""),
    shortcut(CTRL, Key::O, Command::Open, "open a file"),
    shortcut(CTRL, Key::S, Command::Picture, "save the window as a picture"),
    shortcut(NONE, Key::F11, Command::FullScreen, "full screen"),
    shortcut(CTRL, Key::Q, Command::Quit, "close the window"),
];

/// All shortcuts.
pub(super) fn shortcuts() -> impl Iterator<Item = &'static Shortcut> {
    GROUPS.iter().flat_map(|(_, shortcuts)| *shortcuts)
}
