//! Times, headers, logs and geometry: `builtin_interfaces`, `rcl_interfaces`, `rosgraph_msgs`,
//! `std_msgs`, `geometry_msgs`, `tf2_msgs`.

use std::time::Duration as StdDuration;

super::messages! {
    /// Simulated time since the start of the run.
    builtin_interfaces struct Time {
        sec: i32,
        nanosec: u32,
    }

    builtin_interfaces struct Duration {
        sec: i32,
        nanosec: u32,
    }

    rosgraph_msgs struct Clock {
        clock: Time,
    }

    std_msgs struct Header {
        stamp: Time,
        frame_id: String,
    }

    rcl_interfaces struct Log {
        stamp: Time,
        level: u8,
        name: String,
        msg: String,
        file: String,
        function: String,
        line: u32,
    }

    std_msgs struct Float64 {
        data: f64,
    }

    /// Parts from 0 to 1.
    std_msgs struct ColorRGBA {
        r: f32,
        g: f32,
        b: f32,
        a: f32,
    }

    /// Metres.
    geometry_msgs struct Point {
        x: f64,
        y: f64,
        z: f64,
    }

    geometry_msgs struct Vector3 {
        x: f64,
        y: f64,
        z: f64,
    }

    geometry_msgs struct Quaternion {
        x: f64,
        y: f64,
        z: f64,
        w: f64,
    }

    geometry_msgs struct Pose {
        position: Point,
        orientation: Quaternion,
    }

    geometry_msgs struct PoseStamped {
        header: Header,
        pose: Pose,
    }

    geometry_msgs struct PoseArray {
        header: Header,
        poses: Vec<Pose>,
    }

    /// Metres per second and radians per second.
    geometry_msgs struct Twist {
        linear: Vector3,
        angular: Vector3,
    }

    geometry_msgs struct Accel {
        linear: Vector3,
        angular: Vector3,
    }

    /// The covariances are six rows of six: on the wire the same as 36 numbers.
    geometry_msgs struct PoseWithCovariance {
        pose: Pose,
        covariance: [[f64; 6]; 6],
    }

    geometry_msgs struct TwistWithCovariance {
        twist: Twist,
        covariance: [[f64; 6]; 6],
    }

    geometry_msgs struct Transform {
        translation: Vector3,
        rotation: Quaternion,
    }

    geometry_msgs struct TransformStamped {
        header: Header,
        child_frame_id: String,
        transform: Transform,
    }

    tf2_msgs struct TFMessage {
        transforms: Vec<TransformStamped>,
    }
}

impl Time {
    /// The time after a duration. Seconds beyond 68 years are cut, as the message has 31 bits.
    pub fn after(duration: StdDuration) -> Self {
        let sec = i32::try_from(duration.as_secs()).unwrap_or(i32::MAX);
        Self { sec, nanosec: duration.subsec_nanos() }
    }
}

impl Log {
    /// The level of warnings.
    pub const WARN: u8 = 30;
}

impl Duration {
    /// A duration.
    pub fn of(duration: StdDuration) -> Self {
        let Time { sec, nanosec } = Time::after(duration);
        Self { sec, nanosec }
    }
}

impl Quaternion {
    /// A rotation about the vertical, in radians.
    pub fn heading(theta: f64) -> Self {
        let (z, w) = (theta / 2.0).sin_cos();
        Self { x: 0.0, y: 0.0, z, w }
    }
}

impl Pose {
    /// A pose on the ground: metres, radians.
    pub fn on_ground(x: f64, y: f64, theta: f64) -> Self {
        Self { position: Point { x, y, z: 0.0 }, orientation: Quaternion::heading(theta) }
    }
}

impl Header {
    /// A header.
    pub fn new(stamp: &Time, frame_id: &str) -> Self {
        Self { stamp: stamp.clone(), frame_id: frame_id.to_owned() }
    }
}
