//! Marks under and on the route graph, and over the robots: walls, routes, closed edges, stations,
//! the selected edge or node, goals, and arrows from robots that wait to those that they wait for.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::EdgeRecord;
use regatta_scene::background::walls;
use regatta_scene::curves::midpoint;
use regatta_scene::facilities::Bar;
use regatta_scene::plans::{GoalMark, PlanReport, WaitArrow};
use regatta_scene::route::RouteSegment;
use regatta_scene::stations::{links, stations};
use regatta_scene::{Layers, Marked, is_on_level};
use wgpu::{BindGroup, BindGroupLayout, RenderPass, VertexAttribute, vertex_attr_array};

use super::device::Gpu;
use super::instances::{Instance, Instances};
use super::pipeline::{TargetConfig, shader};

/// The vertices of a quad.
const QUAD: u32 = 4;
/// The vertices of the strips along curves: parts, which are the same as in the shaders, have two
/// at either end.
const ROUTE: u32 = 2 * (32 + 1);
const NARROW_ROUTE: u32 = 2 * (12 + 1);
const CLOSED: u32 = 2 * (32 + 1);
const SELECTED_EDGE: u32 = 2 * (64 + 1);

/// A badge at a station: an instance of stations.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Badge {
    /// Metres east and north of the world's origin.
    place: Vec2,
    /// A [`Role`](regatta_plugin::world::Role).
    role: u32,
}

impl Instance for Badge {
    const ATTRIBUTES: &'static [VertexAttribute] = &vertex_attr_array![0 => Float32x2, 1 => Uint32];
}

/// Draws the marks.
#[derive(Debug)]
pub struct Marks {
    /// Narrow ribbons along the routes of all robots.
    all_routes: Instances<RouteSegment>,
    /// Wide ribbons along the routes of selected robots.
    routes: Instances<RouteSegment>,
    /// Dashed ribbons along the curves of closed edges, by index.
    closed: Instances<u32>,
    /// No-entry signs in the middle of closed edges.
    signs: Instances<Vec2>,
    stations: Instances<Badge>,
    /// The background, and lines from stations to their nodes.
    walls: Instances<Bar>,
    /// Doors and the cabins of lifts.
    facilities: Instances<Bar>,
    /// The curves of the selected edge, by index.
    selected_edge: Instances<u32>,
    selected_node: Instances<u32>,
    goals: Instances<GoalMark>,
    arrows: Instances<WaitArrow>,
    selected: Option<Marked>,
    /// The curves of each edge.
    curves: Vec<Range<u32>>,
    /// The number of nodes.
    nodes: u32,
}

impl Marks {
    /// Creates the pipelines. The layouts are those of the groups of the view, of the graph's
    /// records and of the robots' columns.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
        columns: &BindGroupLayout,
    ) -> Self {
        let [routes, closures, selected] =
            ["routes", "closures", "marked"].map(|name| shader(gpu, name));
        let on_graph = [view, records];
        let (wide, narrow) = (("route", "route_fill"), ("narrow_route", "route_fill"));
        let (ribbon, sign) = (("ribbon", "ribbon_fill"), ("sign", "sign_fill"));
        let (edge, node) = (("edge", "edge_fill"), ("node", "node_fill"));
        let (badge, mark) = (("badge", "badge_fill"), ("mark", "mark_fill"));
        let (stations, goals) = (shader(gpu, "stations"), shader(gpu, "goals"));
        let (waits, facilities) = (shader(gpu, "waits"), shader(gpu, "facilities"));
        let bar = ("bar", "bar_fill");
        Self {
            all_routes: Instances::new(gpu, target, &routes, narrow, &on_graph, NARROW_ROUTE),
            routes: Instances::new(gpu, target, &routes, wide, &on_graph, ROUTE),
            closed: Instances::new(gpu, target, &closures, ribbon, &on_graph, CLOSED),
            signs: Instances::new(gpu, target, &closures, sign, &[view], QUAD),
            stations: Instances::new(gpu, target, &stations, badge, &[view], QUAD),
            walls: Instances::new(gpu, target, &facilities, bar, &[view], QUAD),
            facilities: Instances::new(gpu, target, &facilities, bar, &[view], QUAD),
            selected_edge: Instances::new(gpu, target, &selected, edge, &on_graph, SELECTED_EDGE),
            selected_node: Instances::new(gpu, target, &selected, node, &on_graph, QUAD),
            goals: Instances::new(gpu, target, &goals, mark, &on_graph, QUAD),
            arrows: Instances::new(gpu, target, &waits, mark, &[view, columns], QUAD),
            selected: None,
            curves: Vec::new(),
            nodes: 0,
        }
    }

    /// Takes the background and the stations of a world's level, and its graph, in which nothing is
    /// selected yet.
    pub fn set_world(&mut self, gpu: &Gpu, world: &World<'_>, level: Option<&str>) {
        let stations = stations(world, level);
        let mut walls = walls(world, level);
        walls.extend(links(world, &stations));
        self.walls.set(gpu, &walls);
        let badges = stations.iter();
        let badges =
            badges.map(|station| Badge { place: station.place, role: station.role as u32 });
        self.stations.set(gpu, &badges.collect::<Vec<_>>());
        self.curves = world.edges().iter().map(|edge| curves_of(world, edge)).collect();
        self.nodes = world.nodes().len() as u32;
        self.selected = None;
    }

    /// Replaces the closed edges of a level, by index.
    pub fn set_closed(
        &mut self,
        gpu: &Gpu,
        world: &World<'_>,
        closed: &[u32],
        level: Option<&str>,
    ) {
        let (mut curves, mut signs) = (Vec::new(), Vec::new());
        for edge in closed.iter().filter_map(|edge| world.edges().get(*edge as usize)) {
            if is_on_level(world, edge.level, level) {
                curves.extend(curves_of(world, edge));
                signs.extend(midpoint(world, edge));
            }
        }
        self.closed.set(gpu, &curves);
        self.signs.set(gpu, &signs);
    }

    /// Replaces the bars of doors and lifts.
    pub fn set_facilities(&mut self, gpu: &Gpu, bars: &[Bar]) {
        self.facilities.set(gpu, bars);
    }

    /// Replaces the routes of selected robots.
    pub fn set_routes(&mut self, gpu: &Gpu, segments: &[RouteSegment]) {
        self.routes.set(gpu, segments);
    }

    /// Replaces the routes of all robots, the goals and the arrows.
    pub fn set_plans(&mut self, gpu: &Gpu, plans: &PlanReport) {
        self.all_routes.set(gpu, &plans.lines);
        self.goals.set(gpu, &plans.goals);
        self.arrows.set(gpu, &plans.arrows);
    }

    /// Uploads the selected edge or node if it has changed.
    pub fn select(&mut self, gpu: &Gpu, selected: Option<Marked>) {
        if self.selected == selected {
            return;
        }
        self.selected = selected;
        let (mut curves, mut nodes) = (Vec::new(), Vec::new());
        match selected {
            Some(Marked::Edge(index)) => {
                curves.extend(self.curves.get(index as usize).cloned().into_iter().flatten());
            }
            Some(Marked::Node(index)) if index < self.nodes => nodes.push(index),
            Some(Marked::Node(_)) | None => {}
        }
        self.selected_edge.set(gpu, &curves);
        self.selected_node.set(gpu, &nodes);
    }

    /// Draws the background, and the lines from stations to their nodes.
    pub fn draw_under_graph(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        if layers.edges {
            self.walls.draw(pass);
        }
    }

    /// Draws the marks on the graph. `records` are those of the graph, if there is one.
    pub fn draw_on_graph(
        &self,
        pass: &mut RenderPass<'_>,
        records: Option<&BindGroup>,
        layers: Layers,
    ) {
        if let Some(records) = records {
            pass.set_bind_group(1, records, &[]);
            if layers.plans && layers.edges {
                self.all_routes.draw(pass);
            }
            if layers.edges {
                self.routes.draw(pass);
                self.facilities.draw(pass);
                self.closed.draw(pass);
                self.signs.draw(pass);
            }
        }
        if layers.nodes {
            self.stations.draw(pass);
        }
        if records.is_some() && self.selected.is_some() {
            self.selected_edge.draw(pass);
            self.selected_node.draw(pass);
        }
    }

    /// Draws the goals over the robots, and the arrows if they are shown.
    pub fn draw_over_robots(
        &self,
        pass: &mut RenderPass<'_>,
        records: Option<&BindGroup>,
        poses: &BindGroup,
        layers: Layers,
    ) {
        if layers.waits {
            pass.set_bind_group(1, poses, &[]);
            self.arrows.draw(pass);
        }
        if let Some(records) = records {
            pass.set_bind_group(1, records, &[]);
            self.goals.draw(pass);
        }
    }
}

/// The indices of an edge's curves that the world has.
fn curves_of(world: &World<'_>, edge: &EdgeRecord) -> Range<u32> {
    let end = edge.first_curve.saturating_add(world.curves(edge).len() as u32);
    edge.first_curve..end.min(world.all_curves().len() as u32)
}
