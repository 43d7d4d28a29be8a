//! The fuzz target of transport orders: no file, load or body of a request makes its reader panic,
//! hang or exhaust memory, and accepted orders are within their limits.

use std::sync::Arc;

use regatta_orders::draft::MAX_STOPS;
use regatta_orders::file::{parse_csv, parse_yaml};
use regatta_orders::{Load, OrderDraft, OrderName, OrderPool, Place, Places};

/// The times, in simulated seconds, until which a load makes orders. A load may make many.
const LOOKS: [f64; 4] = [0.0, 0.01, 0.1, 0.2];
const ROBOTS: usize = 3;

/// Reads a text as everything that orders come from.
pub fn read(text: &str) {
    for orders in [parse_yaml(text), parse_csv(text)].into_iter().flatten() {
        for order in &orders {
            check(&order.draft);
        }
        // An order of the file may be wrong: the pool says so.
        let _added = pool().add_orders(&orders);
    }
    if let Ok(draft) = serde_json::from_str::<OrderDraft>(text) {
        check(&draft);
    }
    if let Ok(drafts) = serde_json::from_str::<Vec<OrderDraft>>(text) {
        drafts.iter().for_each(check);
    }
    if let Ok(load) = Load::parse(text, &places()) {
        generate(&load);
    }
}

fn places() -> Places {
    let place = |id: u32| Place { id, name: format!("P{id}"), ..Place::default() };
    Places::new((1..=4).map(place).collect())
}

fn pool() -> OrderPool {
    OrderPool::new(Arc::new(places()))
}

fn check(draft: &OrderDraft) {
    let generated = || OrderName::parse("generated").expect("a name");
    let Ok(order) = draft.check(&places(), generated) else { return };
    assert!((1..=MAX_STOPS).contains(&order.stops.len()));
    assert!(order.earliest_secs.is_finite() && order.earliest_secs >= 0.0);
    assert!(order.stops.iter().all(|stop| stop.dwell_secs.is_finite() && stop.dwell_secs >= 0.0));
}

/// Makes the first orders of a load.
fn generate(load: &Load) {
    let mut pool = pool();
    pool.add_load(load);
    LOOKS.iter().for_each(|secs| pool.generate_until(*secs, ROBOTS));
}
