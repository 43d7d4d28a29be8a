//! The assumptions of an answer, its inputs, and the way to repeat it.

use regatta_layout::traffic::Outline;

use super::Block;
use crate::answer::{Answer, VariantAnswer};
use crate::plan::{FleetType, robots_in_words};

/// The most remarks on the layout in the table of assumptions.
const MOST_REMARKS: usize = 2;

/// Returns the table of what the answer assumes, about the first variant.
pub(super) fn assumptions(answer: &Answer, of: &str) -> Vec<Block> {
    let Some(variant) = answer.variants.first() else { return Vec::new() };
    let method = &answer.method;
    let most = if method.is_day { " at most" } else { "" };
    let seeds = match method.seeds {
        [least, most] if least == most => least.to_string(),
        [least, most] => format!("{least} to {most}"),
    };
    let manager = match variant.is_managed_by_regatta {
        true => "Regatta's fleet manager",
        false => "a program of the user",
    };
    let layout = format!("{} nodes and {} edges.", variant.nodes, variant.edges);
    let remarks = answer.certificate.iter().take(MOST_REMARKS).cloned();
    let layout: Vec<String> = std::iter::once(layout).chain(remarks).collect();
    let rows = [
        ["assumption", "value"].map(str::to_owned),
        ["robots".to_owned(), robots(variant)],
        ["orders".to_owned(), variant.load.clone()],
        ["layout".to_owned(), layout.join(" ")],
        ["steered by".to_owned(), manager.to_owned()],
        ["a run".to_owned(), format!("{:.0} simulated minutes{most}", method.secs as f64 / 60.0)],
        [
            "runs".to_owned(),
            format!("{seeds} for each number of robots, each with a seed of its own"),
        ],
    ];
    vec![
        Block::Heading(2, format!("{of}Assumptions")),
        Block::Table(rows.map(|row| row.to_vec()).to_vec()),
    ]
}

/// The sizes and the speeds of the robots, by type if there are several.
pub(super) fn robots(variant: &VariantAnswer) -> String {
    let types = variant.robot_types.iter().map(|of| {
        let FleetType { name, outline, size: [length, width], max_speed, robots } = of;
        let speed = match max_speed {
            Some(speed) => format!("up to {speed} m/s"),
            None => "as fast as the roads allow".to_owned(),
        };
        let size = match outline {
            Outline::Rectangle => format!("{length} m × {width} m, {speed}"),
            Outline::Circle => format!("round, {length} m, {speed}"),
        };
        match (name, robots) {
            _ if variant.robot_types.len() == 1 => size,
            (None, _) => size,
            (Some(name), None) => format!("`{name}` ({size})"),
            (Some(name), Some(robots)) => format!("{robots} `{name}` ({size})"),
        }
    });
    let at_answer = match variant.robots() {
        Some(robots) if variant.robot_types.len() > 1 => {
            format!(", with {}", robots_in_words(robots))
        }
        _ => String::new(),
    };
    types.collect::<Vec<_>>().join(", ") + &at_answer
}

/// Returns the files that the study was made of, and the command that repeats it.
pub(super) fn repeat(answer: &Answer, command: &str) -> Vec<Block> {
    let mut rows = vec![["file", "XXH3-128"].map(str::to_owned).to_vec()];
    for input in &answer.inputs {
        rows.push(vec![format!("`{}`", input.name), format!("`{}`", input.hash)]);
    }
    for variant in &answer.variants {
        let name = if variant.name.is_empty() { "" } else { &*format!(" of {}", variant.name) };
        let hash = variant.layout_file.trim_end_matches(".yaml");
        let file = format!("the layout{name} as it was used: `files/{}`", variant.layout_file);
        rows.push(vec![file, format!("`{hash}`")]);
    }
    let program = &answer.program;
    vec![
        Block::Heading(2, "Inputs".to_owned()),
        Block::Table(rows),
        Block::Text("`xxh128sum FILE` prints the hash of a file.".to_owned()),
        Block::Heading(2, "How to repeat this".to_owned()),
        Block::Text(format!("`{command}`")),
        Block::Text(format!(
            "With Regatta {program} and these files, this command gives the same `study.json`, \
             byte for byte, on any machine. The seeds of each number of robots are 1, 2, 3 and so on. \
             `regatta study-run jobs/ID.json` in the study's folder repeats a single run; \
             `study.sqlite` has the command and the digest of each."
        )),
    ]
}
