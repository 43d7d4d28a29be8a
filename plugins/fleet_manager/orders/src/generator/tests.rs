use super::*;
use crate::load::{Flow, Load, Stops};
use crate::places::{Place, Places};
use regatta_plugin::world::Role;

fn places() -> Places {
    let roles = [Role::Pick, Role::Pick, Role::Drop, Role::None];
    let zone = |id| if id < 2 { "south" } else { "north" }.to_owned();
    let place =
        |(id, role)| Place { id, role, zone: zone(id), name: format!("N{id}"), ..Place::default() };
    Places::new((0..).zip(roles).map(place).collect())
}

fn generators(text: &str) -> Vec<Generator> {
    let load = Load::parse(text, &places()).expect("a load");
    let make = |(number, settings)| Generator::new(settings, load.seed, number, 1);
    (1..).zip(load.generators.clone()).map(make).collect()
}

/// Returns all orders up to a time, asked for in steps.
fn orders(mut generator: Generator, until_secs: f64, step_secs: f64) -> Vec<(f64, NewOrder)> {
    let mut orders = Vec::new();
    let mut now = 0.0;
    while now < until_secs {
        now = f64::min(now + step_secs, until_secs);
        orders.extend(std::iter::from_fn(|| generator.next(now, 0, 0, &|_| true)));
    }
    orders
}

#[test]
fn orders_do_not_depend_on_how_often_a_generator_is_asked() {
    let text = "load: {seed: 3, per_hour: 500, dwell: {min: 2, max: 4}, deadline: 60}";
    let [generator] = &generators(text)[..] else { panic!("one") };
    let often = orders(generator.clone(), 7200.0, 0.1);
    assert_eq!(often, orders(generator.clone(), 7200.0, 7200.0));
    assert_ne!(often, orders(generators(&text.replace('3', "4"))[0].clone(), 7200.0, 0.1));
    for (secs, order) in &often {
        let [pick, drop] = &order.stops[..] else { panic!("two stops") };
        assert!(
            pick.node < 2 && drop.node == 2 && (2.0..=4.0).contains(&pick.dwell_secs),
            "{order:?}"
        );
        assert_eq!(
            (pick.action, drop.action, order.deadline_secs),
            (Action::Pick, Action::Drop, Some(secs + 60.0))
        );
    }
}

#[test]
fn the_first_orders_are_these_on_every_machine() {
    let first = orders(generators("load: {seed: 3, per_hour: 500}")[0].clone(), 3600.0, 60.0);
    let bits = first.iter().fold(0_u64, |hash, (secs, order)| {
        hash.wrapping_mul(0x100_0000_01b3) ^ secs.to_bits() ^ u64::from(order.stops[0].node)
    });
    assert_eq!((first.len(), bits), (GOLDEN_COUNT, GOLDEN_BITS));
}

const GOLDEN_COUNT: usize = 517;
const GOLDEN_BITS: u64 = 8_558_232_785_599_392_625;

#[test]
fn the_rate_and_the_spread_are_those_of_poisson() {
    let hours = 200;
    let made =
        orders(generators("load: {per_hour: 100}")[0].clone(), f64::from(hours) * 3600.0, 3600.0);
    let mut counts = vec![0.0; hours as usize];
    made.iter().for_each(|(secs, _)| counts[(secs / 3600.0) as usize] += 1.0);
    let mean = counts.iter().sum::<f64>() / f64::from(hours);
    let variance =
        counts.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / f64::from(hours);
    // Four standard deviations of the mean and of the variance.
    assert!((mean - 100.0).abs() < 4.0 * (100.0 / f64::from(hours)).sqrt(), "{mean}");
    assert!((variance - 100.0).abs() < 40.0, "{variance}");
}

#[test]
fn a_profile_begins_anew_after_its_end() {
    let text = "load: {shifts: [{until: 1000, per_hour: 0}, {until: 2000, per_hour: 7200}, {until: 3000, per_hour: 720}]}";
    let made = orders(generators(text)[0].clone(), 30_000.0, 50.0);
    let mut counts = [0; 3];
    made.iter().for_each(|(secs, _)| counts[(secs / 1000.0) as usize % 3] += 1);
    assert_eq!(counts[0], 0);
    assert!(
        (19_400..20_600).contains(&counts[1]) && (1_800..2_200).contains(&counts[2]),
        "{counts:?}"
    );
    assert!(orders(generators("load: {per_hour: 0}")[0].clone(), 1e6, 1e6).is_empty());
}

#[test]
fn endless_generators_fill_up() {
    let mut generator = generators("load: {endless: robots, among: pick}")[0].clone();
    let made = (0..5).map_while(|open| generator.next(1.0, 3, open, &|_| true)).count();
    assert_eq!(made, 3);
    let order = generator.next(2.0, 3, 1, &|_| true).expect("an order").1;
    assert_eq!((order.name.as_str(), order.stops.len()), ("load:1-4", 1));
    assert_eq!(generator.number_of(order.name.as_str()), Some(4));
    assert_eq!(generators("load: {name: 11, per_hour: 1}")[0].number_of(order.name.as_str()), None);
}

#[test]
fn an_endless_load_may_have_two_stops() {
    let mut generator = generators("load: {endless: 2, from: pick}")[0].clone();
    let order = generator.next(0.0, 9, 1, &|_| true).expect("an order").1;
    let actions: Vec<_> = order.stops.iter().map(|stop| stop.action).collect();
    assert_eq!(actions, [Action::Pick, Action::Drop]);
    assert!(generator.next(0.0, 9, 2, &|_| true).is_none(), "two at a time");
}

#[test]
fn a_generator_continues_after_orders_that_it_has_made() {
    let generator = &generators("load: {per_hour: 100}")[0];
    let all = orders(generator.clone(), 36_000.0, 100.0);
    let mut later = generator.clone();
    later.skip(500);
    assert_eq!(all[500..], orders(later, 36_000.0, 100.0));
}

#[test]
fn the_ends_of_transports_may_be_nodes() {
    for (ends, expected) in [
        ("from: N1, to: N3", ([1].as_slice(), [3].as_slice())),
        ("from: 1, to: [N2, 3]", (&[1], &[2, 3])),
        ("from: {zone: south}, to: '2'", (&[0, 1], &[2])),
    ] {
        let load = Load::parse(&format!("load: {{per_hour: 1, {ends}}}"), &places());
        let Stops::Transport(transport) = &load.expect(ends).generators[0].stops else {
            panic!("two stops")
        };
        let [Flow { from, to, .. }] = transport.flows.as_slice() else { panic!("one flow") };
        assert_eq!((from.as_slice(), to.as_slice()), expected, "{ends}");
    }
    let place = |id| Place { id, name: "twin".to_owned(), ..Place::default() };
    let twins = Places::new(vec![place(7), place(8)]);
    for text in ["load: {endless: 1, among: twin}", "load: {groups: {a: [twin]}, per_hour: 1}"] {
        let error = Load::parse(text, &twins).expect_err(text).to_string();
        assert!(error.contains("several nodes have the name `twin`; give the id"), "{error}");
    }
}

#[test]
fn what_is_wrong_in_a_load_is_refused() {
    for (text, message) in [
        ("load: {}", "one of per_hour, shifts, gaps and endless"),
        ("load: {per_hour: 1, shifts: []}", "one of per_hour"),
        ("load:\n  per_hour: -1", "line 2: -1 is below 0"),
        ("load: {per_hour: 1e99}", "orders an hour are too many"),
        ("load: {shifts: []}", "no shifts"),
        (
            "load: {shifts: [{until: 5, per_hour: 1}, {until: 5, per_hour: 1}]}",
            "must be later than",
        ),
        ("load: {per_hour: 1, from: nowhere}", "`nowhere` is neither a group nor a role"),
        ("load: {per_hour: 1, from: park}", "no node has the role `park`"),
        ("load: {groups: {a: [N9]}, per_hour: 1}", "`N9` is neither the name nor the id"),
        ("load: {groups: {a: {zone: east}}, per_hour: 1}", "no node is in this group"),
        ("load: {endless: 3, from: pick, among: pick}", "`among` is for"),
        ("load: {per_hour: 1, endless: 3}", "one of per_hour"),
        ("load: {groups: {a: [N1]}, per_hour: 1, from: a, to: a}", "same single node"),
        ("load: {per_hour: 1, dwell: {min: 3, max: 2}}", "`min` is above `max`"),
        ("load: {per_hour: 1, dwell: {at: {N9: 4}}}", "`N9` is neither the name nor the id"),
        ("load: {per_hour: 1, dwell: {pick: 4, min: 3}}", "unknown field `min`"),
        ("load: {gaps: 0}", "gaps of 0 s"),
        ("load: {gaps: 9, per_hour: 9}", "one of per_hour"),
        ("load: {per_hour: 9, batch: 0}", "a batch has at least one order"),
        ("load: {per_hour: 9, batch: {min: 4, max: 2}}", "`min` is above `max`"),
        ("load: {endless: 9, batch: 2}", "an endless load has no batches"),
        ("load: {per_hour: 9, from: N0, flows: [{to: N2}]}", "either `flows`, or `from` and `to`"),
        ("load: {per_hour: 9, flows: [{share: 0}]}", "no flow has a share above 0"),
        ("load: {per_hour: 9, flows: []}", "no flow has a share above 0"),
        ("load: {per_hour: 9, via: N3}", "list"),
        ("load: {generators: [{name: a, per_hour: 1}, {name: a, per_hour: 1}]}", "two generators"),
        ("load: {generators: [{per_hour: 1}], per_hour: 1}", "unknown field `per_hour`"),
    ] {
        let error = Load::parse(text, &places()).expect_err(text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let load = Load::parse(
        "seed: 1\ngroups: {a: {zone: north, role: drop}}\nper_hour: 1\nto: a",
        &places(),
    );
    assert!(load.is_ok(), "{load:?}");
}

#[test]
fn gaps_are_the_times_between_orders() {
    let made = orders(generators("load: {gaps: 30}")[0].clone(), 100.0, 7.0);
    let secs: Vec<f64> = made.iter().map(|(secs, _)| *secs).collect();
    assert_eq!(secs, [30.0, 60.0, 90.0]);
    let text = "load: {gaps: {samples: [10, 20]}}";
    let made = orders(generators(text)[0].clone(), 150_000.0, 150_000.0);
    let gaps: Vec<f64> = made.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    assert!(gaps.iter().all(|gap| [10.0, 20.0].contains(gap)));
    assert!((9_700..10_300).contains(&made.len()), "{}", made.len());
}

#[test]
fn orders_of_a_batch_come_together_at_the_same_rate() {
    for text in
        ["load: {per_hour: 100, batch: 4}", "load: {per_hour: 100, batch: {min: 2, max: 6}}"]
    {
        let generator = &generators(text)[0];
        let all = orders(generator.clone(), 3_600_000.0, 3600.0);
        assert!((97_000..103_000).contains(&all.len()), "{text}: {}", all.len());
        let sizes: Vec<usize> = all.chunk_by(|a, b| a.0 == b.0).map(<[_]>::len).collect();
        let bounds = if text.contains("min") { 2..=6 } else { 4..=4 };
        assert!(sizes[..sizes.len() - 1].iter().all(|size| bounds.contains(size)), "{text}");
        assert!(bounds.clone().all(|size| sizes.contains(&size)), "{text}: each size comes");
        let mut later = generator.clone();
        later.skip(501);
        assert_eq!(all[501..900], orders(later, 3_600_000.0, 3600.0)[..399], "{text}");
    }
    let made = orders(generators("load: {gaps: 60, batch: 3}")[0].clone(), 120.0, 1.0);
    let secs: Vec<f64> = made.iter().map(|(secs, _)| *secs).collect();
    assert_eq!(secs, [60.0, 60.0, 60.0, 120.0, 120.0, 120.0]);
}

#[test]
fn flows_have_their_shares() {
    let text = "load: {per_hour: 1000, flows: [{from: N0, to: N2, share: 3}, {from: N1, to: N3}, \
                {from: N2, to: N0, share: 0}]}";
    let made = orders(generators(text)[0].clone(), 36_000_000.0, 36_000_000.0);
    let mut counts = std::collections::BTreeMap::new();
    for (_, order) in &made {
        *counts.entry((order.stops[0].node, order.stops[1].node)).or_insert(0.0) += 1.0;
    }
    assert_eq!(counts.keys().copied().collect::<Vec<_>>(), [(0, 2), (1, 3)]);
    // A quarter, within five standard deviations of 10,000 orders.
    let share = counts[&(1, 3)] / made.len() as f64;
    assert!((share - 0.25).abs() < 0.022, "{share}");
}

#[test]
fn stops_may_be_between_pick_and_drop() {
    let text = "load: {per_hour: 100, from: N0, to: N2, via: [N3, {zone: south}], \
                dwell: {pick: 5, drop: 7, other: 1, at: {N3: 20}}}";
    let generator = &generators(text)[0];
    let (all, last) = generator.stops();
    assert_eq!((all.as_slice(), last.as_slice()), ([0, 3, 0, 1, 2].as_slice(), [2].as_slice()));
    for (_, order) in orders(generator.clone(), 36_000.0, 36_000.0) {
        let stops: Vec<_> =
            order.stops.iter().map(|stop| (stop.node, stop.action, stop.dwell_secs)).collect();
        let [pick, wrap, look, drop] = stops[..] else { panic!("{stops:?}") };
        assert_eq!((pick, wrap), ((0, Action::Pick, 5.0), (3, Action::None, 20.0)));
        assert!(look.0 < 2 && look.1 == Action::None && look.2 == 1.0, "{look:?}");
        assert_eq!(drop, (2, Action::Drop, 7.0));
    }
}
