//! Timetables: the orders of a day, as they are, or drawn anew from blocks of them.
//!
//! ```yaml
//! load:
//!   orders: day.csv     # a file of orders, beside this one
//!   scale: 1.2          # orders for each order of the file; 1 if absent
//!   shift: 300          # seconds by which all come later; 0 if absent
//!   resample: 1800      # seconds of a block: each seed has another day of the same kind
//!   dwell: {min: 5, max: 15}  # seconds at stops for which the file has none, a distribution
//!   deadline: 900       # seconds from the creation of orders for which the file has none
//!   robot_types: [amr]  # those that may get orders for which the file names no robots
//! ```
//!
//! With `timetable` in place of `orders`, the text of the file stands there.
//!
//! Days are drawn by the local block bootstrap (Paparoditis and Politis, Comptes Rendus de
//! l'Académie des Sciences 335, 2002): time is cut into blocks, and each block gets the orders of
//! itself or of one of its two neighbours, each with the same probability. So a day keeps its
//! peaks, and orders that come together still do.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use regatta_base::random::Random;
use regatta_base::yaml::{self, Fields, Node};

use super::dwell::Dwell;
use super::file::{TimedDraft, parse_csv, read_orders};
use super::load::robot_types;
use super::order::{NewOrder, OrderName};
use super::places::Places;

/// The random numbers of timetables, by purpose; those of generators are parts 1, 2 … of the seed.
const TIMETABLE: u64 = u64::MAX;
const BLOCKS: u64 = 0;
const COPIES: u64 = 1;
const GAPS: u64 = 2;
const DWELL: u64 = 3;
/// The largest scale, the shortest block in seconds, and the most blocks of a timetable.
const MAX_SCALE: f64 = 100.0;
const LEAST_BLOCK_SECS: f64 = 60.0;
const MOST_BLOCKS: f64 = 1e5;

/// The orders of a day.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Timetable {
    /// By ascending times of creation, in seconds.
    orders: Vec<(f64, NewOrder)>,
    /// The mean number of orders for each of them.
    scale: f64,
    /// All come later by this.
    shift_secs: f64,
    /// The length of the blocks of which days are drawn; `None` for the day as it is.
    block_secs: Option<f64>,
    /// The dwell times at stops without one.
    dwell: Dwell,
    /// The time from the creation to the deadline of orders without one.
    deadline_secs: Option<f64>,
    /// The robot types that may get orders which name no robots.
    robot_types: Vec<u32>,
}

/// An order of a timetable at a time.
#[derive(Clone, Copy)]
struct Drawn<'a> {
    secs: f64,
    /// The time that it has in the file.
    file_secs: f64,
    order: &'a NewOrder,
}

impl Timetable {
    /// Reads a timetable, if a load has one. Files are beside the load, in a folder; a load that is
    /// no file has none.
    pub(super) fn read(
        load: &Node,
        fields: &Fields<'_, '_>,
        folder: Option<&Path>,
        places: &Places,
    ) -> Result<Option<Self>, yaml::Error> {
        let (field, drafts) = match (fields.get("orders"), fields.get("timetable")) {
            (None, None) => {
                return match ["scale", "shift", "resample"].map(|key| fields.get(key)) {
                    [None, None, None] => Ok(None),
                    _ => Err(load.error("scale, shift and resample are for a load with `orders`")),
                };
            }
            (Some(field), None) => (field, beside(field, folder)?),
            (None, Some(field)) => (field, inline(field)?),
            (Some(_), Some(_)) => {
                return Err(load.error("give either `orders` or `timetable`, not both"));
            }
        };
        let mut orders =
            check_orders(&drafts, places).map_err(|error| field.error(error.to_string()))?;
        if orders.is_empty() {
            return Err(field.error("there are no orders in it"));
        }
        orders.sort_by(|a, b| a.0.total_cmp(&b.0));
        let block_secs = fields.optional("resample", |value| block_secs(value, &orders))?;
        Ok(Some(Self {
            orders,
            scale: fields.optional("scale", scale)?.unwrap_or(1.0),
            shift_secs: fields.optional("shift", Node::non_negative)?.unwrap_or(0.0),
            block_secs,
            dwell: fields
                .optional("dwell", |value| Dwell::read(value, places))?
                .unwrap_or_default(),
            deadline_secs: fields.optional("deadline", Node::non_negative)?,
            robot_types: robot_types(fields, places)?,
        }))
    }

    /// Returns the orders of a seed with their times of creation, by ascending times.
    pub(super) fn orders(&self, seed: u64) -> Vec<(f64, NewOrder)> {
        let random = Random::new(seed).part(TIMETABLE);
        let day = self.scaled(self.day(random.part(BLOCKS)), random);
        let mut names = BTreeSet::new();
        let mut orders = Vec::with_capacity(day.len());
        for (drawn, number) in day.iter().zip(0..) {
            let name = new_name(&drawn.order.name, number, &mut names);
            let secs = drawn.secs + self.shift_secs;
            let order = self.moved(drawn, secs - drawn.file_secs, random.part(DWELL).part(number));
            orders.push((secs, NewOrder { name, ..order }));
        }
        orders
    }

    /// The orders of a day, as they are or block by block.
    fn day(&self, random: Random) -> Vec<Drawn<'_>> {
        let file =
            self.orders.iter().map(|(secs, order)| Drawn { secs: *secs, file_secs: *secs, order });
        let Some(block_secs) = self.block_secs else { return file.collect() };
        let mut blocks: BTreeMap<u64, Vec<Drawn<'_>>> = BTreeMap::new();
        for drawn in file {
            blocks.entry((drawn.secs / block_secs) as u64).or_default().push(drawn);
        }
        let (first, last) = (blocks.keys().next(), blocks.keys().next_back());
        let (Some(&first), Some(&last)) = (first, last) else { return Vec::new() };
        let mut day = Vec::new();
        for block in first..=last {
            // The block itself, the one before or the one after.
            let from = block
                .saturating_add(random.below(block, 3) as u64)
                .saturating_sub(1)
                .clamp(first, last);
            let later_secs = (block as f64 - from as f64) * block_secs;
            let orders = blocks.get(&from).into_iter().flatten();
            day.extend(orders.map(|drawn| Drawn { secs: drawn.secs + later_secs, ..*drawn }));
        }
        day
    }

    /// Repeats orders, or leaves them out, so that there are `scale` for each. A copy comes at
    /// random until the next order.
    fn scaled<'a>(&self, day: Vec<Drawn<'a>>, random: Random) -> Vec<Drawn<'a>> {
        if self.scale == 1.0 {
            return day;
        }
        let (copies, gaps) = (random.part(COPIES), random.part(GAPS));
        let mut scaled = Vec::new();
        for (drawn, number) in day.iter().zip(0_u64..) {
            let next = day.get(number as usize + 1).unwrap_or(drawn);
            let count =
                self.scale.floor() as u64 + u64::from(copies.unit(number) <= self.scale.fract());
            for copy in 0..count {
                let gap = if copy == 0 { 0.0 } else { gaps.part(number).unit(copy) };
                scaled.push(Drawn { secs: drawn.secs + gap * (next.secs - drawn.secs), ..*drawn });
            }
        }
        scaled.sort_by(|a, b| a.secs.total_cmp(&b.secs));
        scaled
    }

    /// Returns an order that comes later by some seconds, with the times that it lacks.
    fn moved(&self, drawn: &Drawn<'_>, later_secs: f64, random: Random) -> NewOrder {
        let mut order = drawn.order.clone();
        if order.earliest_secs > 0.0 {
            order.earliest_secs = (order.earliest_secs + later_secs).max(0.0);
        }
        if order.robot_types.is_empty() && order.intended_robot.is_none() {
            order.robot_types.clone_from(&self.robot_types);
        }
        let secs = drawn.file_secs + later_secs;
        let of_file = order.deadline_secs.map(|deadline| deadline + later_secs);
        order.deadline_secs = of_file.or_else(|| Some(secs + self.deadline_secs?));
        for (stop, draw) in order.stops.iter_mut().zip(0..) {
            if stop.dwell_secs == 0.0 {
                stop.dwell_secs = self.dwell.secs(stop.node, stop.action, random, draw);
            }
        }
        order
    }
}

/// Reads the file of orders that a field names.
fn beside(field: &Node, folder: Option<&Path>) -> Result<Vec<TimedDraft>, yaml::Error> {
    let path = field.text()?;
    let Some(folder) = folder else {
        return Err(field.error("only a load that is a file can name a file of orders"));
    };
    read_orders(&folder.join(path.as_ref())).map_err(|error| field.error(error.to_string()))
}

fn inline(field: &Node) -> Result<Vec<TimedDraft>, yaml::Error> {
    parse_csv(&field.text()?).map_err(|error| field.error(error.to_string()))
}

/// Checks the orders of a file, and finds their nodes.
///
/// # Errors
/// [`yaml::Error`] if an order is wrong, or two have the same name.
pub fn check_orders(
    drafts: &[TimedDraft],
    places: &Places,
) -> Result<Vec<(f64, NewOrder)>, yaml::Error> {
    let (mut orders, mut names) = (Vec::with_capacity(drafts.len()), BTreeSet::new());
    for TimedDraft { line, secs, draft } in drafts {
        let order =
            draft.named_by_line(*line).and_then(|(draft, name)| draft.check(places, || name));
        let order =
            order.map_err(|error| yaml::Error { line: *line, reason: error.to_string() })?;
        if !names.insert(order.name.clone()) {
            let reason = format!("there are two orders `{}`", order.name);
            return Err(yaml::Error { line: *line, reason });
        }
        orders.push((*secs, order));
    }
    Ok(orders)
}

fn scale(value: &Node) -> Result<f64, yaml::Error> {
    match value.non_negative()? {
        scale if scale > 0.0 && scale <= MAX_SCALE => Ok(scale),
        scale => {
            Err(value.error(format!("{scale}: give a scale above 0, and at most {MAX_SCALE}")))
        }
    }
}

fn block_secs(value: &Node, orders: &[(f64, NewOrder)]) -> Result<f64, yaml::Error> {
    let secs = value.non_negative()?;
    let span = orders.last().map_or(0.0, |last| last.0) - orders.first().map_or(0.0, |one| one.0);
    if secs >= LEAST_BLOCK_SECS && span / secs <= MOST_BLOCKS {
        return Ok(secs);
    }
    Err(value.error(format!(
        "{secs}: give a block of at least {LEAST_BLOCK_SECS} s, and at most {MOST_BLOCKS} blocks"
    )))
}

/// Returns the name of an order, with a number if it was drawn before.
fn new_name(name: &OrderName, number: u64, names: &mut BTreeSet<OrderName>) -> OrderName {
    let copies = (2..).map(|copy| OrderName::stored(&format!("{name}~{copy}")));
    let mut candidates = std::iter::once(Ok(name.clone())).chain(copies);
    let found = candidates
        .find(|name| name.as_ref().is_ok_and(|name| !names.contains(name)) || name.is_err());
    let name = match found {
        Some(Ok(name)) => name,
        // It would be too long.
        _ => OrderName::generated("timetable", number, 0),
    };
    names.insert(name.clone());
    name
}

#[cfg(test)]
mod tests;
