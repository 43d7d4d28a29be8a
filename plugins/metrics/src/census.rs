//! What a frame's columns come to: robots by state, and how fast they are together.

/// Number of states that a robot can be in, [`RobotState::Absent`](regatta_plugin::frame::RobotState) not counted.
pub const STATES: usize = 5;

/// Names of the states, by their number in the column `state`.
pub const STATE_NAMES: [&str; STATES] = ["idle", "driving", "waiting", "held", "faulted"];

/// Metres per second. What claims to be faster, or is no number, counts as standing: a sum must stay a number.
const FASTEST: f32 = 1e6;

/// Rows at a time: a count of them must fit into a byte, which is what lets the compiler count 32 at once.
const BLOCK: usize = 240;
const LANES: usize = 16;

/// Robots by state, and the sum of their speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Census {
    /// Robots in each state, in the order of [`STATE_NAMES`].
    pub by_state: [u64; STATES],
    /// Sum of |speed| over all robots, in metres per second.
    pub speed_sum: f64,
}

impl Census {
    /// Counts the robots of a frame. Rows in no known state are absent: neither counted nor moving.
    pub fn of(states: &[u8], speeds: &[f32]) -> Self {
        let mut census = Self::default();
        for (states, speeds) in states.chunks(BLOCK).zip(speeds.chunks(BLOCK)) {
            census.add(states, speeds);
        }
        census
    }

    /// Robots in the fleet.
    pub fn robots(&self) -> u64 {
        self.by_state.iter().sum()
    }

    /// Mean of |speed| over all robots, in metres per second; 0 without robots.
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
        // Absent rows are few, and mostly at the end: where there are none, nothing needs to be left out.
        self.speed_sum += if present == states.len() { sum(speeds) } else { sum(&of_present(states, speeds)) };
    }
}

/// The speeds of a block, 0 for absent rows.
fn of_present(states: &[u8], speeds: &[f32]) -> [f32; BLOCK] {
    let mut present = [0.0; BLOCK];
    for ((place, &state), &speed) in present.iter_mut().zip(states).zip(speeds) {
        *place = if usize::from(state) < STATES { speed } else { 0.0 };
    }
    present
}

/// The sum of |speed|.
fn sum(speeds: &[f32]) -> f64 {
    let counted = |speed: f32| if speed.abs() <= FASTEST { speed.abs() } else { 0.0 };
    let (chunks, rest) = speeds.as_chunks::<LANES>();
    let mut lanes = [0.0_f32; LANES];
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, &speed)| *lane += counted(speed));
    }
    lanes.into_iter().chain(rest.iter().copied().map(counted)).map(f64::from).sum()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use regatta_plugin::frame::RobotState;

    use super::*;

    /// One robot after another.
    fn oracle(states: &[u8], speeds: &[f32]) -> Census {
        let mut census = Census::default();
        for (&state, &speed) in states.iter().zip(speeds) {
            if RobotState::from_number(state) != RobotState::Absent {
                census.by_state[usize::from(state)] += 1;
                census.speed_sum += if speed.abs() <= FASTEST { f64::from(speed.abs()) } else { 0.0 };
            }
        }
        census
    }

    proptest! {
        #[test]
        fn equals_counting_one_by_one(rows in prop::collection::vec((prop_oneof![0_u8..7, Just(255)], -3.0_f32..3.0), 0..1_000)) {
            let (states, speeds): (Vec<_>, Vec<_>) = rows.into_iter().unzip();
            let (census, oracle) = (Census::of(&states, &speeds), oracle(&states, &speeds));
            prop_assert_eq!(census.by_state, oracle.by_state);
            prop_assert!((census.speed_sum - oracle.speed_sum).abs() <= 1e-5 * oracle.speed_sum.max(1.0));
        }

        #[test]
        fn no_bits_of_a_speed_make_the_sum_no_number(speeds in prop::collection::vec(any::<f32>(), 0..600)) {
            let sum = Census::of(&vec![1; speeds.len()], &speeds).speed_sum;
            prop_assert!(sum.is_finite() && sum >= 0.0);
        }
    }

    #[test]
    fn names_stand_in_the_order_of_the_states() {
        for (number, name) in (0..).zip(STATE_NAMES) {
            assert_eq!(format!("{:?}", RobotState::from_number(number)).to_lowercase(), name);
        }
        assert_eq!(RobotState::from_number(STATES as u8), RobotState::Absent);
    }
}
