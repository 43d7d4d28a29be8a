//! The content of the page, as blocks.

use regatta_base::{grouped, thousands};

use super::assumptions::{assumptions, repeat};
use super::caveats::{caveats, has_findings, safety};
use super::chart::{Chart, ChartPoint, Series, chart};
use super::heat_map::heat_map;
use super::least::{figures, fleets};
use super::method::method;
use super::reliefs::{headline, reliefs};
use super::stall_map::stall_map;
use super::time::time;
use super::verdict::{has_too_few, numbers, orders_in_words, verdict};
use super::{Block, Picture, cost, peaks};
use crate::answer::{Answer, Comparison, Difference, NoRoom, PointAnswer, VariantAnswer};
use crate::bottleneck::Bottleneck;
use crate::plan::{Variant, robots_in_words};
use crate::statistics::Interval;
use crate::workers::NOT_ALL_PLACED;

/// Returns the blocks of a study's page. `base` is the first variant, and `command` the command
/// line of the study.
pub fn content(answer: &Answer, base: &Variant, command: &str) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(1, title(answer))];
    blocks.extend(answer.variants.iter().map(|variant| Block::Answer(sentence(answer, variant))));
    let first = answer.variants.first();
    blocks.extend(first.and_then(|variant| numbers(variant, &first_of_several(answer))));
    blocks.extend(fleets(answer));
    blocks.extend(peaks::finding(answer, &first_of_several(answer)));
    blocks.extend(cost::findings(answer));
    blocks.extend(headline(answer, &first_of_several(answer)));
    blocks.extend(caveats(answer).into_iter().map(Block::Caveat));
    blocks.extend(assumptions(answer, &first_of_several(answer)));
    blocks.extend(stall_picture(answer, base));
    blocks.push(match has_findings(answer) {
        true => Block::Caveat(safety(answer)),
        false => Block::Text(safety(answer)),
    });
    blocks.push(picture("throughput", &throughput_caption(answer), throughput_chart(answer)));
    blocks.extend(answer.variants.iter().flat_map(|variant| table(answer, variant)));
    blocks.push(picture("service", "Service time over robots", service_chart(answer)));
    let effort = format!("{}What robots spend their time on", first_of_several(answer));
    blocks.push(picture("effort", &effort, effort_chart(answer)));
    blocks.extend(time(answer, &first_of_several(answer)));
    blocks.extend(peaks::peaks(answer, &first_of_several(answer)));
    blocks.extend(cost::cost(answer));
    for comparison in &answer.comparisons {
        blocks.extend(comparison_blocks(answer, comparison));
    }
    blocks.extend(waiting(answer, base));
    blocks.extend(reliefs(answer, &first_of_several(answer)));
    if !answer.certificate.is_empty() {
        blocks
            .push(Block::Heading(2, format!("{}What the layout allows", first_of_several(answer))));
        blocks.extend(answer.certificate.iter().cloned().map(Block::Text));
    }
    blocks.push(Block::Heading(2, "Method".to_owned()));
    blocks.extend(method(answer).into_iter().map(Block::Text));
    blocks.extend(repeat(answer, command));
    blocks
}

/// Returns the answer for a variant; it has a capital unless the name of the variant is before it.
fn sentence(answer: &Answer, variant: &VariantAnswer) -> String {
    let text = verdict(answer, variant);
    let mut rest = text.chars();
    match rest.next() {
        Some(first) if variant.name.is_empty() => first.to_uppercase().chain(rest).collect(),
        _ => text,
    }
}

/// Returns the title of the page.
pub fn title(answer: &Answer) -> String {
    let verb = if answer.method.targets.is_empty() { "hold" } else { "need" };
    format!("How many robots does {} {verb}?", answer.title)
}

/// Returns the picture of the first variant's first stall whose places are known, that of the
/// fewest robots.
fn stall_picture(answer: &Answer, base: &Variant) -> Option<Block> {
    let variant = answer.variants.first()?;
    for point in &variant.points {
        for run in point.stalled() {
            let mut svgs =
                run.stalls.iter().filter_map(|stall| Some((stall, stall_map(&base.graph, stall)?)));
            if let Some((stall, svg)) = svgs.next() {
                let robots = robots_in_words(point.robots);
                let caption = format!(
                    "{}{robots}, seed {}, {}: robots without progress in \
                     orange, others in grey; arrows lead to the robot that each waits for",
                    first_of_several(answer),
                    run.seed,
                    stall.seen()
                );
                return Some(picture("stall", &caption, svg));
            }
        }
    }
    None
}

fn picture(name: &'static str, caption: &str, svg: String) -> Block {
    Block::Picture(Picture { name, caption: caption.to_owned(), svg })
}

/// The prefix for facts about the first variant alone: its name; empty if there are no others.
fn first_of_several(answer: &Answer) -> String {
    let first = answer.variants.first().filter(|_| answer.variants.len() > 1);
    first.map_or_else(String::new, |variant| format!("{}: ", variant.name))
}

fn throughput_caption(answer: &Answer) -> String {
    let mut points = answer.variants.iter().flat_map(|variant| &variant.points);
    let crosses = match points.any(|point| point.stalled().next().is_some()) {
        true => "; crosses: robots made no progress in a run, so that these figures aren't traffic",
        false => "",
    };
    format!("Throughput over robots{crosses}")
}

fn throughput_chart(answer: &Answer) -> String {
    let mut lines = Vec::new();
    for variant in &answer.variants {
        lines.push(series(name(variant), variant, |point| point.orders_per_hour));
    }
    chart_over_robots(answer, "orders an hour", lines, None)
}

fn service_chart(answer: &Answer) -> String {
    let mut lines = Vec::new();
    for variant in &answer.variants {
        let name = name(variant);
        lines.push(series(format!("{name}p50"), variant, |point| point.service_p50_secs));
        lines.push(series(format!("{name}p99"), variant, |point| point.service_p99_secs));
    }
    chart_over_robots(answer, "seconds from an order's creation to its end", lines, None)
}

/// A figure of a point.
type Figure = fn(&PointAnswer) -> Option<Interval>;

/// The shares of the robots' time and way in the chart of their effort.
const EFFORT: [(&str, Figure); 3] = [
    ("with an order", |point| point.utilisation),
    ("waiting", |point| point.waiting),
    ("of the way without a load", |point| point.empty),
];

fn effort_chart(answer: &Answer) -> String {
    let mut lines = Vec::new();
    if let Some(variant) = answer.variants.first() {
        for (name, figure) in EFFORT {
            let mut line = series(name.to_owned(), variant, figure);
            for point in &mut line.points {
                (point.mean, point.half_width) = (point.mean * 100.0, point.half_width * 100.0);
            }
            lines.push(line);
        }
    }
    lines.retain(|line| !line.points.is_empty());
    chart_over_robots(answer, "per cent", lines, Some(100.0))
}

/// Returns a chart with a mark at the first variant's answer. `most` is the largest value that is
/// possible.
fn chart_over_robots(answer: &Answer, y: &str, series: Vec<Series>, most: Option<f64>) -> String {
    let robots = answer.variants.first().and_then(VariantAnswer::robots);
    chart(&Chart { x: "robots", y, series, knee: robots.map(f64::from), most })
}

fn series(name: String, variant: &VariantAnswer, figure: Figure) -> Series {
    let mut points = Vec::new();
    for point in &variant.points {
        if let Some(Interval { mean, half_width, .. }) = figure(point) {
            let robots = f64::from(point.robots);
            let is_stalled = point.stalled().next().is_some();
            let half_width = half_width.unwrap_or(0.0);
            points.push(ChartPoint { robots, mean, half_width, is_stalled });
        }
    }
    Series { name, points }
}

fn name(variant: &VariantAnswer) -> String {
    if variant.name.is_empty() { String::new() } else { format!("{} ", variant.name) }
}

/// The columns of the table of points, before the targets.
const COLUMNS: [&str; 11] = [
    "robots",
    "orders an hour",
    "each",
    "service p50",
    "p99",
    "with an order",
    "waiting",
    "empty way",
    "contacts",
    "stalled",
    "seeds",
];

fn table(answer: &Answer, variant: &VariantAnswer) -> Vec<Block> {
    let mut head = row(COLUMNS);
    head.extend(answer.method.targets.iter().cloned());
    let mut rows = vec![head];
    for point in &variant.points {
        let is_answer = variant.robots() == Some(point.robots);
        let robots = thousands(point.robots.into());
        let robots = if is_answer { format!("**{robots}**") } else { robots };
        let mut row = vec![
            robots,
            orders_in_words(point).unwrap_or_else(|| NONE.to_owned()),
            text(point.orders_per_hour.filter(|_| !has_too_few(point)), |orders| {
                format!("{:.2}", orders.mean / f64::from(point.robots))
            }),
            text(point.service_p50_secs.filter(|_| !has_too_few(point)), |interval| {
                format!("{:.0} s", interval.mean)
            }),
            text(point.service_p99_secs.filter(|_| !has_too_few(point)), |interval| {
                format!("{:.0} s", interval.mean)
            }),
            text(point.utilisation, percent),
            text(point.waiting, percent),
            text(point.empty, percent),
            thousands(point.contacts),
            point.stalled().count().to_string(),
            point.runs.len().to_string(),
        ];
        row.extend(figures(point));
        rows.push(row);
    }
    let mut blocks = Vec::new();
    if answer.variants.len() > 1 {
        blocks.push(Block::Heading(3, variant.name.clone()));
    }
    blocks.push(Block::Table(rows));
    blocks.extend(variant.no_room.first().map(|first| Block::Text(no_room(variant, first))));
    blocks
}

/// Tells that a number of robots doesn't fit, and with which seeds if it fits with others.
fn no_room(variant: &VariantAnswer, NoRoom { robots, seeds, reason }: &NoRoom) -> String {
    let fits = variant.points.iter().any(|point| point.robots == *robots);
    let robots = robots_in_words(*robots);
    let list: Vec<String> = seeds.iter().map(u64::to_string).collect();
    let list = list.join(", ");
    match (fits, seeds.len()) {
        (false, _) => format!("With {robots}, {NOT_ALL_PLACED}: {reason}."),
        (true, 1) => format!("With {robots}, {NOT_ALL_PLACED} with seed {list}: {reason}."),
        (true, _) => format!("With {robots}, {NOT_ALL_PLACED} with seeds {list}: {reason}."),
    }
}

/// The text in place of a missing figure.
pub(super) const NONE: &str = "–";

fn text(interval: Option<Interval>, format: impl Fn(Interval) -> String) -> String {
    interval.map_or_else(|| NONE.to_owned(), format)
}

fn percent(interval: Interval) -> String {
    format!("{:.0} %", interval.mean * 100.0)
}

fn comparison_blocks(answer: &Answer, comparison: &Comparison) -> Vec<Block> {
    let base = answer.variants.first().map_or("", |base| &base.name);
    let mut rows = vec![row(["robots", base, &comparison.name, "difference"])];
    for difference in &comparison.differences {
        let Difference { robots, base, more_orders_per_hour } = difference;
        let other = base + more_orders_per_hour.mean;
        rows.push(vec![
            thousands((*robots).into()),
            grouped(*base, 0),
            grouped(other, 0),
            in_words(difference),
        ]);
    }
    let heading = format!("{} against {base}", comparison.name);
    let mut blocks = vec![Block::Heading(2, heading), Block::Table(rows)];
    blocks.extend(other_load(answer, comparison).map(Block::Caveat));
    blocks
}

/// Tells that the compared variants don't carry the same orders: stations are cut off in one only.
fn other_load(answer: &Answer, comparison: &Comparison) -> Option<String> {
    let base = answer.variants.first()?;
    let other = answer.variants.iter().find(|variant| variant.name == comparison.name)?;
    if base.left_out_stops == other.left_out_stops && base.other_stops == other.other_stops {
        return None;
    }
    Some(format!(
        "**Not the same orders**: `{}` and `{}` leave out different stations, so that the \
         difference isn't that of the roads alone.",
        base.name, other.name
    ))
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(str::to_owned).to_vec()
}

/// A difference with its interval, and a remark if it may be chance.
fn in_words(difference: &Difference) -> String {
    let Difference { base, more_orders_per_hour, .. } = difference;
    let percent = match *base > 0.0 {
        true => format!(" ({:+.1} %", 100.0 * more_orders_per_hour.mean / base),
        // There is no part of nothing.
        false => " (from none".to_owned(),
    };
    let half_width = match more_orders_per_hour.half_width {
        Some(half_width) => format!(" ± {half_width:.0}"),
        None => String::new(),
    };
    let chance = if difference.is_clear() { "" } else { ", within chance" };
    format!("{:+.0}{half_width} orders an hour{percent}{chance})", more_orders_per_hour.mean)
}

fn waiting(answer: &Answer, base: &Variant) -> Vec<Block> {
    let Some(robots) = answer.variants.first().and_then(VariantAnswer::robots) else {
        return Vec::new();
    };
    let (of, robots) = (first_of_several(answer), robots_in_words(robots));
    let mut blocks = vec![Block::Heading(2, format!("{of}Waiting, with {robots}"))];
    if answer.chosen.bottlenecks.is_empty() {
        let waiting = answered_point(answer).and_then(|point| point.waiting);
        let text = match waiting.map(|waiting| waiting.mean) {
            Some(share @ 0.005..) => format!(
                "Robots waited {:.0} % of their time, but for no place: their manager kept them \
                 where they were.",
                100.0 * share
            ),
            _ => "Nowhere: no robot stood and waited for another one.".to_owned(),
        };
        blocks.push(Block::Text(text));
        return blocks;
    }
    let map =
        heat_map(&base.graph, &answer.chosen.edges, &answer.chosen.bottlenecks, answer.method.secs);
    let caption = format!(
        "{of}The places where robots stand and wait, with {robots}. Each number marks a place that \
         they wait for."
    );
    blocks.push(picture("waiting", &caption, map));
    let mut rows =
        vec![row(["", "place", "robots waiting for it", "of all waiting", "kept out of edges"])];
    for (bottleneck, rank) in answer.chosen.bottlenecks.iter().zip(1..) {
        rows.push(bottleneck_row(bottleneck, rank));
    }
    blocks.push(Block::Table(rows));
    blocks
}

/// The point of the first variant that the answer is about.
fn answered_point(answer: &Answer) -> Option<&PointAnswer> {
    let variant = answer.variants.first()?;
    let robots = variant.robots()?;
    variant.points.iter().find(|point| point.robots == robots)
}

fn bottleneck_row(bottleneck: &Bottleneck, rank: usize) -> Vec<String> {
    let edges: Vec<String> = bottleneck.edges.iter().take(4).map(u32::to_string).collect();
    let more = if bottleneck.edges.len() > 4 { " …" } else { "" };
    vec![
        rank.to_string(),
        bottleneck.place(),
        format!("{:.2}", bottleneck.robots_waiting),
        format!("{:.1} %", bottleneck.share * 100.0),
        format!("{}{more}", edges.join(", ")),
    ]
}
