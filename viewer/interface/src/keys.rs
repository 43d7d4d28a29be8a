//! The keyboard shortcuts: one table for both their commands and the help.

mod table;

use std::ops::AddAssign;

use egui::{Context, Event, Key, Modifiers};

use table::{CAMERA_GROUP, CTRL, GROUPS, NONE, POINTER_GESTURES, Shortcut, shortcuts};

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
    /// Undo the last command to the fleet that can be undone.
    Undo,
    /// Ask for a layout, a scenario or a recording, and open it.
    Open,
    /// Save a picture of the window.
    Picture,
    /// Switch full screen on or off.
    FullScreen,
    /// Close the window.
    Quit,
}

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

/// The commands whose keys mean nothing in a text field. They work there, too.
const WHILE_TYPING: [Command; 6] = [
    Command::Find,
    Command::Picture,
    Command::Open,
    Command::Help,
    Command::FullScreen,
    Command::Quit,
];

/// Returns the commands of the keys pressed since the last picture. A text field with the focus
/// gets all keys but those of [`WHILE_TYPING`].
pub fn pressed(context: &Context) -> Vec<Command> {
    if context.egui_wants_keyboard_input() {
        let of_all = shortcuts().filter(|shortcut| WHILE_TYPING.contains(&shortcut.command));
        return context.input_mut(|input| {
            let pressed = of_all.filter(|shortcut| {
                // A letter alone, or a sign, is typed.
                let is_typed = shortcut.modifiers != CTRL && !is_function_key(shortcut.key);
                !is_typed && input.consume_key(shortcut.modifiers, shortcut.key)
            });
            pressed.map(|shortcut| shortcut.command).collect()
        });
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

fn is_function_key(key: Key) -> bool {
    matches!(key, Key::F1 | Key::F11)
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
    let shortcut = shortcuts()
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

/// A group of the help: its name, and inputs with their effects.
pub type HelpGroup = (&'static str, Vec<(String, &'static str)>);

/// Returns all keys and gestures with their texts in the help, by group.
pub fn help(context: &Context) -> Vec<HelpGroup> {
    let gestures = POINTER_GESTURES.iter().map(|(gesture, text)| ((*gesture).to_owned(), *text));
    let mut groups = vec![("Mouse and touchpad", gestures.collect())];
    for (name, shortcuts) in GROUPS {
        let held = if *name == CAMERA_GROUP { HELD_KEYS } else { &[] };
        let held = held.iter().map(|(keys, _, text)| (held_names(keys), *text));
        let shown = shortcuts.iter().filter(|shortcut| !shortcut.text.is_empty());
        let shown = shown.map(|shortcut| (shortcut.name(context), shortcut.text));
        groups.push((*name, held.chain(shown).collect()));
    }
    groups
}

impl Shortcut {
    /// The keys to press, as printed on them.
    fn name(&self, context: &Context) -> String {
        match self.modifiers {
            NONE => name_of(self.key).to_owned(),
            held => format!("{}+{}", context.format_modifiers(held), name_of(self.key)),
        }
    }
}

fn held_names(keys: &[Key]) -> String {
    keys.iter().map(|key| name_of(*key)).collect::<Vec<_>>().join("  ")
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
        let mut chords: Vec<_> = shortcuts()
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
