//! The time of orders and robots, by what it is spent on: stacked plots over the number of robots,
//! and tables at the answer.

use super::part::{colour, word};
use super::stack::{Bar, Part, stack};
use super::{Block, Picture};
use crate::answer::{Answer, GroupTime, PartAnswer, PointAnswer};
use crate::outcome::{ORDER_PARTS, STORAGE};

/// The most rows of a table; `study.json` has all.
const MOST_ROWS: usize = 12;

/// Returns the blocks about the time of orders and robots of the first variant.
pub(super) fn time(answer: &Answer, prefix: &str) -> Vec<Block> {
    let Some(variant) = answer.variants.first() else { return Vec::new() };
    let points = &variant.points;
    if points.iter().all(|point| point.order_time.is_empty()) {
        return Vec::new();
    }
    let mut blocks = vec![Block::Heading(2, format!("{prefix}Where the time goes"))];
    blocks.push(picture(
        "order-time",
        format!("{prefix}The time of an order, from its creation to its end"),
        &bars(points, |point| &point.order_time, 1.0),
        "seconds",
    ));
    blocks.push(picture(
        "robot-time",
        format!("{prefix}The time of the robots"),
        &bars(points, |point| &point.robot_time, 100.0),
        "per cent",
    ));
    let time = &answer.chosen.time;
    for (heading, groups) in
        [("from → to", &time.relations), ("picked at", &time.stations), ("hour", &time.hours)]
    {
        // One group has no more to tell than the plot.
        if groups.len() > 1 {
            blocks.push(table(heading, groups));
        }
    }
    blocks
}

fn picture(name: &'static str, caption: String, bars: &[Bar], unit: &str) -> Block {
    Block::Picture(Picture { name, caption, svg: stack(bars, unit) })
}

/// Returns a bar for each point that has figures.
fn bars(
    points: &[PointAnswer],
    parts: fn(&PointAnswer) -> &Vec<PartAnswer>,
    factor: f64,
) -> Vec<Bar> {
    let mut bars = Vec::new();
    for point in points.iter().filter(|point| !parts(point).is_empty()) {
        let parts = parts(point).iter().filter(|part| is_shown(part)).map(|part| Part {
            name: word(part.name),
            colour: colour(part.name),
            value: part.value.mean * factor,
        });
        bars.push(Bar { robots: point.robots, parts: parts.collect() });
    }
    bars
}

/// Whether a part is shown: most plants have no storages.
fn is_shown(part: &PartAnswer) -> bool {
    part.name != STORAGE || part.value.mean > 0.0
}

fn table(heading: &str, groups: &[GroupTime]) -> Block {
    let mut head = vec![heading.to_owned(), "orders".to_owned(), "service".to_owned()];
    let mut shown: Vec<usize> = (0..ORDER_PARTS.len()).collect();
    shown.retain(|part| {
        ORDER_PARTS[*part] != STORAGE || groups.iter().any(|group| group.parts_secs[*part] > 0.0)
    });
    head.extend(shown.iter().map(|part| word(ORDER_PARTS[*part]).to_owned()));
    let mut rows = vec![head];
    for group in groups.iter().take(MOST_ROWS) {
        let mut row = vec![group.name.clone(), format!("{:.1}", group.orders)];
        row.push(format!("{:.0} s", group.service_secs));
        row.extend(shown.iter().map(|part| format!("{:.0} s", group.parts_secs[*part])));
        rows.push(row);
    }
    Block::Table(rows)
}
