//! Walls, edges, closures, doors, lifts, nodes, names and robots of a plan, each kind in a group of
//! its own.

use glam::Vec2;
use regatta_base::badge::{Badge, Sign};
use regatta_base::outline::LineKind;
use regatta_base::svg::Svg;
use regatta_interface::footprint::Footprint;
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord, Role};
use regatta_scene::background::{Line, lines_by_kind};
use regatta_scene::curves::midpoint;
use regatta_scene::facilities::{BAR_COLOURS, bars};
use regatta_scene::names::{Name, names};
use regatta_scene::palette::{COLOURS, Colouring, Rgb, Scale, Theme};
use regatta_scene::stations::{links, stations};

use super::hex;
use super::plan::Plan;

/// The colour of closed edges, as in closures.wgsl.
const CLOSED: &str = "#d8232e";
/// The size of the letters of names, in millimetres.
const LETTER_MM: f32 = 2.0;
/// The radius of a station's badge, in millimetres.
const BADGE_MM: f32 = 1.2;

/// Racks, and over them walls and the outlines of floors.
pub(super) fn draw_background(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    if plan.world.background_lines().is_empty() {
        return;
    }
    let (lines, colours) = (lines_by_kind(&plan.world, plan.level), plan.theme.colours());
    svg.element("g").set("id", "background").fill("none").open();
    for (kind, colour, width) in
        [(LineKind::Rack, colours.rack, 0.25), (LineKind::Wall, colours.wall, 0.5)]
    {
        let drawn = lines.iter().filter(|line| line.kind == kind);
        let drawn =
            drawn.map(|Line { points, .. }| points.iter().map(|point| *point + plan.offset));
        svg.element("path").stroke(hex(colour), width / per_metre).polylines(drawn);
    }
    svg.close();
}

pub(super) fn draw_edges(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
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

pub(super) fn draw_nodes(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    svg.element("g").set("id", "nodes").fill(hex(plan.theme.colours().node)).open();
    for node in plan.nodes() {
        let at = Vec2::new(node.x, node.y) + plan.offset;
        svg.circle(at, 0.35 / per_metre).set("id", format_args!("n{}", node.id)).open();
        svg.element("title").content(plan.world.text(node.name));
        svg.close();
    }
    svg.close();
}

/// Stations as badges, with lines to those of their nodes that are elsewhere.
pub(super) fn draw_stations(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let colours = plan.theme.colours();
    let [ink, paper] = [colours.node, colours.floor].map(hex);
    let badge =
        Badge { radius: f64::from(BADGE_MM / per_metre), paper: &paper, ink: &ink, is_y_up: true };
    let stations = stations(&plan.world, plan.level);
    svg.element("g").set("id", "stations").open();
    for link in links(&plan.world, &stations) {
        let [from, to] = link.ends.map(|end| end + plan.offset);
        svg.line(from, to).stroke(&ink, 0.2 / per_metre);
    }
    for station in &stations {
        let centre = (station.place + plan.offset).as_dvec2();
        badge.draw(svg, centre, sign(station.role), &station.name);
    }
    svg.close();
}

/// The sign of a role in drawings.
fn sign(role: Role) -> Sign {
    match role {
        Role::None => Sign::None,
        Role::Pick => Sign::Pick,
        Role::Drop => Sign::Drop,
        Role::Park => Sign::Park,
        Role::Charge => Sign::Charge,
        Role::Transfer => Sign::Transfer,
    }
}

/// The leaves of doors and the outlines of cabins, in the colours of their states.
pub(super) fn draw_facilities(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let tick = plan.frame.map_or(0, |frame| frame.tick());
    let group = svg.element("g").set("id", "facilities");
    group.number("stroke-width", 0.7 / per_metre).open();
    for bar in bars(&plan.world, plan.facilities, tick, plan.level) {
        let [from, to] = bar.ends.map(|end| end + plan.offset);
        svg.line(from, to).set("stroke", hex(BAR_COLOURS[bar.colour as usize]));
    }
    svg.close();
}

/// The names of stations, doors and lifts for which there is room, as in pictures.
pub(super) fn draw_names(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
    let group = svg.element("g").set("id", "names").fill(hex(plan.theme.colours().node));
    group.number("font-size", LETTER_MM / per_metre).open();
    let names = names(&plan.world, plan.level);
    let with_room = || names.iter().take_while(|name| name.scale * LETTER_MM <= per_metre);
    // Halos keep lines from striking names through. They are separate texts, and all below the
    // names: not every program draws them by `paint-order`.
    let halo = hex(plan.theme.colours().floor);
    let group = svg.element("g").fill(&halo).stroke(&halo, 1.0 / per_metre);
    group.set("stroke-linejoin", "round").open();
    for name in with_room() {
        write_name(svg, plan, name, per_metre);
    }
    svg.close();
    for name in with_room() {
        write_name(svg, plan, name, per_metre);
    }
    svg.close();
}

fn write_name(svg: &mut Svg, plan: &Plan<'_>, name: &Name, per_metre: f32) {
    let Vec2 { x, y } = name.place + plan.offset + Vec2::splat(1.3 / per_metre);
    let upright = format_args!("translate({x:.3} {y:.3}) scale(1 -1)");
    svg.element("text").set("transform", upright).content(&name.text);
}

/// The control points of an edge's curves.
fn curves_of(plan: &Plan<'_>, edge: &EdgeRecord) -> impl Iterator<Item = [Vec2; 4]> {
    let curves = plan.world.curves(edge).iter().map(|curve| curve.control_points);
    curves.map(|points| points.map(|point| Vec2::from(point) + plan.offset))
}

/// Closed edges, as in pictures: dashed, with a no-entry sign in the middle of each.
pub(super) fn draw_closures(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
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

pub(super) fn draw_robots(svg: &mut Svg, plan: &Plan<'_>, per_metre: f32) {
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
