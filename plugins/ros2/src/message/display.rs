//! Messages that tools draw and list: `nav_msgs`, `visualization_msgs`, `diagnostic_msgs`.

use super::geometry::{
    ColorRGBA, Duration, Header, Point, Pose, PoseWithCovariance, Time, TwistWithCovariance,
    Vector3,
};

super::messages! {
    nav_msgs struct Odometry {
        header: Header,
        child_frame_id: String,
        pose: PoseWithCovariance,
        twist: TwistWithCovariance,
    }

    nav_msgs struct MapMetaData {
        map_load_time: Time,
        /// Metres per cell.
        resolution: f32,
        width: u32,
        height: u32,
        /// The pose of the lower left corner of the cell (0, 0).
        origin: Pose,
    }

    nav_msgs struct OccupancyGrid {
        header: Header,
        info: MapMetaData,
        /// Row by row from the south: 0 to 100 percent, -1 if unknown.
        data: Vec<i8>,
    }

    sensor_msgs struct CompressedImage {
        header: Header,
        format: String,
        data: Vec<u8>,
    }

    visualization_msgs struct UVCoordinate {
        u: f32,
        v: f32,
    }

    visualization_msgs struct MeshFile {
        filename: String,
        data: Vec<u8>,
    }

    visualization_msgs struct Marker {
        header: Header,
        ns: String,
        id: i32,
        r#type: i32,
        action: i32,
        pose: Pose,
        scale: Vector3,
        color: ColorRGBA,
        lifetime: Duration,
        frame_locked: bool,
        points: Vec<Point>,
        colors: Vec<ColorRGBA>,
        texture_resource: String,
        texture: CompressedImage,
        uv_coordinates: Vec<UVCoordinate>,
        text: String,
        mesh_resource: String,
        mesh_file: MeshFile,
        mesh_use_embedded_materials: bool,
    }

    visualization_msgs struct MarkerArray {
        markers: Vec<Marker>,
    }

    diagnostic_msgs struct KeyValue {
        key: String,
        value: String,
    }

    diagnostic_msgs struct DiagnosticStatus {
        level: u8,
        name: String,
        message: String,
        hardware_id: String,
        values: Vec<KeyValue>,
    }

    diagnostic_msgs struct DiagnosticArray {
        header: Header,
        status: Vec<DiagnosticStatus>,
    }
}

/// Types of a [`Marker`].
pub mod shape {
    pub const CUBE: i32 = 1;
    pub const SPHERE: i32 = 2;
    pub const CYLINDER: i32 = 3;
    pub const LINE_STRIP: i32 = 4;
    pub const LINE_LIST: i32 = 5;
}

/// The action of a [`Marker`] that removes all of its topic.
pub const DELETE_ALL: i32 = 3;

/// Levels of a [`DiagnosticStatus`].
pub mod level {
    pub const OK: u8 = 0;
    pub const WARN: u8 = 1;
    pub const ERROR: u8 = 2;
}
