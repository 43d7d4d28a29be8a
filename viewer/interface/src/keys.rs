//! The keyboard shortcuts: one table for both their commands and the help.

use std::ops::AddAssign;

use egui::{Context, Event, Key, Modifiers};

/// A command of a keyboard shortcut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause or resume the clock.
    Pause,
    /// Advance one tick.
    Step,
    /// Go back by one frame of a recording.
    StepBack,
    /// Go to the next mark.
    NextMark,
    /// Go to the previous mark.
    PreviousMark,
    /// Write a note about the shown time.
    Note,
    /// Begin a part of a recording to repeat, end it, or stop repeating.
    Loop,
    /// Show or hide the last minutes of a live run.
    Past,
    /// Halve the speed.
    Slower,
    /// Double the speed.
    Faster,
    /// Reduce the number of robots by 20 %.
    FewerRobots,
    /// Increase the number of robots by 25 %.
    MoreRobots,
    /// Fit everything into the picture.
    Fit,
    /// View everything from straight above.
    Top,
    /// Follow the selected robot: from behind, from above, off.
    Follow,
    /// Fly to the selected item.
    Fly,
    /// Open the search of the fleet list.
    Find,
    /// Select the robot with the next id.
    Next,
    /// Select the robot with the previous id.
    Previous,
    /// Deselect everything, or close the help or the panels.
    Deselect,
    /// Open or close the fleet panel.
    Fleet,
    /// Open or close the collisions panel.
    Collisions,
    /// Open or close the hot spots panel.
    Spots,
    /// Open or close the log panel.
    Log,
    /// Show or hide the figures over time.
    Plots,
    /// Open or close the selection panel.
    Selection,
    /// Open or close the view panel.
    View,
    /// Open or close the performance panel.
    Performance,
    /// Open or close the connection panel.
    Connection,
    /// Select the next colouring of the robots.
    Colour,
    /// Switch between the light and the dark theme.
    Theme,
    /// Show or hide the route graph.
    Graph,
    /// Show or hide the routes and goals of all robots.
    Plans,
    /// Show or hide who waits for whom.
    Waits,
    /// Show or hide the ids of robots.
    RobotIds,
    /// Switch between the plan and the view in perspective.
    Plan,
    /// Show or hide the minimap.
    Minimap,
    /// Begin or end measuring.
    Measure,
    /// Draw many small robots as their density, or mark each of them.
    Density,
    /// Show or hide the heat map.
    Heat,
    /// Show the heat map's next figure.
    NextFigure,
    /// Scroll the open list up by a page.
    PageUp,
    /// Scroll the open list down by a page.
    PageDown,
    /// Open or close the help.
    Help,
    /// Switch full screen on or off.
    FullScreen,
    /// Close the window.
    Quit,
}

/// A keyboard shortcut.
struct Shortcut {
    modifiers: Modifiers,
    key: Key,
    command: Command,
    /// The text in the help; empty for a second key of the command above.
    text: &'static str,
}

const fn shortcut(
    modifiers: Modifiers,
    key: Key,
    command: Command,
    text: &'static str,
) -> Shortcut {
    Shortcut { modifiers, key, command, text }
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;

const SHORTCUTS: &[Shortcut] = &[
    shortcut(NONE, Key::Space, Command::Pause, "pause, resume"),
    shortcut(NONE, Key::Period, Command::Step, "advance one tick"),
    shortcut(NONE, Key::Comma, Command::StepBack, "recording, past: one frame back"),
    shortcut(NONE, Key::X, Command::NextMark, "next mark (of a live run: note)"),
    shortcut(NONE, Key::Z, Command::PreviousMark, "previous mark"),
    shortcut(SHIFT, Key::N, Command::Note, "write a note at this time"),
    shortcut(NONE, Key::Y, Command::Loop, "recording: repeat a part from, to, end"),
    shortcut(NONE, Key::U, Command::Past, "live run: the last ten minutes"),
    shortcut(NONE, Key::OpenBracket, Command::Slower, "half the speed"),
    shortcut(NONE, Key::CloseBracket, Command::Faster, "twice the speed"),
    shortcut(NONE, Key::K, Command::FewerRobots, "20 % fewer robots"),
    shortcut(NONE, Key::I, Command::MoreRobots, "25 % more robots"),
    shortcut(NONE, Key::Home, Command::Fit, "fit everything"),
    shortcut(NONE, Key::T, Command::Top, "view from above"),
    shortcut(NONE, Key::F, Command::Follow, "follow: behind, above, off"),
    shortcut(NONE, Key::J, Command::Fly, "fly to the selection"),
    shortcut(CTRL, Key::F, Command::Find, "find a robot by id"),
    shortcut(NONE, Key::N, Command::Next, "next robot"),
    shortcut(NONE, Key::P, Command::Previous, "previous robot"),
    shortcut(NONE, Key::Escape, Command::Deselect, "deselect, close"),
    shortcut(NONE, Key::Num1, Command::Fleet, "fleet panel"),
    shortcut(NONE, Key::Num2, Command::Collisions, "collisions panel"),
    shortcut(NONE, Key::Num3, Command::Selection, "selection panel"),
    shortcut(NONE, Key::Num4, Command::View, "view panel"),
    shortcut(NONE, Key::Num5, Command::Performance, "performance panel"),
    shortcut(NONE, Key::Num6, Command::Connection, "connection panel"),
    shortcut(NONE, Key::Num7, Command::Spots, "hot spots panel"),
    shortcut(NONE, Key::Num8, Command::Plots, "figures over time"),
    shortcut(NONE, Key::Num9, Command::Log, "log and alarms"),
    shortcut(NONE, Key::PageUp, Command::PageUp, "list: page up"),
    shortcut(NONE, Key::PageDown, Command::PageDown, "list: page down"),
    shortcut(NONE, Key::C, Command::Colour, "next colouring"),
    shortcut(NONE, Key::L, Command::Theme, "light or dark theme"),
    shortcut(NONE, Key::G, Command::Graph, "show or hide the graph"),
    shortcut(NONE, Key::H, Command::Plans, "routes and goals of all robots"),
    shortcut(NONE, Key::B, Command::Waits, "who waits for whom"),
    shortcut(SHIFT, Key::U, Command::RobotIds, "ids of robots"),
    shortcut(NONE, Key::O, Command::Plan, "plan (orthographic) or perspective"),
    shortcut(SHIFT, Key::M, Command::Minimap, "minimap"),
    shortcut(NONE, Key::M, Command::Measure, "measure distance and clearance"),
    shortcut(SHIFT, Key::Z, Command::Density, "density of robots from afar"),
    shortcut(SHIFT, Key::H, Command::Heat, "heat map of the edges"),
    shortcut(SHIFT, Key::G, Command::NextFigure, "heat map: next figure"),
    shortcut(NONE, Key::Questionmark, Command::Help, "this help"),
    shortcut(SHIFT, Key::Questionmark, Command::Help, ""),
    shortcut(SHIFT, Key::Slash, Command::Help, ""),
    shortcut(NONE, Key::F1, Command::Help, ""),
    shortcut(NONE, Key::F11, Command::FullScreen, "full screen"),
    shortcut(CTRL, Key::Q, Command::Quit, "close the window"),
];

/// Keys that move the camera while they are held: keys, motion, text in the help.
const HELD_KEYS: &[(&[Key], CameraMotion, &str)] = &[
    (&[Key::W, Key::ArrowUp], CameraMotion { forward: 1.0, ..STILL }, "forward"),
    (&[Key::S, Key::ArrowDown], CameraMotion { forward: -1.0, ..STILL }, "backward"),
    (&[Key::A, Key::ArrowLeft], CameraMotion { right: -1.0, ..STILL }, "left"),
    (&[Key::D, Key::ArrowRight], CameraMotion { right: 1.0, ..STILL }, "right"),
    (&[Key::Q], CameraMotion { turn_left: 1.0, ..STILL }, "turn left"),
    (&[Key::E], CameraMotion { turn_left: -1.0, ..STILL }, "turn right"),
    (&[Key::R], CameraMotion { tilt_down: 1.0, ..STILL }, "tilt down"),
    (&[Key::V], CameraMotion { tilt_down: -1.0, ..STILL }, "tilt up"),
    (&[Key::Plus, Key::Equals], CameraMotion { zoom_out: -1.0, ..STILL }, "zoom in"),
    (&[Key::Minus], CameraMotion { zoom_out: 1.0, ..STILL }, "zoom out"),
];

/// Gestures of mouse and touchpad, for the help: gesture, effect.
pub const POINTER_GESTURES: &[(&str, &str)] = &[
    ("left drag", "orbit around the target"),
    ("right, middle or Shift drag", "pan over the ground"),
    ("wheel, pinch", "zoom in or out at the cursor"),
    ("two fingers", "pan over the ground"),
    ("click", "select a robot, edge or node"),
    ("Ctrl or Cmd click", "add a robot to the selection, or remove it"),
    ("Enter in the search", "select it; with Ctrl or Cmd, add it"),
    ("right click", "menu: hold, break, send, close an edge"),
    ("double click", "fly there"),
    ("left drag in a plan", "pan"),
    ("click while measuring", "one end, then the other: robots or places"),
];

/// The camera motion of held keys; each part is -1, 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMotion {
    /// Over the ground, to the right.
    pub right: f32,
    /// Over the ground, forward.
    pub forward: f32,
    /// Around the target, to the left.
    pub turn_left: f32,
    /// Around the target, downwards.
    pub tilt_down: f32,
    /// Away from the target.
    pub zoom_out: f32,
}

/// No motion.
pub const STILL: CameraMotion =
    CameraMotion { right: 0.0, forward: 0.0, turn_left: 0.0, tilt_down: 0.0, zoom_out: 0.0 };

impl AddAssign for CameraMotion {
    fn add_assign(&mut self, other: Self) {
        self.right += other.right;
        self.forward += other.forward;
        self.turn_left += other.turn_left;
        self.tilt_down += other.tilt_down;
        self.zoom_out += other.zoom_out;
    }
}

/// Returns the commands of the keys pressed since the last picture. A text field with the focus
/// gets all keys but Ctrl+F.
pub fn pressed(context: &Context) -> Vec<Command> {
    if context.egui_wants_keyboard_input() {
        let find = context.input_mut(|input| input.consume_key(CTRL, Key::F));
        return if find { vec![Command::Find] } else { Vec::new() };
    }
    context.input(|input| {
        let pressed = input.events.iter().filter_map(|event| match event {
            Event::Key { key, pressed: true, modifiers, .. } => Some((*key, *modifiers)),
            _ => None,
        });
        let mut commands: Vec<_> =
            pressed.filter_map(|(key, modifiers)| command_of(key, modifiers)).collect();
        // Later keys are for the search field.
        let find = commands.iter().position(|command| *command == Command::Find);
        commands.truncate(find.map_or(commands.len(), |find| find + 1));
        commands
    })
}

/// Takes the events out of a picture's input that came after Ctrl+F: at low picture rates they are
/// in the same picture, before the search field gets the focus. Pointer events stay.
pub fn take_input_after_find(context: &Context) -> Vec<Event> {
    context.input_mut(|input| {
        let find = input.events.iter().position(is_find);
        let after = find.map_or(input.events.len(), |at| at + 1);
        let late = input.events.split_off(after);
        let (typed, others): (Vec<_>, Vec<_>) = late.into_iter().partition(is_typed);
        input.events.extend(others);
        typed
    })
}

fn is_find(event: &Event) -> bool {
    match event {
        Event::Key { key: Key::F, pressed: true, modifiers, .. } => modifiers.matches_exact(CTRL),
        _ => false,
    }
}

fn is_typed(event: &Event) -> bool {
    matches!(event, Event::Text(_) | Event::Key { .. } | Event::Ime(_))
}

/// Whether a key is that of + and =. Where + is Shift and =, it may go up as the other one than it
/// went down as.
fn is_plus(key: &Key) -> bool {
    matches!(key, Key::Plus | Key::Equals)
}

fn command_of(key: Key, modifiers: Modifiers) -> Option<Command> {
    let shortcut = SHORTCUTS
        .iter()
        .find(|shortcut| shortcut.key == key && modifiers.matches_exact(shortcut.modifiers))?;
    Some(shortcut.command)
}

/// Returns the camera motion of the keys that are held.
pub fn held(context: &Context) -> CameraMotion {
    let mut all = STILL;
    if context.egui_wants_keyboard_input() {
        return all;
    }
    context.input_mut(|input| {
        if input
            .events
            .iter()
            .any(|event| matches!(event, Event::Key { key, pressed: false, .. } if is_plus(key)))
        {
            input.keys_down.retain(|key| !is_plus(key));
        }
        if input.modifiers.command || input.modifiers.alt {
            return;
        }
        for (keys, motion, _) in HELD_KEYS {
            if keys.iter().any(|key| input.key_down(*key)) {
                all += *motion;
            }
        }
    });
    all
}

/// Returns all keys with their texts in the help.
pub fn list(context: &Context) -> Vec<(String, &'static str)> {
    let mut list = Vec::new();
    for (keys, _, text) in HELD_KEYS {
        let names: Vec<_> = keys.iter().map(|key| name_of(*key)).collect();
        list.push((names.join("  "), *text));
    }
    for Shortcut { modifiers, key, text, .. } in SHORTCUTS {
        let name = match *modifiers {
            NONE => name_of(*key).to_owned(),
            held => format!("{}+{}", context.format_modifiers(held), name_of(*key)),
        };
        if !text.is_empty() {
            list.push((name, *text));
        }
    }
    list
}

/// Returns a key's name as printed on it.
fn name_of(key: Key) -> &'static str {
    match key {
        Key::Period => ".",
        Key::Comma => ",",
        Key::OpenBracket => "[",
        Key::CloseBracket => "]",
        Key::Questionmark => "?",
        Key::Escape => "Esc",
        Key::PageUp => "PgUp",
        Key::PageDown => "PgDn",
        Key::ArrowUp => "Up",
        Key::ArrowDown => "Down",
        Key::ArrowLeft => "Left",
        Key::ArrowRight => "Right",
        Key::Minus => "-",
        Key::Plus => "+",
        Key::Equals => "=",
        key => key.name(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_has_two_commands() {
        let mut chords: Vec<_> = SHORTCUTS
            .iter()
            .map(|shortcut| (format!("{:?}", shortcut.modifiers), shortcut.key))
            .collect();
        chords.extend(
            HELD_KEYS.iter().flat_map(|held| held.0).map(|key| (format!("{NONE:?}"), *key)),
        );
        let count = chords.len();
        chords.sort();
        chords.dedup();
        assert_eq!(chords.len(), count);
    }
}
