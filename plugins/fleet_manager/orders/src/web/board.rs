//! The board: all orders and vehicles as the web API shows them. It follows the pool's updates.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound::{Excluded, Unbounded};
use std::sync::Arc;

use axum::response::sse::Event;
use parking_lot::Mutex;
use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::broadcast;
use tokio::sync::mpsc::UnboundedReceiver;

use crate::figures::Figures;
use crate::order::{NewOrder, Order, OrderId, OrderName};
use crate::places::Places;
use crate::threads::{ABSENT, Update, Vehicle};
use crate::view::{Page, TransportOrder, VehicleView};

/// The largest number of open orders, which bounds the memory.
const MAX_OPEN: usize = 1_000_000;
/// The largest number of events that a reader may be behind.
const MAX_BEHIND: usize = 4_096;

pub(crate) struct Board {
    pub(super) places: Arc<Places>,
    content: Mutex<Content>,
    events: broadcast::Sender<Event>,
}

#[derive(Default)]
struct Content {
    orders: BTreeMap<OrderName, Arc<Order>>,
    closed: VecDeque<OrderName>,
    /// The largest number of orders that are over and still shown.
    max_closed: usize,
    vehicles: BTreeMap<u32, Vehicle>,
    figures: Figures,
    now_secs: f64,
    /// The number in the next name that is generated.
    number: u64,
}

/// The error of reserving names for new orders.
pub(super) enum Refusal {
    Duplicate(OrderName),
    Full,
}

impl Board {
    /// Makes a board of the open orders, at a simulated time in seconds. It shows the last
    /// `max_closed` orders that are over.
    pub(crate) fn new(
        places: Arc<Places>,
        open: Vec<Arc<Order>>,
        max_closed: usize,
        now_secs: f64,
    ) -> Self {
        let orders = open.into_iter().map(|order| (order.content.name.clone(), order)).collect();
        let content = Mutex::new(Content { orders, max_closed, now_secs, ..Content::default() });
        Self { places, content, events: broadcast::Sender::new(MAX_BEHIND) }
    }

    /// Takes updates until the pool ends.
    pub(super) async fn follow(self: Arc<Self>, mut updates: UnboundedReceiver<Update>) {
        while let Some(update) = updates.recv().await {
            self.apply(update);
        }
    }

    fn apply(&self, update: Update) {
        let changed = self.content.lock().show_vehicles(update.vehicles);
        if self.events.receiver_count() > 0 {
            for order in &update.orders {
                self.send("transportOrder", &TransportOrder::new(order, &self.places));
            }
            for vehicle in &changed {
                self.send("vehicle", &VehicleView::new(vehicle, &self.places));
            }
        }
        let mut content = self.content.lock();
        content.now_secs = update.now_secs;
        content.figures = update.figures.unwrap_or(content.figures);
        for order in update.orders {
            content.show(order);
        }
    }

    fn send(&self, name: &str, data: &impl Serialize) {
        if let Ok(event) = Event::default().event(name).json_data(data) {
            // It fails only if the last reader has gone.
            let _ = self.events.send(event);
        }
    }

    pub(super) fn subscribe(&self) -> broadcast::Receiver<Event> {
        self.events.subscribe()
    }

    /// Generates names with larger numbers.
    pub(super) fn number_from(&self, number: u64) {
        self.content.lock().number = number;
    }

    /// Whether an order is shown.
    pub(super) fn has(&self, name: &OrderName) -> bool {
        self.content.lock().orders.contains_key(name)
    }

    /// Returns a name that no order has.
    pub(super) fn generated_name(&self) -> OrderName {
        let mut content = self.content.lock();
        loop {
            content.number += 1;
            // Short and plain: it is a name.
            if let Ok(name) = OrderName::parse(&format!("order-{}", content.number))
                && !content.orders.contains_key(&name)
            {
                return name;
            }
        }
    }

    /// Shows new orders, so that their names are taken: all, or none.
    pub(super) fn reserve(&self, orders: &[NewOrder]) -> Result<Vec<Arc<Order>>, Refusal> {
        let mut content = self.content.lock();
        let mut names: Vec<_> = orders.iter().map(|order| &order.name).collect();
        names.sort();
        let twice = names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        if let Some(name) =
            twice.or_else(|| names.into_iter().find(|name| content.orders.contains_key(name)))
        {
            return Err(Refusal::Duplicate(name.clone()));
        }
        if content.orders.len() - content.closed.len() + orders.len() > MAX_OPEN {
            return Err(Refusal::Full);
        }
        let mut shown = Vec::with_capacity(orders.len());
        for order in orders {
            // The pool will number it.
            let order = Arc::new(Order::new(OrderId(0), order.clone(), content.now_secs));
            content.orders.insert(order.content.name.clone(), order.clone());
            shown.push(order);
        }
        Ok(shown)
    }

    /// Removes orders that [`reserve`](Self::reserve) has shown.
    pub(super) fn release(&self, orders: &[NewOrder]) {
        let mut content = self.content.lock();
        for order in orders {
            content.orders.remove(&order.name);
        }
    }

    pub(super) fn order(&self, name: &OrderName) -> Option<TransportOrder> {
        let order = self.content.lock().orders.get(name).cloned();
        order.map(|order| TransportOrder::new(&order, &self.places))
    }

    /// Returns the names of the orders of a page.
    pub(super) fn names(&self, page: &Page) -> Vec<OrderName> {
        let content = self.content.lock();
        let start = page.after.as_ref().map_or(Unbounded, Excluded);
        let orders = content.orders.range((start, Unbounded));
        let requested = orders.filter(|(_, order)| match page.state.as_deref() {
            None => true,
            Some("open") => !order.state.is_final(),
            Some(state) => order.state.name() == state,
        });
        requested.take(page.limit).map(|(name, _)| name.clone()).collect()
    }

    pub(super) fn vehicle(&self, robot: u32) -> Option<VehicleView> {
        let vehicle = self.content.lock().vehicles.get(&robot).cloned()?;
        Some(VehicleView::new(&vehicle, &self.places))
    }

    /// Returns the vehicle with the lowest id from one on, and its id.
    pub(super) fn next_vehicle(&self, from: u32) -> Option<(u32, VehicleView)> {
        let content = self.content.lock();
        let (robot, vehicle) = content.vehicles.range(from..).next()?;
        Some((*robot, VehicleView::new(vehicle, &self.places)))
    }

    pub(super) fn status(&self) -> Value {
        let content = self.content.lock();
        let open = content.orders.len() - content.closed.len();
        json!({"time": content.now_secs, "openOrders": open, "vehicles": content.vehicles.len(),
            "figures": content.figures.json()})
    }
}

impl Content {
    /// Shows vehicles. Returns those of which more has changed than the position.
    fn show_vehicles(&mut self, vehicles: Vec<Vehicle>) -> Vec<Vehicle> {
        let mut changed = Vec::new();
        for vehicle in vehicles {
            let old = match vehicle.state {
                ABSENT => self.vehicles.remove(&vehicle.robot),
                _ => self.vehicles.insert(vehicle.robot, vehicle.clone()),
            };
            let old = old.map(|old| Vehicle { position: vehicle.position, ..old });
            if old.as_ref() != Some(&vehicle) {
                changed.push(vehicle);
            }
        }
        changed
    }

    fn show(&mut self, order: Arc<Order>) {
        let name = order.content.name.clone();
        if order.state.is_final() {
            self.closed.push_back(name.clone());
        }
        self.orders.insert(name, order);
        if self.closed.len() > self.max_closed
            && let Some(oldest) = self.closed.pop_front()
        {
            self.orders.remove(&oldest);
        }
    }
}
