//! The action `nav2_msgs/NavigateToPose`. Its newest definition only appends fields to those of
//! Jazzy and Kilted, whose clients don't read them.

use super::geometry::{Duration, PoseStamped};

super::messages! {
    nav2_msgs struct NavigateToPoseGoal {
        pose: PoseStamped,
        behavior_tree: String,
    }

    nav2_msgs struct NavigateToPoseResult {
        error_code: u16,
        error_msg: String,
    }

    nav2_msgs struct NavigateToPoseFeedback {
        current_pose: PoseStamped,
        navigation_time: Duration,
        estimated_time_remaining: Duration,
        number_of_recoveries: i16,
        distance_remaining: f32,
        position_tracking_error: f32,
        heading_tracking_error: f32,
    }
}

/// The error code of a result for any other reason.
pub const UNKNOWN: u16 = 9000;
