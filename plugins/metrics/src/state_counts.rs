//! Counts of robots by state, and the sum of their speeds, from a frame's columns.

use regatta_plugin::frame::RobotState;

/// The number of states that a robot can be in, [`RobotState::Absent`] excluded.
pub const STATES: usize = RobotState::COUNT;

/// The names of the states, by their number in the column `state`.
pub const STATE_NAMES: [&str; STATES] =
    ["idle", "driving", "waiting", "held", "faulted", "turning", "stalled", "broken"];

/// The highest speed that counts, in metres per second. Higher speeds and NaN count as 0, so that a
/// sum stays a number.
const MAX_SPEED: f32 = 1e6;

/// The number of rows in a block. A count of them must fit into a byte, so that the compiler counts
/// 32 rows at once.
const BLOCK: usize = 240;
/// The number of partial sums, which the compiler keeps in SIMD registers.
const LANES: usize = 16;

/// Robots by state, and the sum of their speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateCounts {
    /// Number of robots in each state, in the order of [`STATE_NAMES`].
    pub by_state: [u64; STATES],
    /// Sum of |speed| over all robots, in metres per second.
    pub speed_sum: f64,
}

impl StateCounts {
    /// Counts the robots of a frame. Rows in an unknown state are absent: neither counted nor
    /// moving.
    pub fn of(states: &[u8], speeds: &[f32]) -> Self {
        let mut state_counts = Self::default();
        for (states, speeds) in states.chunks(BLOCK).zip(speeds.chunks(BLOCK)) {
            state_counts.add(states, speeds);
        }
        state_counts
    }

    /// Returns the number of robots in the fleet.
    pub fn robots(&self) -> u64 {
        self.by_state.iter().sum()
    }

    /// Returns the mean of |speed| over all robots, in metres per second; 0 without robots.
    pub fn mean_speed(&self) -> f64 {
        self.speed_sum / self.robots().max(1) as f64
    }

    /// Adds at most [`BLOCK`] rows.
    fn add(&mut self, states: &[u8], speeds: &[f32]) {
        let mut present = 0;
        for (number, count) in (0_u8..).zip(&mut self.by_state) {
            let robots = states.iter().map(|&state| u8::from(state == number)).sum::<u8>();
            *count += u64::from(robots);
            present += usize::from(robots);
        }
        // Absent rows are few, and mostly at the end: most blocks have none to leave out.
        self.speed_sum +=
            if present == states.len() { sum(speeds) } else { sum(&of_present(states, speeds)) };
    }
}

/// Returns the speeds of a block, with 0 for absent rows.
fn of_present(states: &[u8], speeds: &[f32]) -> [f32; BLOCK] {
    let mut block = [0.0; BLOCK];
    for ((present, &state), &speed) in block.iter_mut().zip(states).zip(speeds) {
        *present = if usize::from(state) < STATES { speed } else { 0.0 };
    }
    block
}

/// Returns the sum of |speed|.
fn sum(speeds: &[f32]) -> f64 {
    let (chunks, rest) = speeds.as_chunks::<LANES>();
    let mut lanes = [0.0_f32; LANES];
    for chunk in chunks {
        for (lane, &speed) in lanes.iter_mut().zip(chunk) {
            *lane += valid(speed);
        }
    }
    lanes.into_iter().chain(rest.iter().copied().map(valid)).map(f64::from).sum()
}

/// Returns |speed|, or 0 for an invalid one.
fn valid(speed: f32) -> f32 {
    if speed.abs() <= MAX_SPEED { speed.abs() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Counts one robot after another.
    fn oracle(states: &[u8], speeds: &[f32]) -> StateCounts {
        let mut state_counts = StateCounts::default();
        for (&state, &speed) in states.iter().zip(speeds) {
            if RobotState::from_number(state) != RobotState::Absent {
                state_counts.by_state[usize::from(state)] += 1;
                state_counts.speed_sum +=
                    if speed.abs() <= MAX_SPEED { f64::from(speed.abs()) } else { 0.0 };
            }
        }
        state_counts
    }

    proptest! {
        #[test]
        fn counts_equal_those_one_by_one(rows in prop::collection::vec((prop_oneof![0_u8..10, Just(255)], -3.0_f32..3.0), 0..1_000)) {
            let (states, speeds): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let (state_counts, oracle) = (StateCounts::of(&states, &speeds), oracle(&states, &speeds));
            prop_assert_eq!(state_counts.by_state, oracle.by_state);
            prop_assert!((state_counts.speed_sum - oracle.speed_sum).abs() <= 1e-5 * oracle.speed_sum.max(1.0));
        }

        #[test]
        fn the_sum_is_finite_for_any_speeds(speeds in prop::collection::vec(any::<f32>(), 0..600)) {
            let sum = StateCounts::of(&vec![1; speeds.len()], &speeds).speed_sum;
            prop_assert!(sum.is_finite() && sum >= 0.0);
        }
    }

    #[test]
    fn names_are_in_the_order_of_the_states() {
        for (number, name) in (0..).zip(STATE_NAMES) {
            assert_eq!(format!("{:?}", RobotState::from_number(number)).to_lowercase(), name);
        }
        assert_eq!(RobotState::from_number(STATES as u8), RobotState::Absent);
    }
}
