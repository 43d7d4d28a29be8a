//! A model fleet that carries orders out, whose robots break down and are repaired again and again.

use std::sync::Arc;

use regatta_plugin::frame::{Columns, RobotState};
use regatta_plugin::world::WorldData;

use super::body::{Body, Outlines};
use super::{Random, Seen, TICK_SECS, places};
use crate::manager::Manager;
use crate::planner::PlannerKind;
use crate::roads::{Leg, Roads};
use regatta_orders::{Load, OrderPool, Places};

/// A fleet under a manager.
pub struct Managed {
    pub manager: Manager,
    roads: Arc<Roads>,
    outlines: Outlines,
    bodies: Vec<Body>,
    /// By robot: ticks until it is repaired.
    broken: Vec<u32>,
    random: Random,
    tick: u32,
}

impl Managed {
    /// Puts robots anywhere in a world, under a load.
    pub fn new(
        world: &WorldData,
        robots: usize,
        seed: u64,
        load: &str,
        planner: PlannerKind,
    ) -> Self {
        let view = world.view(1, 1);
        let roads = Arc::new(Roads::new(&view));
        let known = Arc::new(Places::of(&view));
        let mut orders = OrderPool::new(known.clone());
        orders.add_load(&Load::parse(load, &known).expect("a load"));
        let (planner, settings) = planner.planner(&roads, robots, None);
        let outlines = Outlines::new(&view);
        let starts = places(world, robots, seed);
        Self {
            manager: Manager::new(roads.clone(), planner, settings, orders),
            roads,
            bodies: starts
                .into_iter()
                .map(|(leg, place)| Body::new(&outlines, leg, place))
                .collect(),
            outlines,
            broken: vec![0; robots],
            random: Random(seed),
            tick: 0,
        }
    }

    /// The ids of the edges that robots are on.
    pub fn edges(&self) -> Vec<u32> {
        let seen = self.bodies.iter().map(|body| body.seen(&self.outlines, &self.roads));
        seen.map(|seen| seen.edge.map_or(u32::MAX, |edge| self.roads.edge(edge).id)).collect()
    }

    /// Puts a robot to the end of an edge, as a person may do that drives it.
    pub fn put(&mut self, robot: usize, edge: u32) {
        let leg = Leg::new(edge, false);
        self.bodies[robot] = Body::new(&self.outlines, leg, self.roads.edge(edge).length);
    }

    /// Takes the robots with the highest ids away, and their rows of frames.
    pub fn keep(&mut self, robots: usize) {
        self.bodies.truncate(robots);
        self.broken.truncate(robots);
    }

    /// Drives for some ticks. Of a million robots, `breakdowns` break down in a tick, and are
    /// repaired after `repair` ticks.
    pub fn run(&mut self, ticks: u32, breakdowns: u32, repair: u32) {
        for _ in 0..ticks {
            for broken in &mut self.broken {
                let breaks = self.random.below(1_000_000) < breakdowns;
                *broken = if *broken == 0 && breaks { repair } else { broken.saturating_sub(1) };
            }
            self.cycle();
            self.tick += 1;
        }
    }

    fn cycle(&mut self) {
        let seen: Vec<Seen> =
            self.bodies.iter().map(|body| body.seen(&self.outlines, &self.roads)).collect();
        let column = |value: fn(&Seen) -> f32| seen.iter().map(value).collect::<Vec<f32>>();
        let (x, y) = (column(|seen| seen.position.x), column(|seen| seen.position.y));
        let (s, moving) = (column(|seen| seen.s), column(|seen| seen.speed));
        let speed: Vec<f32> = moving
            .iter()
            .zip(&self.broken)
            .map(|(v, left)| if *left > 0 { 0.0 } else { *v })
            .collect();
        let edge: Vec<u32> = seen.iter().filter_map(|seen| seen.edge).collect();
        let state =
            |left: &u32| if *left > 0 { RobotState::Broken } else { RobotState::Idle } as u8;
        let state: Vec<u8> = self.broken.iter().map(state).collect();
        let columns =
            Columns { x: &x, y: &y, theta: &x, speed: &speed, s: &s, edge: &edge, state: &state };
        for command in
            self.manager.cycle(f64::from(self.tick) * f64::from(TICK_SECS), &columns, &[], &[])
        {
            self.bodies[command.robot() as usize].obey(command, &self.roads);
        }
        for (body, _) in self.bodies.iter_mut().zip(&self.broken).filter(|(_, left)| **left == 0) {
            body.drive(&self.outlines, &self.roads, 1.0);
        }
    }
}
