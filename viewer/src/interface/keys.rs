//! The keyboard: one table that both the help and the keys' effects come from.

use egui::{Context, Event, Key, Modifiers};

/// What one press does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// Pause, or go on.
    Pause,
    /// One tick.
    Step,
    /// Half the speed.
    Slower,
    /// Twice the speed.
    Faster,
    /// A fifth of the robots less.
    FewerRobots,
    /// A quarter of the robots more.
    MoreRobots,
    /// All in the picture.
    Fit,
    /// From straight above.
    Top,
    /// Behind the selected robot, above it, not.
    Follow,
    /// To what is selected.
    Fly,
    /// To a robot by its id.
    Find,
    /// The robot with the next id.
    Next,
    /// The robot with the id before.
    Previous,
    /// Nothing is selected any more.
    Deselect,
    /// The fleet list.
    Fleet,
    /// The collisions.
    Collisions,
    /// What is selected.
    Selection,
    /// How things are drawn.
    View,
    /// What takes the time.
    Performance,
    /// The engine, and UDP.
    Connection,
    /// The next colouring.
    Colour,
    /// The other theme.
    Theme,
    /// The graph, or not.
    Graph,
    /// A page of the open list back.
    PageUp,
    /// A page of the open list on.
    PageDown,
    /// This list.
    Help,
    /// All of the screen.
    FullScreen,
    /// The end.
    Quit,
}

/// A key, what it does, and how the help calls it.
struct Press(Modifiers, Key, Deed, &'static str);

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// Without a text, a second key for the deed above.
const PRESSES: &[Press] = &[
    Press(NONE, Key::Space, Deed::Pause, "pause, resume"),
    Press(NONE, Key::Period, Deed::Step, "one tick"),
    Press(NONE, Key::OpenBracket, Deed::Slower, "half the speed"),
    Press(NONE, Key::CloseBracket, Deed::Faster, "twice the speed"),
    Press(NONE, Key::K, Deed::FewerRobots, "a fifth of the robots less"),
    Press(NONE, Key::I, Deed::MoreRobots, "a quarter of the robots more"),
    Press(NONE, Key::Home, Deed::Fit, "all in the picture"),
    Press(NONE, Key::T, Deed::Top, "from above"),
    Press(NONE, Key::F, Deed::Follow, "follow: behind, above, not"),
    Press(NONE, Key::J, Deed::Fly, "fly to the selection"),
    Press(CTRL, Key::F, Deed::Find, "find a robot by its id"),
    Press(NONE, Key::N, Deed::Next, "next robot"),
    Press(NONE, Key::P, Deed::Previous, "previous robot"),
    Press(NONE, Key::Escape, Deed::Deselect, "deselect, close"),
    Press(NONE, Key::Num1, Deed::Fleet, "fleet"),
    Press(NONE, Key::Num2, Deed::Collisions, "collisions"),
    Press(NONE, Key::Num3, Deed::Selection, "selection"),
    Press(NONE, Key::Num4, Deed::View, "view"),
    Press(NONE, Key::Num5, Deed::Performance, "performance"),
    Press(NONE, Key::Num6, Deed::Connection, "connection"),
    Press(NONE, Key::PageUp, Deed::PageUp, "page of the list back"),
    Press(NONE, Key::PageDown, Deed::PageDown, "page of the list on"),
    Press(NONE, Key::C, Deed::Colour, "next colouring"),
    Press(NONE, Key::L, Deed::Theme, "light or dark"),
    Press(NONE, Key::G, Deed::Graph, "graph on, off"),
    Press(NONE, Key::Questionmark, Deed::Help, "this list"),
    Press(SHIFT, Key::Questionmark, Deed::Help, ""),
    Press(SHIFT, Key::Slash, Deed::Help, ""),
    Press(NONE, Key::F1, Deed::Help, ""),
    Press(NONE, Key::F11, Deed::FullScreen, "full screen"),
    Press(CTRL, Key::Q, Deed::Quit, "close"),
];

/// Keys that move the camera for as long as they are down.
const HELD: &[(&[Key], Hold, &str)] = &[
    (&[Key::W, Key::ArrowUp], Hold([0.0, 1.0, 0.0, 0.0, 0.0]), "forward"),
    (&[Key::S, Key::ArrowDown], Hold([0.0, -1.0, 0.0, 0.0, 0.0]), "back"),
    (&[Key::A, Key::ArrowLeft], Hold([-1.0, 0.0, 0.0, 0.0, 0.0]), "left"),
    (&[Key::D, Key::ArrowRight], Hold([1.0, 0.0, 0.0, 0.0, 0.0]), "right"),
    (&[Key::Q], Hold([0.0, 0.0, 1.0, 0.0, 0.0]), "turn left"),
    (&[Key::E], Hold([0.0, 0.0, -1.0, 0.0, 0.0]), "turn right"),
    (&[Key::R], Hold([0.0, 0.0, 0.0, 1.0, 0.0]), "look steeper"),
    (&[Key::V], Hold([0.0, 0.0, 0.0, -1.0, 0.0]), "look flatter"),
    (&[Key::Plus, Key::Equals], Hold([0.0, 0.0, 0.0, 0.0, -1.0]), "nearer"),
    (&[Key::Minus], Hold([0.0, 0.0, 0.0, 0.0, 1.0]), "farther"),
];

/// Mouse and touchpad, for the help.
pub const HANDS: &[(&str, &str)] = &[
    ("left drag", "turn round the target"),
    ("right, middle or Shift drag", "move over the ground"),
    ("wheel, pinch", "nearer, farther, towards the cursor"),
    ("two fingers", "move over the ground"),
    ("click", "select a robot, edge or node"),
    ("Ctrl or Cmd click", "select a robot more, or less"),
    ("Enter in the search", "select it; with Ctrl or Cmd, beside others"),
    ("double click", "fly there"),
];

/// Directions of a camera that keys hold: right, forward, turn left, steeper, farther; each -1, 0 or 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hold(pub [f32; 5]);

/// What was pressed since the last picture, unless a text field takes the keys.
pub fn pressed(context: &Context) -> Vec<Deed> {
    if context.egui_wants_keyboard_input() {
        let find = context.input_mut(|input| input.consume_key(CTRL, Key::F));
        return if find { vec![Deed::Find] } else { Vec::new() };
    }
    context.input(|input| {
        let pressed = input.events.iter().filter_map(|event| match event {
            Event::Key { key, pressed: true, modifiers, .. } => Some((*key, *modifiers)),
            _ => None,
        });
        pressed.filter_map(|(key, modifiers)| deed_of(key, modifiers)).collect()
    })
}

fn deed_of(key: Key, modifiers: Modifiers) -> Option<Deed> {
    let fits = |press: &&Press| press.1 == key && modifiers.matches_exact(press.0);
    PRESSES.iter().find(fits).map(|press| press.2)
}

/// Where held keys move the camera.
pub fn held(context: &Context) -> Hold {
    let mut all = Hold::default();
    if context.egui_wants_keyboard_input() {
        return all;
    }
    context.input(|input| {
        if input.modifiers.command || input.modifiers.alt {
            return;
        }
        for (keys, hold, _) in HELD {
            if keys.iter().any(|key| input.key_down(*key)) {
                all.0.iter_mut().zip(hold.0).for_each(|(all, part)| *all += part);
            }
        }
    });
    all
}

/// All keys and what they do.
pub fn list(context: &Context) -> Vec<(String, &'static str)> {
    let name = |modifiers: Modifiers, key: Key| match modifiers {
        NONE => name_of(key).to_owned(),
        _ => format!("{}+{}", context.format_modifiers(modifiers), name_of(key)),
    };
    let presses = PRESSES.iter().filter(|press| !press.3.is_empty());
    let presses = presses.map(|Press(modifiers, key, _, what)| (name(*modifiers, *key), *what));
    let held = HELD.iter().map(|(keys, _, what)| {
        let names: Vec<_> = keys.iter().map(|key| name_of(*key)).collect();
        (names.join("  "), *what)
    });
    held.chain(presses).collect()
}

/// As it stands on the key.
fn name_of(key: Key) -> &'static str {
    match key {
        Key::Period => ".",
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
    fn no_key_does_two_things() {
        let mut chords: Vec<_> = PRESSES.iter().map(|press| (format!("{:?}", press.0), press.1)).collect();
        chords.extend(HELD.iter().flat_map(|held| held.0).map(|key| (format!("{NONE:?}"), *key)));
        let count = chords.len();
        chords.sort();
        chords.dedup();
        assert_eq!(chords.len(), count);
    }
}
