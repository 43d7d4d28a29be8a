//! A fleet on stage: what comes from the feed goes to the renderer, and the camera knows what there is to see.

use std::time::Instant;

use glam::{UVec2, Vec2};
use regatta_plugin::route::RouteResponse;
use regatta_plugin::world::EdgeRecord;
use regatta_plugin::{Frame, Participant, Result, World};
use wgpu::{CommandEncoder, TextureView};

use crate::camera::{Bounds, Camera};
use crate::feed::{Feed, News, Playhead};
use crate::gpu::frame::{Picture, Renderer};
use crate::palette::{Colouring, Legend};
use crate::route::{self, Remaining};
use crate::scene::Scene;

/// Rows that are looked at to learn the range of a column's values.
const SAMPLED_ROWS: usize = 1_024;
/// Frames between two looks.
const SAMPLE_EVERY: u64 = 16;
/// Frames between two looks where the robots are, of a fleet without a graph.
const LOOK_EVERY: u64 = 64;

/// Feed, renderer and what goes between them.
#[derive(Debug)]
pub struct Stage {
    /// What is read.
    pub feed: Feed,
    /// What draws it.
    pub renderer: Renderer,
    /// What is to be seen.
    pub scene: Scene,
    playhead: Playhead,
    /// Of the graph.
    bounds: Option<Bounds>,
    /// Of a fleet without one.
    bounds_of_robots: Option<Bounds>,
    /// In which run they were looked at.
    bounds_of: u64,
    types: Vec<String>,
    range: Option<(f32, f32)>,
    watched: Option<Colouring>,
    routes: Vec<RouteResponse>,
    /// Of those routes in the newest frame, by robot.
    remaining: Vec<(u32, Remaining)>,
}

impl Stage {
    /// Opens a fleet for a renderer.
    ///
    /// # Errors
    /// As [`Feed::open`].
    pub fn new(participant: &Participant, renderer: Renderer, scene: Scene) -> Result<Self> {
        Ok(Self {
            feed: Feed::open(participant)?,
            renderer,
            scene,
            playhead: Playhead::new(),
            bounds: None,
            bounds_of_robots: None,
            bounds_of: 0,
            types: Vec::new(),
            range: None,
            watched: None,
            routes: Vec::new(),
            remaining: Vec::new(),
        })
    }

    /// Takes what is newest to the GPU. Called once for each picture.
    ///
    /// # Errors
    /// If shared memory can't be read.
    pub fn update(&mut self, now: Instant) -> Result<News> {
        let news = self.feed.poll()?;
        self.apply(news, now)?;
        Ok(news)
    }

    /// Takes what a poll of the feed found new to the GPU.
    ///
    /// # Errors
    /// If a column can't be opened.
    pub fn apply(&mut self, news: News, now: Instant) -> Result {
        let recoloured = self.watched.as_ref() != Some(&self.scene.colouring);
        if recoloured {
            let column = if let Colouring::Column(name) = &self.scene.colouring { Some(name) } else { None };
            self.feed.watch(column)?;
            self.watched = Some(self.scene.colouring.clone());
            self.range = None;
            self.renderer.set_values(None);
        }
        if news.world
            && let Some(world) = self.feed.world()
        {
            self.bounds = bounds_of(&world);
            self.types = world.robot_types().iter().map(|kind| kind.name().to_owned()).collect();
            self.renderer.set_world(&world);
        }
        if let Some(frame) = self.feed.frame().filter(|_| news.frame) {
            self.playhead.push(&frame, now);
            self.renderer.push_frame(&frame);
        }
        if news.world || (news.frame && !self.routes.is_empty()) {
            self.update_routes();
        }
        self.update_values(news, recoloured);
        Ok(())
    }

    /// Takes robots' routes, in place of those before. They are drawn, from where the robots are.
    pub fn set_routes(&mut self, routes: Vec<RouteResponse>) {
        self.routes = routes;
        self.update_routes();
    }

    /// What a robot has still to drive, if its route is known.
    pub fn remaining(&self, robot: u32) -> Option<Remaining> {
        self.remaining.iter().find(|(known, _)| *known == robot).map(|(_, remaining)| *remaining)
    }

    fn update_routes(&mut self) {
        self.remaining.clear();
        let mut all = Vec::new();
        if let (Some(frame), Some(world)) = (self.feed.frame(), self.feed.world()) {
            for answer in self.routes.iter().filter(|answer| answer.is_found()) {
                let (stretches, remaining) = route::ahead(answer, &frame, world.edges());
                all.extend(stretches);
                self.remaining.push((answer.robot, remaining));
            }
        }
        self.renderer.set_routes(&all);
    }

    fn update_values(&mut self, news: News, recoloured: bool) {
        if (news.kinds || news.frame)
            && let Some(kinds) = self.feed.kinds()
        {
            // After a frame too: its buffers may be new ones.
            if news.kinds || self.renderer.lacks_kinds() {
                self.renderer.set_kinds(kinds);
            }
        }
        let frame = self.feed.frame();
        if news.frame && self.bounds.is_none() {
            let look = self.bounds_of_robots.is_none() || self.feed.counts().read.is_multiple_of(LOOK_EVERY);
            if let Some(frame) = frame.as_ref().filter(|_| look) {
                // It only grows, and by leaps: the picture is not to slide under the robots.
                let (run, known) = (frame.run_id(), self.bounds_of_robots.take());
                let known = known.filter(|_| self.bounds_of == run);
                let around = bounds_of_robots(frame);
                self.bounds_of = run;
                self.bounds_of_robots = match (known, around) {
                    (Some(known), Some(around)) if known.holds(around) => Some(known),
                    (known, around) => around.map(|around| known.map_or(around, |known| known.with(around)).wider()),
                };
            }
        }
        let values = match &self.scene.colouring {
            Colouring::Speed if news.frame || recoloured => Some(frame.map(|frame| frame.speed())),
            // After a frame its buffers may be new ones.
            Colouring::Column(_) if news.value || recoloured || (news.frame && self.renderer.lacks_values()) => {
                Some(self.feed.value())
            }
            _ => None,
        };
        if let Some(values) = values {
            let look = self.range.is_none() || self.feed.counts().read.is_multiple_of(SAMPLE_EVERY);
            if let Some(values) = values.filter(|_| look) {
                self.range = widened(self.range, values);
            }
            self.renderer.set_values(values);
        }
    }

    /// What the robots' colours mean now.
    pub fn legend(&self) -> Legend {
        let (theme, colouring) = (self.scene.theme, &self.scene.colouring);
        let legend = colouring.legend(theme, &self.types, self.range);
        match colouring {
            Colouring::Column(_) if self.feed.value().is_none() => legend.of_nothing(theme),
            _ => legend,
        }
    }

    /// Where there is something to see: the graph, or else the robots of the newest frame.
    pub fn bounds(&self) -> Bounds {
        let bounds = self.bounds.or(self.bounds_of_robots).unwrap_or_default();
        Bounds { low: bounds.low + self.scene.offset, high: bounds.high + self.scene.offset }
    }

    /// How far from the frame before (0) to the newest (1) the moment to show is.
    pub fn alpha(&self, now: Instant) -> f32 {
        self.playhead.alpha(now)
    }

    /// Takes a point of the trails when nothing is drawn.
    pub fn collect_trails(&mut self) {
        let legend = self.legend();
        let (camera, size) = (&Camera::default(), UVec2::ONE);
        let picture = Picture { camera, scene: &self.scene, legend: &legend, size, within: None, alpha: 1.0 };
        self.renderer.collect_trails(&picture);
    }

    /// Draws the fleet as it is at the moment to show.
    pub fn draw(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        camera: &Camera,
        size: UVec2,
        alpha: f32,
    ) {
        self.draw_within(encoder, target, None, camera, size, alpha);
    }

    /// The same as a part of a larger target: `within` says where, and how large that is.
    pub fn draw_within(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        within: Option<(UVec2, UVec2)>,
        camera: &Camera,
        size: UVec2,
        alpha: f32,
    ) {
        let legend = self.legend();
        let picture = Picture { camera, scene: &self.scene, legend: &legend, size, within, alpha };
        self.renderer.draw(encoder, target, &picture);
    }
}

fn bounds_of(world: &World<'_>) -> Option<Bounds> {
    let along = |edge: &EdgeRecord| {
        let [a, b, c, d] = edge.control_points.map(Vec2::from);
        [0.0, 0.25, 0.5, 0.75, 1.0].map(|at: f32| {
            let ends = [a.lerp(b, at), b.lerp(c, at), c.lerp(d, at)];
            ends[0].lerp(ends[1], at).lerp(ends[1].lerp(ends[2], at), at)
        })
    };
    Bounds::around(world.edges().iter().flat_map(along))
        .or_else(|| Bounds::around(world.nodes().iter().map(|node| Vec2::new(node.x, node.y))))
}

fn bounds_of_robots(frame: &Frame<'_>) -> Option<Bounds> {
    Bounds::around(frame.x().iter().zip(frame.y()).map(|(x, y)| Vec2::new(*x, *y)))
}

/// The range with some of the values in it, rounded outwards so that it seldom changes.
fn widened(range: Option<(f32, f32)>, values: &[f32]) -> Option<(f32, f32)> {
    let step = values.len().div_ceil(SAMPLED_ROWS).max(1);
    let finite = values.iter().step_by(step).copied().filter(|value| value.is_finite());
    let known = range.into_iter().flat_map(|(low, high)| [low, high]);
    let (low, high) = known
        .chain(finite)
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return None;
    }
    let unit = 10_f32.powf((high - low).max(1e-3).log10().floor()) * 0.5;
    Some(((low / unit).floor() * unit, (high / unit).ceil() * unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_values_and_are_round() {
        assert_eq!(widened(None, &[]), None);
        assert_eq!(widened(None, &[f32::NAN]), None);
        let range = widened(None, &[0.13, 1.37]).unwrap();
        assert!((range.0 - 0.0).abs() < 1e-6 && (range.1 - 1.5).abs() < 1e-6, "{range:?}");
        assert_eq!(widened(Some(range), &[1.0]), Some(range), "nothing beyond it");
    }
}
