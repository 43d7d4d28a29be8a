//! The interface of a small fleet in a window, at several sizes and scales.

use egui::containers::panel::PanelState;
use egui::{IdSalt, Rect};
use egui_kittest::Harness;
use regatta_interface::Interface;
use regatta_interface::camera_controller::CameraController;
use regatta_interface::jams::JamFacts;
use regatta_interface::labels::Labels;
use regatta_interface::performance::Timing;
use regatta_interface::settings::Settings;
use regatta_interface::view_model::{Action, Counts, EngineState, RunningUdp, Timeline, ViewModel};
use regatta_plugin::Contacts;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::{ColumnsMut, Frame, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::work::WorkFigures;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::palette::{Colouring, Legend, Theme};
use regatta_scene::plans::PlanFacts;

/// The sizes of the window in pixels, and the scales.
const SIZES: [[f32; 2]; 3] = [[640.0, 400.0], [1280.0, 720.0], [1920.0, 1080.0]];
const SCALES: [f32; 2] = [1.0, 1.5];
/// The size of a window that isn't about sizes.
pub const USUAL: [f32; 2] = SIZES[1];

/// All sizes at all scales.
pub fn windows() -> impl Iterator<Item = ([f32; 2], f32)> {
    SIZES.into_iter().flat_map(|size| SCALES.map(|scale| (size, scale)))
}

/// The window in points.
pub fn window_in_points([width, height]: [f32; 2], scale: f32) -> Rect {
    Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height) / scale)
}

/// Twenty robots on an edge.
pub struct Fixture {
    pub interface: Interface,
    pub header: FrameHeader,
    pub lines: Vec<Line>,
    pub world: WorldData,
    pub labels: Labels,
    pub jams: JamFacts,
    pub timing: Timing,
    pub legend: Legend,
    pub picture: Rect,
    pub actions: Vec<Action>,
    pub engine: EngineState,
    /// The figures of the fleet's work, with their run.
    pub work: Option<(u64, WorkFigures)>,
    /// The figures of a collision checker.
    pub contacts: Option<ContactHeader>,
    pub pairs: Vec<ContactRecord>,
    /// The file that is replayed, or the past of a live run; neither is known as long as it is
    /// `None`.
    pub timeline: Option<Timeline<'static>>,
    /// Each robot's activity, if a fleet manager publishes it.
    pub activities: Option<Vec<f32>>,
    /// The bars and panels of the last picture, with their names.
    pub panels: Vec<(&'static str, Rect)>,
    /// The height of the window, in points.
    pub window_height: f32,
}

/// The names of all bars and panels.
pub const PANELS: [&str; 8] =
    ["top", "strip", "bottom", "timeline", "plots", "low plots", "left", "right"];

impl Fixture {
    fn new() -> Self {
        let robots = 20;
        let header = FrameHeader {
            run_id: 1,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            sim_time_nanos: 83_456_000_000,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(robots)];
        let columns = ColumnsMut::split(&mut lines, robots);
        (0..robots).for_each(|i| {
            (columns.x[i], columns.state[i], columns.edge[i]) = (i as f32, 1, (i % 2) as u32)
        });
        let mut world = WorldData {
            nodes: vec![
                NodeRecord { id: 446, ..NodeRecord::default() },
                NodeRecord { id: 7, x: 20.0, ..NodeRecord::default() },
            ],
            ..WorldData::default()
        };
        let edge = EdgeRecord {
            id: 567,
            origin: 0,
            destination: 1,
            length: 20.0,
            ..EdgeRecord::default()
        };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [20.0, 0.0])]);
        Self {
            interface: Interface::new(
                Settings { ids: false, ..Settings::default() },
                CameraController::new(Camera::default(), true),
            ),
            header,
            lines,
            labels: Labels::new(&world.view(1, 1), None),
            world,
            jams: JamFacts::default(),
            timing: Timing::new("an adapter".into()),
            legend: Colouring::collision().legend(Theme::Dark, &[], None),
            picture: Rect::ZERO,
            actions: Vec::new(),
            engine: EngineState::Running,
            work: None,
            contacts: None,
            pairs: Vec::new(),
            timeline: None,
            activities: None,
            panels: Vec::new(),
            window_height: 0.0,
        }
    }

    /// Whether plots are as low as they can be: beside a panel, in a low window.
    fn has_low_plots(&self) -> bool {
        let settings = &self.interface.settings;
        self.window_height < 900.0 && (settings.left.is_some() || settings.right.is_some())
    }

    /// The place of the plots, if they are open.
    pub fn plots(&self) -> Option<Rect> {
        self.panel("plots").or_else(|| self.panel("low plots"))
    }

    /// The place of a bar or a panel, if it is open.
    pub fn panel(&self, name: &str) -> Option<Rect> {
        let settings = &self.interface.settings;
        // Those that were open are remembered.
        let is_open = match name {
            "left" => settings.left.is_some(),
            // In a window of medium width, it lies below the one on the left.
            "right" if self.picture.width() < 1400.0 => {
                settings.right.is_some() && settings.left.is_none()
            }
            "right" => settings.right.is_some(),
            "plots" => settings.plots && !self.has_low_plots(),
            "low plots" => settings.plots && self.has_low_plots(),
            _ => true,
        };
        self.panels.iter().find(|(other, _)| *other == name && is_open).map(|(_, place)| *place)
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let status = ControlResponse { robots: 20, speed: 1.0, ..ControlResponse::default() };
        let model = ViewModel {
            work: self.work,
            timeline: self.timeline,
            jams: &self.jams,
            density: None,
            closed: &[],
            fleet: "a-fleet-with-a-long-name",
            engine: self.engine,
            status: Some(&status),
            frame: Some(Frame::new(&self.header, &self.lines).expect("a frame")),
            world: self.world.view(1, 1),
            labels: &self.labels,
            robot_type_column: None,
            activity_column: self.activities.as_deref(),
            contacts: self.contacts.as_ref().map(|header| Contacts {
                header,
                pairs: &self.pairs,
                missed: 0,
            }),
            legend: &self.legend,
            columns: &[],
            values: &[("collision".parse().expect("a name"), 2.0)],
            order: None,
            named_order: None,
            route: None,
            plans: PlanFacts::default(),
            rows: None,
            matches: None,
            bounds: Bounds::default(),
            followed: None,
            timing: &self.timing,
            counts: Counts::default(),
            lag: None,
            trail_points: 0,
            udp: RunningUdp::default(),
        };
        let (picture, actions) = self.interface.show(ui, &model);
        self.picture = picture;
        let place = |name: &'static str| {
            Some((
                name,
                PanelState::load(ui.ctx(), ui.scope_id().with_salt(IdSalt::new(name)))?.outer_rect,
            ))
        };
        self.panels = PANELS.into_iter().filter_map(place).collect();
        self.window_height = ui.ctx().content_rect().height();
        self.actions.extend(actions);
    }
}

/// A window that shows an interface.
pub fn harness(
    size: [f32; 2],
    scale: f32,
    prepare: impl FnOnce(&mut Interface),
) -> Harness<'static, Fixture> {
    harness_of(size, scale, |fixture| prepare(&mut fixture.interface))
}

/// A window that shows a fixture.
pub fn harness_of(
    [width, height]: [f32; 2],
    scale: f32,
    prepare: impl FnOnce(&mut Fixture),
) -> Harness<'static, Fixture> {
    let mut fixture = Fixture::new();
    fixture.interface.settings.scale = scale;
    prepare(&mut fixture);
    let builder = Harness::builder().with_size([width, height]).with_max_steps(64);
    let mut harness = builder.build_ui_state(|ui, fixture: &mut Fixture| fixture.show(ui), fixture);
    harness.run_steps(8);
    harness
}
