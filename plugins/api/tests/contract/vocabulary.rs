//! The words of the interface stand in `docs/glossary.md`.

use regatta_plugin::activity::{Activity, Ground};

const GLOSSARY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/glossary.md");

#[test]
fn the_glossary_has_every_activity_with_its_colours() {
    let glossary = std::fs::read_to_string(GLOSSARY).expect("the glossary");
    for activity in Activity::ALL {
        let [dark, light] = [Ground::Dark, Ground::Light].map(|ground| activity.colour(ground));
        let row = format!("| {} | `#{dark:06x}` | `#{light:06x}` |", activity.name());
        assert!(glossary.contains(&row), "no row begins with {row}");
    }
}

/// The words of the interface beside the activities.
const WORDS: [&str; 17] = [
    "busy",
    "checker lag",
    "contact",
    "cycle",
    "frame age",
    "frames",
    "jitter",
    "knee",
    "main part",
    "made-up orders",
    "master, vehicle",
    "released, planned",
    "single track",
    "target, met, missed, open",
    "tick cost",
    "utilisation",
    "zone",
];

#[test]
fn the_glossary_has_the_other_words_of_the_interface() {
    let glossary = std::fs::read_to_string(GLOSSARY).expect("the glossary");
    for word in WORDS {
        assert!(glossary.contains(&format!("| {word} | ")), "no row begins with {word}");
    }
}
