//! A plan of a fleet as SVG: edges as their exact curves, nodes, and the outlines of robots at
//! their true size, in millimetres at a scale, with a grid in metres, a scale bar and an arrow to
//! the north.

use glam::Vec2;
use regatta_base::round;
use regatta_base::svg::Svg;
use regatta_interface::footprint::Footprint;
use regatta_interface::labels::station_of;
use regatta_interface::plan::{metres_text, round_step};
use regatta_interface::text::with_plural;
use regatta_plugin::facility::FacilityState;
use regatta_plugin::frame::{Frame, RobotState};
use regatta_plugin::world::{EdgeRecord, NodeRecord, RobotTypeRecord, Role};
use regatta_plugin::{Result, World};
use regatta_scene::camera::Bounds;
use regatta_scene::curves::midpoint;
use regatta_scene::facilities::{BAR_COLOURS, bars, named};
use regatta_scene::palette::{COLOURS, Colouring, Legend, Rgb, Scale, Theme};

/// The maximum number of robots in a file.
const MAX_ROBOTS: usize = 200_000;
/// The longest side of a drawing whose scale isn't given, in millimetres: that of A3, less a
/// margin.
const LONGEST_MM: f32 = 380.0;
/// The colour of closed edges, as in closures.wgsl.
const CLOSED: &str = "#d8232e";
/// The margin around the drawing, and the height of the line below it, in millimetres.
const MARGIN: f32 = 10.0;
const FOOTER: f32 = 14.0;

/// The contents of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The route graph and the robot types.
    pub world: World<'a>,
    /// The robots.
    pub frame: Option<Frame<'a>>,
    /// Each robot's index into the robot types.
    pub robot_type: Option<&'a [f32]>,
    /// Each robot's value, if they are coloured by a column or by speed.
    pub values: Option<&'a [f32]>,
    /// The data that robots are coloured by.
    pub colouring: &'a Colouring,
    /// The meaning of the colours, for the same theme.
    pub legend: &'a Legend,
    /// The colour theme.
    pub theme: Theme,
    /// The indices of closed edges, sorted.
    pub closed: &'a [u32],
    /// The states of doors and lifts.
    pub facilities: &'a [FacilityState],
    /// The level whose nodes, edges and robots are shown; `None` for all levels.
    pub level: Option<&'a str>,
    /// The visible part, in metres.
    pub bounds: Bounds,
    /// Metres added to all positions.
    pub offset: Vec2,
    /// The scale: 200 for 1:200; `None` for one at which the drawing fits on A3.
    pub scale: Option<f32>,
    /// The name of the fleet or the recording.
    pub name: &'a str,
    /// The time of the frame in seconds, on the clock that is shown.
    pub seconds: f64,
}

impl<'a> Plan<'a> {
    /// Whether something is shown whose level has this offset into the world's texts.
    fn shows(&self, level: u32) -> bool {
        self.level.is_none_or(|shown| self.world.text(level) == shown)
    }

    fn edges(&self) -> impl Iterator<Item = &'a EdgeRecord> {
        self.world.edges().iter().filter(|edge| self.shows(edge.level))
    }

    fn nodes(&self) -> impl Iterator<Item = &'a NodeRecord> {
        self.world.nodes().iter().filter(|node| self.shows(node.level))
    }

    /// The closed edges.
    fn closed_edges(&self) -> impl Iterator<Item = &'a EdgeRecord> {
        let edges = self.closed.iter().filter_map(|index| self.world.edges().get(*index as usize));
        edges.filter(|edge| self.shows(edge.level))
    }

    /// The rows of the frame's robots. A robot is on the level of its edge. A robot without an edge
    /// has no level.
    fn rows(&self, frame: Frame<'a>) -> impl Iterator<Item = usize> {
        let present =
            (0..frame.len()).filter(move |&row| frame.state_of(row) != RobotState::Absent);
        present.filter(move |&row| {
            let edge = self.world.edges().get(frame.edge()[row] as usize);
            self.level.is_none() || edge.is_some_and(|edge| self.shows(edge.level))
        })
    }

    /// The text below the drawing.
    fn title(&self) -> String {
        let level = self.level.map(|level| format!(", {level}")).unwrap_or_default();
        let seconds = self.seconds;
        let robots = self.frame.map_or(0, |frame| self.rows(frame).count());
        format!("{}{level}, {seconds:.2} s, {}", self.name, with_plural(robots as u64, "robot"))
    }
}

/// Returns the default scale of a drawing, given its longest side in metres: 1, 2 or 5 times a
/// power of ten.
fn fitting_scale(metres: f32) -> f32 {
    round::up((metres * 1000.0 / LONGEST_MM).max(1.0) * 0.999) as f32
}

/// Returns the text of the file.
///
/// # Errors
/// If there are too many robots for a file that programs open.
pub fn draw(plan: &Plan<'_>) -> Result<String> {
    let robots = plan.frame.map_or(0, |frame| frame.len());
    if robots > MAX_ROBOTS {
        return Err(regatta_plugin::Error::new(format!(
            "{robots} robots are too many for an SVG; {MAX_ROBOTS} are possible"
        )));
    }
    let (low, size) = (plan.bounds.low, (plan.bounds.high - plan.bounds.low).max(Vec2::splat(0.1)));
    let scale = plan.scale.unwrap_or_else(|| fitting_scale(size.max_element()));
    // Millimetres of paper per metre.
    let per_metre = 1000.0 / scale;
    let paper = size * per_metre + Vec2::new(2.0 * MARGIN, 2.0 * MARGIN + FOOTER);
    let colours = plan.theme.colours();
    let mut svg = Svg::new(2);
    svg.document(paper, "mm").set("font-family", "sans-serif").open();
    svg.element("title").content(plan.title());
    svg.element("desc").content(format_args!(
        "Scale 1:{scale}; a unit is a millimetre of paper; the group 'plan' is in metres, x east \
         and y north"
    ));
    svg.background(hex(colours.floor));
    let top = MARGIN + size.y * per_metre;
    let (east, north) = (MARGIN - low.x * per_metre, top + low.y * per_metre);
    let down = -per_metre;
    let page_from_plan = format_args!("matrix({per_metre} 0 0 {down} {east:.4} {north:.4})");
    svg.element("g").set("id", "plan").set("transform", page_from_plan).open();
    svg.decimals = 4;
    draw_grid(&mut svg, plan, per_metre);
    draw_edges(&mut svg, plan, per_metre);
    draw_closures(&mut svg, plan, per_metre);
    draw_facilities(&mut svg, plan, per_metre);
    draw_nodes(&mut svg, plan, per_metre);
    draw_names(&mut svg, plan, per_metre);
    draw_robots(&mut svg, plan, per_metre);
    svg.close();
    svg.decimals = 2;
    draw_footer(&mut svg, plan, paper, scale);
    Ok(svg.finish())
}

fn hex(colour: Rgb) -> String {
    format!("#{:06x}", colour.0)
}

/// Lines at round distances, some 15 mm apart on paper, with their coordinates.
fn draw_grid(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let Bounds { low, high } = plan.bounds;
    let colours = plan.theme.colours();
    let step = round_step(38.0 / per_metre);
    let (first, last) = ((low / step).ceil().as_ivec2(), (high / step).floor().as_ivec2());
    let xs = || (first.x..=last.x).map(|i| i as f32 * step);
    let ys = || (first.y..=last.y).map(|i| i as f32 * step);
    let stroke = hex(colours.grid);
    svg.element("g").set("id", "grid").stroke(stroke, 0.1 / per_metre).open();
    let columns = xs().map(|x| [Vec2::new(x, low.y), Vec2::new(x, high.y)]);
    let rows = ys().map(|y| [Vec2::new(low.x, y), Vec2::new(high.x, y)]);
    for [from, to] in columns.chain(rows) {
        svg.line(from, to);
    }
    svg.close();
    let group = svg.element("g").set("id", "coordinates").fill(hex(colours.node));
    group.number("font-size", 2.4 / per_metre).open();
    let below = xs().map(|x| (Vec2::new(x, low.y - 3.5 / per_metre), x, "middle"));
    let left = ys().map(|y| (Vec2::new(low.x - 1.0 / per_metre, y), y, "end"));
    for (Vec2 { x, y }, metres, anchor) in below.chain(left) {
        let upright = format_args!("translate({x:.3} {y:.3}) scale(1 -1)");
        let text = svg.element("text").set("transform", upright).set("text-anchor", anchor);
        text.content(metres_text(metres));
    }
    svg.close();
}

fn draw_edges(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let colours = plan.theme.colours();
    let group = svg.element("g").set("id", "edges").fill("none");
    group.number("stroke-width", 0.25 / per_metre).open();
    for edge in plan.edges() {
        let colour = if edge.reverse_speed > 0.0 { colours.two_way } else { colours.edge };
        let path = svg.element("path").set("id", format_args!("e{}", edge.id));
        path.set("stroke", hex(colour)).curves([curves_of(plan, edge)]);
    }
    svg.close();
}

fn draw_nodes(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    svg.element("g").set("id", "nodes").fill(hex(plan.theme.colours().node)).open();
    for node in plan.nodes() {
        let at = Vec2::new(node.x, node.y) + plan.offset;
        let radius = if node.role() == Role::None { 0.35 } else { 0.7 };
        svg.circle(at, radius / per_metre).set("id", format_args!("n{}", node.id)).open();
        svg.element("title").content(plan.world.text(node.name));
        svg.close();
    }
    svg.close();
}

/// The leaves of doors and the outlines of cabins, in the colours of their states.
fn draw_facilities(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let tick = plan.frame.map_or(0, |frame| frame.tick());
    let group = svg.element("g").set("id", "facilities");
    group.number("stroke-width", 0.7 / per_metre).open();
    for bar in bars(&plan.world, plan.facilities, tick, plan.level) {
        let [from, to] = bar.ends.map(|end| end + plan.offset);
        svg.line(from, to).set("stroke", hex(BAR_COLOURS[bar.colour as usize]));
    }
    svg.close();
}

/// The names of stations, doors and lifts, as in pictures.
fn draw_names(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let group = svg.element("g").set("id", "names").fill(hex(plan.theme.colours().node));
    group.number("font-size", 2.0 / per_metre).open();
    let stations = plan.nodes().filter_map(|node| {
        Some((Vec2::new(node.x, node.y), station_of(&plan.world, node)?.into_string()))
    });
    let facilities = named(&plan.world, plan.level).into_iter();
    let facilities = facilities.map(|named| (named.place, named.name.to_owned()));
    for (place, name) in stations.chain(facilities) {
        let Vec2 { x, y } = place + plan.offset + Vec2::splat(0.9 / per_metre);
        let upright = format_args!("translate({x:.3} {y:.3}) scale(1 -1)");
        svg.element("text").set("transform", upright).content(name);
    }
    svg.close();
}

/// The control points of an edge's curves.
fn curves_of(plan: &Plan<'_>, edge: &EdgeRecord) -> impl Iterator<Item = [Vec2; 4]> {
    let curves = plan.world.curves(edge).iter().map(|curve| curve.control_points);
    curves.map(|points| points.map(|point| Vec2::from(point) + plan.offset))
}

/// Closed edges, as in pictures: dashed, with a no-entry sign in the middle of each.
fn draw_closures(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    if plan.closed_edges().next().is_none() {
        return;
    }
    let [line, dash, gap, radius, bar] =
        [0.7, 1.8, 1.2, 1.7, 0.7].map(|millimetres: f32| millimetres / per_metre);
    let group = svg.element("g").set("id", "closed").fill("none").stroke(CLOSED, line);
    group.set("stroke-dasharray", format_args!("{dash:.5} {gap:.5}")).open();
    for edge in plan.closed_edges() {
        let path = svg.element("path").set("id", format_args!("closed-e{}", edge.id));
        path.curves([curves_of(plan, edge)]);
    }
    svg.close();
    svg.element("g").set("id", "no-entry").open();
    for at in plan.closed_edges().filter_map(|edge| midpoint(&plan.world, edge)) {
        let (at, size) = (at + plan.offset, Vec2::new(1.3 * radius, bar));
        svg.circle(at, radius).fill(CLOSED);
        svg.rect(at - size / 2.0, size).fill("#ffffff");
    }
    svg.close();
}

fn draw_robots(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let Some(frame) = plan.frame else { return };
    let default_type = RobotTypeRecord::new("robot", 0.9, 0.6);
    let palette = plan.legend.scale.colours(plan.theme);
    let border = if plan.theme == Theme::Dark { "#ffffff" } else { "#222222" };
    svg.element("g").set("id", "robots").stroke(border, 0.12 / per_metre).open();
    for row in plan.rows(frame) {
        let place = Vec2::new(frame.x()[row], frame.y()[row]) + plan.offset;
        if !place.is_finite() {
            continue;
        }
        let index =
            plan.robot_type.and_then(|column| column.get(row)).map_or(0, |index| *index as usize);
        let robot_type = plan.world.robot_types().get(index).unwrap_or(&default_type);
        let heading = frame.theta()[row];
        let outline = match Footprint::of(robot_type, place, heading) {
            Footprint::Circle { centre, radius } => svg.circle(centre, radius),
            Footprint::Rectangle(corners) => svg.element("polygon").points(corners),
        };
        let fill = hex(colour(plan, &palette, row, index));
        outline.set("id", format_args!("robot-{row}")).fill(fill);
        let tip = place + Vec2::from_angle(heading) * (robot_type.length / 2.0);
        svg.line(place, tip);
    }
    svg.close();
}

/// The colour of a robot, as in the picture.
fn colour(plan: &Plan<'_>, palette: &[Rgb; COLOURS], row: usize, robot_type: usize) -> Rgb {
    let state = plan.frame.map_or(0, |frame| frame.columns().state[row]);
    let value = match plan.colouring {
        Colouring::State => Some(f32::from(state)),
        Colouring::Type => Some((robot_type % COLOURS) as f32),
        Colouring::Speed | Colouring::Column(_) => {
            plan.values.and_then(|values| values.get(row)).copied()
        }
    };
    let Some(value) = value.filter(|value| value.is_finite()) else {
        return plan.theme.colours().unknown;
    };
    let index = match &plan.legend.scale {
        Scale::Categories(_) => value,
        Scale::Ramp { low, high, .. } => {
            (value - low) / (high - low).max(1e-6) * (COLOURS - 1) as f32
        }
    };
    palette[index.round().clamp(0.0, (COLOURS - 1) as f32) as usize]
}

/// The line below the drawing: the title, the scale bar, and an arrow to the north.
fn draw_footer(svg: &mut Svg, plan: &Plan<'_>, paper: Vec2, scale: f32) {
    let colours = plan.theme.colours();
    let below = paper.y - 6.0;
    let metres = round_step(scale * 0.05);
    let bar = metres * 1000.0 / scale;
    let left = paper.x - MARGIN - bar - 16.0;
    let group = svg.element("g").set("id", "legend").fill(hex(colours.node));
    group.set("font-size", 3.2).open();
    svg.text(Vec2::new(MARGIN, below)).content(format_args!("{}   1:{scale}", plan.title()));
    for part in 0..4_u8 {
        let fill = if part % 2 == 0 { colours.node } else { colours.floor };
        let corner = Vec2::new(left + bar * f32::from(part) / 4.0, below - 1.6);
        let rect = svg.rect(corner, Vec2::new(bar / 4.0, 1.6));
        rect.fill(hex(fill)).stroke(hex(colours.node), 0.15);
    }
    let north = Vec2::new(paper.x - MARGIN - 3.0, below);
    let Vec2 { x, y } = north - Vec2::new(0.0, 8.0);
    svg.element("path").set("d", format_args!("M{x:.2} {y:.2}l2 7l-2 -1.6l-2 1.6z"));
    for (at, text) in [
        (Vec2::new(left, below - 2.6), "0"),
        (Vec2::new(left + bar, below - 2.6), &metres_text(metres)),
        (north + Vec2::new(0.0, 2.8), "N"),
    ] {
        svg.text(at).set("text-anchor", "middle").content(text);
    }
    svg.close();
}

#[cfg(test)]
mod tests {
    use regatta_plugin::facility::DoorState;
    use regatta_plugin::frame::{
        ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines,
    };
    use regatta_plugin::world::{CurveRecord, DoorRecord, NodeRecord, WorldData};

    use super::*;

    #[test]
    fn scales_are_round_and_the_drawing_fits() {
        for (metres, scale) in [
            (3.8, 10.0),
            (20.0, 100.0),
            (70.0, 200.0),
            (76.0, 200.0),
            (100.0, 500.0),
            (900.0, 5000.0),
        ] {
            assert_eq!(fitting_scale(metres), scale, "{metres} m");
            assert!(metres * 1000.0 / scale <= LONGEST_MM * 1.01);
        }
    }

    #[test]
    fn a_plan_has_curves_and_outlines_at_their_true_size() {
        let mut world = WorldData {
            robot_types: vec![RobotTypeRecord::new("a <b>", 1.0, 0.5)],
            ..WorldData::default()
        };
        world.nodes = vec![NodeRecord { id: 3, x: 1.0, y: 2.0, ..NodeRecord::default() }];
        let curve =
            CurveRecord { control_points: [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [4.0, 2.0]] };
        world.add_edge(EdgeRecord { id: 9, ..EdgeRecord::default() }, [curve]);
        let header = FrameHeader {
            robots: 2,
            stride_lines: stride_lines(2) as u32,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(2)];
        let columns = ColumnsMut::split(&mut lines, 2);
        (columns.x[0], columns.y[0], columns.state[0]) = (2.0, 1.0, RobotState::Driving as u8);
        columns.state[1] = RobotState::Absent as u8;
        let colouring = Colouring::State;
        let legend = colouring.legend(Theme::Light, &[], None);
        let plan = Plan {
            world: world.view(1, 1),
            frame: Some(Frame::new(&header, &lines).expect("a frame")),
            robot_type: None,
            values: None,
            colouring: &colouring,
            legend: &legend,
            theme: Theme::Light,
            closed: &[],
            facilities: &[],
            level: None,
            bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
            offset: Vec2::ZERO,
            scale: Some(50.0),
            name: "A & B",
            seconds: 0.0,
        };
        let text = draw(&plan).expect("a drawing");
        // 4 m and 2 m at 1:50 are 80 mm and 40 mm; margins and the line below come on top.
        assert!(text.contains("width=\"100.00mm\" height=\"74.00mm\""), "{text}");
        assert!(
            text.contains("d=\"M0.0000 0.0000C1.0000 0.0000 1.0000 2.0000 4.0000 2.0000\""),
            "{text}"
        );
        assert!(
            text.contains("points=\"1.5000,0.7500 2.5000,0.7500 2.5000,1.2500 1.5000,1.2500\""),
            "{text}"
        );
        assert!(
            text.contains("id=\"n3\"")
                && !text.contains("robot-1\"")
                && text.contains("A &amp; B, 0.00 s, 1 robot   1:50"),
            "{text}"
        );
        assert!(text.contains("matrix(20 0 0 -20 10.0000 50.0000)"), "{text}");
        assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
        assert!(!text.contains("closed"));
        let text = draw(&Plan { closed: &[0, 7], ..plan }).expect("a drawing");
        let path = "<path id=\"closed-e9\" d=\"M0.0000 0.0000C1.0000 0.0000 1.0000 2.0000 4.0000 2.0000\"/>";
        assert!(text.contains(path) && text.contains("stroke-dasharray"), "{text}");
        assert_eq!(
            text.matches("fill=\"#d8232e\"").count(),
            1,
            "a sign for each closed edge that the world has"
        );
        assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
    }

    #[test]
    fn a_plan_has_the_names_of_stations_and_doors_and_the_states_of_doors() {
        let mut world = WorldData::default();
        let [dock, gate] = ["dock <1>", "gate"].map(|name| world.texts.add(name));
        let role = Role::Pick as u32;
        world.nodes = vec![NodeRecord { name: dock, role, ..NodeRecord::default() }];
        world.add_edge(EdgeRecord::default(), []);
        let line = [[0.0, -1.0], [0.0, 1.0]];
        world.add_door(DoorRecord { name: gate, line, ..DoorRecord::default() }, [0]);
        let colouring = Colouring::State;
        let legend = colouring.legend(Theme::Light, &[], None);
        let open = FacilityState { door: DoorState::Open as u32, ..FacilityState::default() };
        let plan = Plan {
            world: world.view(1, 1),
            frame: None,
            robot_type: None,
            values: None,
            colouring: &colouring,
            legend: &legend,
            theme: Theme::Light,
            closed: &[],
            facilities: &[open],
            level: None,
            bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
            offset: Vec2::ZERO,
            scale: None,
            name: "fleet",
            seconds: 0.0,
        };
        let text = draw(&plan).expect("a drawing");
        assert!(text.contains(">dock &lt;1&gt;</text>") && text.contains(">gate</text>"), "{text}");
        assert_eq!(text.matches("stroke=\"#30b361\"").count(), 2, "its leaves: {text}");
        assert_eq!(text.matches("<g").count(), text.matches("</g>").count());
    }

    /// Returns the ids of what a drawing shows, in its order.
    fn ids(text: &str) -> Vec<&str> {
        let ids = text.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next());
        ids.filter(|id| id.ends_with(|last: char| last.is_ascii_digit())).collect()
    }

    #[test]
    fn a_plan_of_a_level_has_only_what_is_on_that_level() {
        let mut world = WorldData::default();
        let levels = ["cellar", "ground"].map(|name| world.texts.add(name));
        for (id, level) in (0..).zip(levels) {
            world.nodes.push(NodeRecord { id, level, ..NodeRecord::default() });
            let line = CurveRecord::straight([0.0, 0.0], [4.0, 0.0]);
            world.add_edge(EdgeRecord { id: 10 + id, level, ..EdgeRecord::default() }, [line]);
        }
        // A robot on each level, and one on no edge.
        let header = FrameHeader {
            robots: 3,
            stride_lines: stride_lines(3) as u32,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(3)];
        let columns = ColumnsMut::split(&mut lines, 3);
        columns.edge[..3].copy_from_slice(&[0, 1, NO_EDGE]);
        columns.state[..3].fill(RobotState::Driving as u8);
        let colouring = Colouring::State;
        let legend = colouring.legend(Theme::Light, &[], None);
        let drawn = |level| {
            let plan = Plan {
                world: world.view(1, 1),
                frame: Some(Frame::new(&header, &lines).expect("a frame")),
                robot_type: None,
                values: None,
                colouring: &colouring,
                legend: &legend,
                theme: Theme::Light,
                closed: &[0, 1],
                facilities: &[],
                level,
                bounds: Bounds { low: Vec2::ZERO, high: Vec2::new(4.0, 2.0) },
                offset: Vec2::ZERO,
                scale: None,
                name: "fleet",
                seconds: 0.0,
            };
            draw(&plan).expect("a drawing")
        };
        let cellar = drawn(Some("cellar"));
        assert_eq!(ids(&cellar), ["e10", "closed-e10", "n0", "robot-0"]);
        assert_eq!(cellar.matches("fill=\"#d8232e\"").count(), 1);
        assert!(cellar.contains("<title>fleet, cellar, 0.00 s, 1 robot</title>"), "{cellar}");
        assert_eq!(ids(&drawn(Some("ground"))), ["e11", "closed-e11", "n1", "robot-1"]);
        let all = drawn(None);
        let shown =
            ["e10", "e11", "closed-e10", "closed-e11", "n0", "n1", "robot-0", "robot-1", "robot-2"];
        assert_eq!(ids(&all), shown);
    }
}
