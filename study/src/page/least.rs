//! The answer to the question for the least number of robots, in sentences and tables.

use super::Block;
use super::cost::year_of;
use crate::answer::{
    Answer, Binding, CostFigure, LeastAnswer, PointAnswer, TargetAnswer, VariantAnswer,
};
use crate::plan::robots_in_words;
use crate::sweep::Trend;
use crate::sweep::least::Standing;
use crate::words::{self, Kind, NOT_KNOWN};

/// The parts of the robots' time from which on waiting, and being busy, are the reason for late
/// orders.
const MUCH_WAITING: f64 = 0.1;
const BUSY: f64 = 0.8;

/// Returns the answer for a variant, in sentences.
pub(super) fn of_least(variant: &VariantAnswer, least: &LeastAnswer) -> String {
    let Some(robots) = least.robots else { return of_none(variant, least) };
    let figures = variant.points.iter().find(|point| point.robots == robots);
    let figures = figures.map(|point| met(&point.targets)).unwrap_or_default();
    let meets = if robots == 1 { "meets" } else { "meet" };
    // One fewer was tried, unless the numbers were given, or begin here.
    let is_least = robots == 1 || variant.points.iter().any(|point| point.robots + 1 == robots);
    let of_tried = if is_least { "" } else { " of the numbers that were tried" };
    let mut text = format!(
        "{}: the least{of_tried} that {meets} the targets, with 95 % confidence: {figures}.",
        robots_in_words(robots)
    );
    if let Some(binding) = &least.binding {
        text += &format!(
            " With {}, {}.",
            binding.robots,
            missed(binding, variant.is_load_endless, false)
        );
    }
    if !least.worse.is_empty() {
        text += &format!(
            " More robots aren't better everywhere: {} were tried, too, and don't meet them.",
            listed(&least.worse)
        );
    }
    if !least.uncertain.is_empty() {
        text += &format!(
            " Whether {} meet them isn't known: give more --seeds.",
            listed(&least.uncertain)
        );
    }
    text
}

fn listed(numbers: &[u32]) -> String {
    numbers.iter().map(u32::to_string).collect::<Vec<String>>().join(", ")
}

fn of_none(variant: &VariantAnswer, least: &LeastAnswer) -> String {
    let none =
        format!("none of the numbers that were tried, up to {}", robots_in_words(least.most));
    let Some(binding) = &least.binding else {
        let reason = variant.failure().unwrap_or("no run has figures");
        return format!("{none}, meets the targets: {reason}.");
    };
    format!(
        "{none}, meets the targets. {} {} closest: {}.",
        robots_in_words(binding.robots),
        if binding.robots == 1 { "comes" } else { "come" },
        missed(binding, variant.is_load_endless, binding.robots < least.most)
    )
}

fn met(targets: &[TargetAnswer]) -> String {
    let texts = targets.iter().map(|TargetAnswer { target, words, margin, .. }| {
        let margin = margin.map_or_else(String::new, |m| format!(", {:.0} % to spare", 100.0 * m));
        format!("{target} ({words}{margin})")
    });
    texts.collect::<Vec<_>>().join("; ")
}

/// The targets that a number of robots misses, and the reason. `are_more_worse` tells whether
/// larger numbers were tried, which come less close.
fn missed(binding: &Binding, is_load_endless: bool, are_more_worse: bool) -> String {
    // An endless load has open orders, and robots with an order, in any case.
    let open = binding.open_orders.filter(|_| !is_load_endless).map_or(0.0, |open| open.mean);
    let mut texts = Vec::new();
    if binding.stalled_runs > 0 {
        texts.push(format!(
            "robots made no progress in {} of {} runs, which meet no target",
            binding.stalled_runs, binding.runs
        ));
    }
    texts.extend(binding.targets.iter().filter_map(against));
    texts.extend(backlog(binding, open).filter(|_| !is_load_endless));
    if tells_open_orders(binding, open) {
        let noun = if open.round() == 1.0 { "order is" } else { "orders are" };
        let stuck = binding.stuck_orders.in_words();
        let stuck = stuck.map_or_else(String::new, |stuck| format!(", of which {stuck}"));
        texts.push(format!("{open:.0} {noun} open at the end{stuck}"));
    }
    texts.extend(reason(binding, is_load_endless, are_more_worse));
    texts.join(", and ")
}

/// Tells that a backlog grows, or may grow, if that isn't due to orders that can't be carried.
fn backlog(binding: &Binding, open: f64) -> Option<String> {
    let are_stuck = binding.stuck_orders.are_most_of(open);
    match &binding.backlog {
        Trend::Growing(growth) if !are_stuck => Some(format!(
            "orders come faster than they are carried ({} more are open after half of a run's time)",
            words::in_words(growth, Kind::Bounded, "", |orders| format!("{orders:.1}"))
        )),
        Trend::Saturated => Some("orders come as fast as they are carried, or faster".to_owned()),
        Trend::Unclear if !are_stuck => Some(
            "whether the robots carry all orders that come isn't known: give a longer --duration"
                .to_owned(),
        ),
        _ => None,
    }
}

/// Whether open orders are a reason to miss the targets: no figure is one, as on a day that wasn't
/// over, or there are more of them than the robots carry at the end of a run.
fn tells_open_orders(binding: &Binding, open: f64) -> bool {
    let is_figure = binding.targets.iter().any(|answer| against(answer).is_some());
    open >= 0.5 && (!is_figure || open > f64::from(binding.robots))
}

/// Tells a figure that misses its target, or may miss it.
fn against(answer: &TargetAnswer) -> Option<String> {
    let TargetAnswer { target, name, words, standing, of_figure, margin, .. } = answer;
    match standing {
        _ if *of_figure == Standing::Met => None,
        Standing::Met => None,
        Standing::Open if words == NOT_KNOWN => {
            Some(format!("{name} isn't known, and '{target}' may be missed"))
        }
        Standing::Open => Some(format!("{name} is {words}, too near to '{target}' to be sure")),
        // The figure isn't the reason if it is within the limit.
        Standing::Missed if margin.is_some_and(|margin| margin > 0.0) => None,
        Standing::Missed => Some(format!("{name} is {words}, against '{target}'")),
    }
}

/// Tells the bottleneck of a number of robots that misses targets.
fn reason(binding: &Binding, is_load_endless: bool, are_more_worse: bool) -> Option<String> {
    let [waiting, busy] = [binding.waiting?, binding.utilisation?].map(|part| part.mean);
    let open = binding.open_orders.map_or(0.0, |open| open.mean);
    match &binding.place {
        // More robots wouldn't carry them, either.
        _ if binding.stuck_orders.are_most_of(open) && open >= 0.5 && !is_load_endless => None,
        Some(place) if waiting >= MUCH_WAITING => Some(format!(
            "robots wait {:.0} % of their time, most of all for {place}",
            100.0 * waiting
        )),
        _ if waiting >= MUCH_WAITING => {
            Some(format!("robots wait {:.0} % of their time", 100.0 * waiting))
        }
        _ if busy >= BUSY && !is_load_endless && are_more_worse => Some(format!(
            "robots have an order {:.0} % of the time, but larger numbers of robots miss the \
             targets by more",
            100.0 * busy
        )),
        _ if busy >= BUSY && !is_load_endless => Some(format!(
            "robots have an order {:.0} % of the time, so that there are too few of them",
            100.0 * busy
        )),
        _ => None,
    }
}

/// Returns the table of the least fleets of several variants.
pub(super) fn fleets(answer: &Answer) -> Option<Block> {
    if answer.variants.len() < 2 || answer.method.targets.is_empty() {
        return None;
    }
    let mut head = vec!["variant".to_owned(), "robots".to_owned()];
    head.extend(answer.method.targets.iter().cloned());
    if let Some(prices) = &answer.prices {
        head.push(format!("{}, {}", CostFigure::Year.name(), prices.currency.as_str()));
    }
    head.push("binds".to_owned());
    let mut rows = vec![head];
    for variant in &answer.variants {
        rows.push(row(answer, variant));
    }
    Some(Block::Table(rows))
}

fn row(answer: &Answer, variant: &VariantAnswer) -> Vec<String> {
    let least = variant.least.as_ref();
    let robots = match least.and_then(|least| least.robots) {
        Some(robots) => format!("**{robots}**"),
        None => "none".to_owned(),
    };
    let chosen = least.and_then(LeastAnswer::chosen);
    let point = variant.points.iter().find(|point| Some(point.robots) == chosen);
    let mut row = vec![variant.name.clone(), robots];
    match point {
        Some(point) => row.extend(figures(point)),
        None => row.resize(2 + answer.method.targets.len(), super::content::NONE.to_owned()),
    }
    row.extend(variant.cost.as_ref().map(|cost| year_of(cost, chosen)));
    let binding = least.and_then(|least| least.binding.as_ref());
    row.push(binding.map_or_else(String::new, |binding| {
        format!(
            "with {}: {}",
            binding.robots,
            missed(
                binding,
                variant.is_load_endless,
                least.is_some_and(|least| binding.robots < least.most)
            )
        )
    }));
    row
}

/// The figures of a point against the targets, for a row of a table.
pub(super) fn figures(point: &PointAnswer) -> impl Iterator<Item = String> {
    point.targets.iter().map(|target| {
        let standing = match target.standing {
            Standing::Met => "met",
            Standing::Open => "open",
            Standing::Missed => "missed",
        };
        format!("{}, {standing}", target.words)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::StuckOrders;
    use crate::statistics::Interval;

    fn binding(waiting: f64, place: Option<&str>) -> Binding {
        let interval = |mean| Some(Interval { mean, half_width: Some(0.0), values: 3 });
        let target = TargetAnswer {
            target: "p99 service < 6 min".to_owned(),
            name: "p99 service".to_owned(),
            value: interval(400.0),
            words: "400 s".to_owned(),
            margin: Some(-0.1),
            standing: Standing::Missed,
            of_figure: Standing::Missed,
        };
        Binding {
            robots: 11,
            targets: vec![target],
            runs: 3,
            stalled_runs: 0,
            open_orders: interval(0.0),
            stuck_orders: StuckOrders::default(),
            backlog: Trend::Steady,
            utilisation: interval(0.97),
            waiting: interval(waiting),
            place: place.map(str::to_owned),
        }
    }

    #[test]
    fn the_reason_is_a_place_or_the_number_of_robots() {
        let text = missed(&binding(0.4, Some("S4")), false, false);
        assert_eq!(
            text,
            "p99 service is 400 s, against 'p99 service < 6 min', and robots wait 40 % of their \
             time, most of all for S4"
        );
        let busy = Binding {
            open_orders: Some(Interval { mean: 14.0, half_width: None, values: 1 }),
            ..binding(0.02, None)
        };
        let text = missed(&busy, false, true);
        assert!(text.ends_with("but larger numbers of robots miss the targets by more"), "{text}");
        let text = missed(&busy, false, false);
        assert!(text.contains("14 orders are open"), "{text}");
        assert!(text.ends_with("so that there are too few of them"), "{text}");
        // Of an endless load, more robots have an order all the time, too.
        assert_eq!(
            missed(&busy, true, false),
            "p99 service is 400 s, against 'p99 service < 6 min'"
        );
    }

    #[test]
    fn a_backlog_that_grows_is_the_reason_though_the_figure_is_within_the_limit() {
        let mut binding = binding(0.02, None);
        binding.targets[0].of_figure = Standing::Met;
        binding.backlog = Trend::Growing(Interval { mean: 5.5, half_width: Some(0.4), values: 3 });
        binding.open_orders = Some(Interval { mean: 12.0, half_width: Some(1.0), values: 3 });
        assert_eq!(
            missed(&binding, false, false),
            "orders come faster than they are carried (5.5 ± 0.4 more are open after half of a \
             run's time), and 12 orders are open at the end, and robots have an order 97 % of the \
             time, so that there are too few of them"
        );
        binding.stuck_orders = StuckOrders { unroutable: 0.0, unplaced: 11.0 };
        assert_eq!(
            missed(&binding, false, false),
            "12 orders are open at the end, of which 11 wait for a place or a load of a storage"
        );
    }

    /// Of a generator's load, some orders have just come at the end of each run.
    #[test]
    fn open_orders_that_robots_carry_are_no_reason_unless_nothing_else_is() {
        let open = Some(Interval { mean: 1.0, half_width: Some(0.0), values: 3 });
        let mut binding = Binding { open_orders: open, ..binding(0.02, None) };
        let text = missed(&binding, false, false);
        assert!(!text.contains("open at the end"), "{text}");
        binding.targets[0].margin = Some(0.4);
        let text = missed(&binding, false, false);
        assert!(text.starts_with("1 order is open at the end"), "{text}");
    }

    #[test]
    fn a_figure_within_its_limit_is_no_reason() {
        let mut stalled = Binding { stalled_runs: 2, ..binding(0.02, None) };
        stalled.targets[0].margin = Some(0.4);
        let text = missed(&stalled, false, false);
        assert!(text.starts_with("robots made no progress in 2 of 3 runs"), "{text}");
        assert!(!text.contains("p99 service"), "{text}");
    }

    #[test]
    fn a_share_that_may_be_any_is_not_known() {
        let mut open = binding(0.02, None);
        open.targets[0].target = "late < 2 %".to_owned();
        open.targets[0].name = "late".to_owned();
        open.targets[0].words = NOT_KNOWN.to_owned();
        open.targets[0].standing = Standing::Open;
        let text = missed(&open, false, false);
        assert!(text.starts_with("late isn't known, and 'late < 2 %' may be missed"), "{text}");
    }
}
