//! The transmission of messages: some are lost, come twice, or late.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::{Duration, Instant};

use rustc_hash::FxHashMap;

use crate::disturb::{Disturbances, Draws, Kind};

/// The draws of messages: no robot has so many parts.
const PART: u64 = u64::MAX;

/// A transmission of messages, in their order of each topic.
#[derive(Debug)]
pub(super) struct Interference<T> {
    draws: Draws,
    lost: f64,
    doubled: f64,
    delay_secs: f64,
    /// The messages under way; the next one to arrive is on top.
    under_way: BinaryHeap<Reverse<UnderWay<T>>>,
    /// The times when the last message of each topic arrives.
    last: FxHashMap<String, Instant>,
    /// The number of messages so far.
    count: u64,
}

/// A message under way.
#[derive(Debug)]
struct UnderWay<T> {
    arrival: Instant,
    /// Its place among all messages.
    number: u64,
    message: T,
}

impl<T: Clone> Interference<T> {
    /// Returns the transmission in a direction; `None` if messages aren't disturbed.
    pub(super) fn new(disturbances: &Disturbances, direction: u64) -> Option<Self> {
        let kinds = [Kind::LostMessages, Kind::DoubledMessages, Kind::Delay];
        let [lost, doubled, delay_secs] = kinds.map(|kind| disturbances.value(kind));
        (lost + doubled + delay_secs > 0.0).then(|| Self {
            draws: disturbances.draws(PART - direction),
            lost,
            doubled,
            delay_secs,
            under_way: BinaryHeap::new(),
            last: FxHashMap::default(),
            count: 0,
        })
    }

    /// Sends a message of a topic on its way.
    pub(super) fn send(&mut self, topic: &str, message: T, now: Instant) {
        if self.draws.comes_true(self.lost) {
            return;
        }
        let delay = if self.delay_secs > 0.0 { self.draws.time(self.delay_secs) } else { 0.0 };
        let arrival = now + Duration::from_secs_f64(delay);
        let arrival = self.last.get(topic).map_or(arrival, |last| arrival.max(*last));
        self.last.insert(topic.to_owned(), arrival);
        let copies = if self.draws.comes_true(self.doubled) { 2 } else { 1 };
        for _ in 0..copies {
            let (number, message) = (self.count, message.clone());
            self.count += 1;
            self.under_way.push(Reverse(UnderWay { arrival, number, message }));
        }
    }

    /// Takes the next message that has arrived.
    pub(super) fn take(&mut self, now: Instant) -> Option<T> {
        let Reverse(next) = self.under_way.peek()?;
        if next.arrival > now {
            return None;
        }
        self.under_way.pop().map(|Reverse(arrived)| arrived.message)
    }
}

impl<T> UnderWay<T> {
    fn order(&self) -> (Instant, u64) {
        (self.arrival, self.number)
    }
}

impl<T> PartialEq for UnderWay<T> {
    fn eq(&self, other: &Self) -> bool {
        self.order() == other.order()
    }
}

impl<T> Eq for UnderWay<T> {}

impl<T> PartialOrd for UnderWay<T> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for UnderWay<T> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.order().cmp(&other.order())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interference(texts: &[&str]) -> Option<Interference<u32>> {
        let list: Vec<_> = texts.iter().map(|text| text.parse().expect("one")).collect();
        Interference::new(&Disturbances::new(&list, 5), 0)
    }

    #[test]
    fn messages_of_a_topic_keep_their_order_and_come_late() {
        let mut line = interference(&["delay=2s"]).expect("a delay");
        let start = Instant::now();
        for number in 0..1_000 {
            let topic = if number % 2 == 0 { "even" } else { "odd" };
            line.send(topic, number, start + Duration::from_millis(u64::from(number)));
        }
        assert_eq!(line.take(start), None);
        let end = start + Duration::from_secs(60);
        let all: Vec<u32> = std::iter::from_fn(|| line.take(end)).collect();
        for rest in [0, 1] {
            let of_topic: Vec<u32> = all.iter().copied().filter(|it| it % 2 == rest).collect();
            assert!(of_topic.is_sorted() && of_topic.len() == 500, "{of_topic:?}");
        }
        assert!(!all.is_sorted(), "each topic has a delay of its own");
    }

    #[test]
    fn shares_are_lost_and_doubled() {
        assert!(interference(&[]).is_none());
        let mut line = interference(&["lost-messages=20%", "doubled-messages=10%"]).expect("some");
        let now = Instant::now();
        (0..10_000).for_each(|number| line.send("a", number, now));
        let all: Vec<u32> = std::iter::from_fn(|| line.take(now)).collect();
        let mut once = all.clone();
        once.dedup();
        assert!((7_800..8_200).contains(&once.len()), "{}", once.len());
        let doubled = all.len() - once.len();
        assert!((700..900).contains(&doubled), "{doubled}");
        assert!(all.is_sorted());
    }
}
