//! All texts of the window, in one file to read, and the rules that they follow.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::NodeT;
use regatta_interface::settings::{LeftPanel, RightPanel};

use crate::checks::texts as painted;
use crate::fixture::{Fixture, harness_of};
use crate::states::{STATES, State};

#[path = "../../../../tests/processes/texts.rs"]
mod file;

/// Texts, each with the first state that has it, and without its numbers.
type Texts = BTreeMap<String, (String, String)>;

/// The size of the window.
const WINDOW: [f32; 2] = [1600.0, 1000.0];
/// The key of the help.
const HELP: [Key; 1] = [Key::F1];

/// The texts of a window: those that are painted, and the names of controls.
fn texts(harness: &Harness<'_, Fixture>) -> Vec<String> {
    let nodes = harness.root().children_recursive();
    let names =
        nodes.filter_map(|node| node.accesskit_node().label().map(|label| label.to_string()));
    let painted = painted(harness).into_iter().map(|(text, ..)| text.galley.text().to_owned());
    names.chain(painted).collect()
}

/// Adds the texts of a state to those that are known.
fn add(known: &mut Texts, state: &str, harness: &Harness<'_, Fixture>) {
    for text in texts(harness) {
        let is_word = text.chars().filter(|letter| letter.is_alphabetic()).count() > 1;
        let without_numbers: String =
            text.chars().map(|letter| if letter.is_ascii_digit() { '0' } else { letter }).collect();
        // Of rows that differ in numbers alone, one is enough.
        if is_word && !known.values().any(|(_, other)| *other == without_numbers) {
            known.insert(text, (state.to_owned(), without_numbers));
        }
    }
}

/// All texts of the window, with the states in which they are shown.
fn all() -> Texts {
    let mut known = Texts::new();
    for State { name, prepare, keys, .. } in STATES {
        let mut harness = harness_of(WINDOW, 1.0, prepare);
        keys.iter().for_each(|key| harness.key_press(*key));
        harness.run_steps(6);
        add(&mut known, name, &harness);
    }
    for left in [LeftPanel::Fleet, LeftPanel::Collisions, LeftPanel::Spots, LeftPanel::Log] {
        let harness = harness_of(WINDOW, 1.0, |fixture| {
            fixture.interface.settings.left = Some(left);
        });
        add(&mut known, &format!("panel {left:?}"), &harness);
    }
    use RightPanel::{Connection, Performance, Selection, View};
    for right in [Selection, View, Performance, Connection] {
        let mut harness = harness_of(WINDOW, 1.0, |_| {});
        harness.state_mut().interface.settings.right = Some(right);
        harness.run_steps(6);
        add(&mut known, &format!("panel {right:?}"), &harness);
    }
    let mut harness = harness_of(WINDOW, 1.0, |_| {});
    HELP.iter().for_each(|key| harness.key_press(*key));
    harness.run_steps(6);
    add(&mut known, "help", &harness);
    known
}

/// Writes the texts into the file of all texts, for a person to read.
#[test]
fn texts_of_the_window_are_in_one_file_and_have_no_slips() {
    let known = all();
    let mut lines = String::new();
    for (text, (state, _)) in &known {
        writeln!(lines, "{state:<20} {}", text.replace('\n', " ⏎ ")).expect("a text");
    }
    println!("{}", file::write("Window", &lines));
    assert!(known.len() > 120, "{}", known.len());
    for (text, (state, _)) in &known {
        // Columns of figures are aligned by two spaces.
        let is_sentence = text.contains(". ") || text.contains(", ");
        assert!(!is_sentence || !text.contains("  "), "{state}: two spaces in '{text}'");
        assert!(!text.contains(" ,") && !text.contains(" ;"), "{state}: '{text}'");
        assert!(!text.starts_with("-0") && !text.contains("Robot("), "{state}: '{text}'");
        for slip in ["robot s ", "1 robots", "1 orders", "an hours", "0.0%"] {
            assert!(!text.starts_with(slip) && !text.contains(&format!(" {slip}")), "'{text}'");
        }
    }
}
