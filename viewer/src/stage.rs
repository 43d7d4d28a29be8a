//! The stage passes new data from the feed to the renderer, and derives bounds, legend and routes
//! from it.

mod bounds;
mod columns;
mod further_levels;

use std::time::Instant;

use glam::UVec2;
use regatta_gpu::renderer::{Picture, Renderer};
use regatta_interface::banner::Banner;
use regatta_interface::jams::JamFacts;
use regatta_interface::orders::OpenOrders;
use regatta_interface::robot_filter::{Filter, FilterColumns, RobotSet};
use regatta_interface::view_model::{Live, Timeline};
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::frame::ClockState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{Frame, Participant, Result, World};
use regatta_scene::Scene;
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::heat::HeatMap;
use regatta_scene::palette::{Colouring, Legend, Theme};
use regatta_scene::plans::{PlanFacts, PlanReport};
use regatta_scene::route::{Remaining, remaining_route};
use wgpu::{CommandEncoder, TextureView};

use crate::caption::Annotations;
use crate::feed::{Feed, News};
use crate::frame_history::FrameHistory;
use crate::jams::{self, JamQuery, JamReport};
use crate::plans::PlanQuery;
use crate::playhead::Playhead;
use crate::svg;
use bounds::bounds_of_graph;
use further_levels::{LevelView, all};

/// A feed and the renderer that draws it.
#[derive(Debug)]
pub struct Stage {
    /// The fleet's data.
    pub feed: Feed,
    /// The renderer.
    pub renderer: Renderer,
    /// The levels beside the one that the renderer shows.
    further_levels: Vec<LevelView>,
    /// The content and the style of pictures. [`apply`](Self::apply) sets its colouring.
    pub scene: Scene,
    /// The data that robots are coloured by; `None` for their activities if they are published,
    /// else collisions if these are, else states.
    pub colouring: Option<Colouring>,
    /// The last minutes of a live run; `None` if they aren't kept.
    pub history: Option<FrameHistory>,
    /// The run and the simulated time that are shown instead of the newest frame, in nanoseconds.
    looking_back: Option<(u64, u64)>,
    playhead: Playhead,
    graph_bounds: Option<Bounds>,
    /// The robots' bounds, of a fleet without a graph.
    robot_bounds: Option<Bounds>,
    /// The run of `robot_bounds`.
    robot_bounds_run: u64,
    /// Names of the robot types.
    robot_types: Vec<String>,
    /// The range of the values that robots are coloured by.
    range: Option<(f32, f32)>,
    /// The colouring whose column the feed watches.
    watched: Option<Colouring>,
    /// The level that the renderer shows.
    level: Option<String>,
    /// The run whose closed edges are drawn, and their indices, sorted.
    closed: (u64, Vec<u32>),
    routes: Vec<RouteResponse>,
    /// The rest of each route in the newest frame, by robot.
    remaining: Vec<(u32, Remaining)>,
    plans: PlanReport,
    heat: Option<HeatMap>,
    jam_facts: JamFacts,
}

impl Stage {
    /// Opens a fleet, to be drawn by a renderer.
    ///
    /// # Errors
    /// As [`Feed::open`].
    pub fn new(participant: &Participant, renderer: Renderer, scene: Scene) -> Result<Self> {
        Ok(Self {
            feed: Feed::open(participant)?,
            renderer,
            further_levels: Vec::new(),
            colouring: Some(scene.colouring.clone()),
            scene,
            history: None,
            looking_back: None,
            playhead: Playhead::new(),
            graph_bounds: None,
            robot_bounds: None,
            robot_bounds_run: 0,
            robot_types: Vec::new(),
            range: None,
            watched: None,
            level: None,
            closed: (0, Vec::new()),
            routes: Vec::new(),
            remaining: Vec::new(),
            plans: PlanReport::default(),
            heat: None,
            jam_facts: JamFacts::default(),
        })
    }

    /// Uploads the newest data. Call this once for each picture.
    ///
    /// # Errors
    /// If shared memory can't be read.
    pub fn update(&mut self, now: Instant) -> Result<News> {
        let news = self.feed.poll()?;
        self.apply(news, now)?;
        Ok(news)
    }

    /// Uploads the data that a poll of the feed found new.
    ///
    /// # Errors
    /// If a column can't be opened.
    pub fn apply(&mut self, news: News, now: Instant) -> Result {
        let is_recoloured = self.update_colouring()?;
        let is_other_level = self.level != self.scene.level;
        let has_graph = !is_other_level || self.change_level();
        if (news.world || !has_graph)
            && let Some(world) = self.feed.world()
        {
            self.graph_bounds = bounds_of_graph(&world, None);
            self.robot_types =
                world.robot_types().iter().map(|robot_type| robot_type.name().to_owned()).collect();
            for renderer in all(&mut self.renderer, &mut self.further_levels) {
                renderer.set_world(&world);
            }
        }
        self.update_closed(news, !has_graph);
        self.update_facilities(news, !has_graph);
        if let Some(frame) = self.feed.frame().filter(|_| news.frame) {
            let is_live = self.feed.recording().is_none();
            if let Some(history) = self.history.as_mut().filter(|_| is_live) {
                history.take(&frame, self.feed.activity());
            }
            self.looking_back = self.looking_back.filter(|(run, _)| *run == frame.run_id());
            self.playhead.push(&frame, now);
            if self.feed.recording().is_some() && frame.header().clock == ClockState::Paused as u32
            {
                self.playhead.arrive();
            }
            if self.looking_back.is_none() {
                for renderer in all(&mut self.renderer, &mut self.further_levels) {
                    renderer.push_frame(&frame);
                }
            }
        }
        if news.world || (news.frame && !self.routes.is_empty()) {
            self.update_routes();
        }
        self.update_columns(news, is_recoloured);
        Ok(())
    }

    /// The frame that is shown: the newest one, or one of the past.
    pub fn frame(&self) -> Option<Frame<'_>> {
        match (self.looking_back, &self.history) {
            (Some((_, time)), Some(history)) => history.at(time),
            _ => self.feed.frame(),
        }
    }

    /// The activities of the robots of that frame, if a fleet manager publishes them, or has.
    pub fn activities(&self) -> Option<&[f32]> {
        match (self.looking_back, &self.history) {
            (Some((_, time)), Some(history)) => history.activities_at(time),
            _ => self.feed.activity(),
        }
    }

    /// The values of the column by which robots are coloured, if they are known. Of the past, only
    /// activities are.
    fn colouring_values(&self) -> Option<&[f32]> {
        match self.is_looking_back() {
            true => self.activities().filter(|_| self.watched == Some(Colouring::activity())),
            false => self.feed.value(),
        }
    }

    /// The recording that is shown, or the part of a live run that is kept.
    pub fn timeline(&self) -> Option<Timeline<'_>> {
        let frame = self.frame()?;
        let Some(recording) = self.feed.recording() else { return self.live_timeline(&frame) };
        let header = recording.header;
        Some(Timeline {
            name: header.file(),
            note: header.note(),
            start: header.start_nanos,
            end: header.end_nanos,
            now: (frame.run_id() == header.run_id)
                .then(|| header.time_of(frame.header().sim_time_nanos)),
            searched: header.searched_nanos,
            left_out: header.left_out,
            marks: recording.marks,
            live: None,
        })
    }

    fn live_timeline(&self, frame: &Frame<'_>) -> Option<Timeline<'_>> {
        let history = self.history.as_ref()?;
        let (start, end) = history.span()?;
        Some(Timeline {
            name: "live",
            note: "",
            start,
            end,
            now: Some(frame.header().sim_time_nanos),
            searched: u64::MAX,
            left_out: 0,
            marks: &[],
            live: Some(Live { bytes: history.bytes(), is_past: self.is_looking_back() }),
        })
    }

    /// Whether a frame of the past is shown.
    pub fn is_looking_back(&self) -> bool {
        self.looking_back.is_some()
    }

    /// Shows a live run at a past simulated time in nanoseconds, or again at the current time. Only
    /// frames and activities of the past are kept, so robots have no values of other columns then.
    pub fn look_back(&mut self, time: Option<u64>) {
        let run = self.feed.frame().map(|frame| frame.run_id());
        self.looking_back = run.zip(time);
        // Twice, so that robots don't glide from one time to the other.
        for _ in 0..2 {
            let frame = match (self.looking_back, &self.history) {
                (Some((_, time)), Some(history)) => history.at(time),
                _ => self.feed.frame(),
            };
            if let Some(frame) = frame {
                for renderer in all(&mut self.renderer, &mut self.further_levels) {
                    renderer.push_frame(&frame);
                }
            }
        }
        // The columns are those of the newest frame, and are uploaded again when it is shown.
        for renderer in self.renderers() {
            renderer.set_values(None);
        }
        self.watched = None;
    }

    /// Replaces the routes. They are drawn from the robots' current positions on.
    pub fn set_routes(&mut self, routes: Vec<RouteResponse>) {
        self.routes = routes;
        self.update_routes();
    }

    /// The rest of a robot's route, if its route is known.
    pub fn remaining(&self, robot: u32) -> Option<Remaining> {
        self.remaining.iter().find(|(id, _)| *id == robot).map(|(_, remaining)| *remaining)
    }

    /// The query for the plans of the scene, of all robots.
    pub fn plan_query(&self) -> PlanQuery {
        let Scene { layers, selected, .. } = &self.scene;
        PlanQuery {
            plans: layers.plans,
            waits: layers.waits,
            matching: None,
            selected: selected.clone(),
        }
    }

    /// Replaces the plans.
    pub fn set_plans(&mut self, report: PlanReport) {
        self.plans = report;
        for renderer in all(&mut self.renderer, &mut self.further_levels) {
            renderer.set_plans(&self.plans);
        }
    }

    /// The counts of the plans.
    pub fn plan_facts(&self) -> PlanFacts {
        self.plans.facts
    }

    /// The query for the heat map of the scene.
    pub fn jam_query(&self) -> JamQuery {
        JamQuery { heat: self.scene.heat, ..JamQuery::default() }
    }

    /// Takes figures of jams. Returns whether they make a difference.
    pub fn set_jams(&mut self, report: JamReport) -> bool {
        let facts = &self.jam_facts;
        let is_same = report.edges == facts.edges && report.node == facts.node;
        let is_new = report.heat.is_some() || report.history.is_some() || !is_same;
        if let Some(map) = report.heat {
            self.jam_facts.heat = map.as_ref().map(|map| map.facts);
            self.jam_facts.hottest = map.as_ref().map_or_else(Vec::new, |map| map.hottest.clone());
            for renderer in all(&mut self.renderer, &mut self.further_levels) {
                renderer.set_heat(map.as_ref());
            }
            self.heat = map;
        }
        (self.jam_facts.edges, self.jam_facts.node) = (report.edges, report.node);
        if let Some(history) = report.history {
            (self.jam_facts.spots, self.jam_facts.series, self.jam_facts.known) =
                jams::moved(history, self.feed.ahead_secs());
        }
        is_new
    }

    /// Returns the density of half the strength, in robots per hectare, if robots are drawn as
    /// their density.
    pub fn shown_density(&self, camera: &Camera, size: UVec2) -> Option<f32> {
        let legend = self.legend();
        let picture =
            Picture { camera, scene: &self.scene, legend: &legend, size, within: None, alpha: 1.0 };
        self.renderer.shown_density(&picture)
    }

    /// The figures of jams.
    pub fn jam_facts(&self) -> &JamFacts {
        &self.jam_facts
    }

    /// The indices of the closed edges, sorted.
    pub fn closed(&self) -> &[u32] {
        &self.closed.1
    }

    fn update_closed(&mut self, news: News, is_other_graph: bool) {
        let run = self.feed.frame().map_or(0, |frame| frame.run_id());
        if !(news.closures || news.world || is_other_graph || run != self.closed.0) {
            return;
        }
        let Some(world) = self.feed.world() else { return };
        let ids = self.feed.closed();
        let mut closed = Vec::new();
        if !ids.is_empty() {
            for (edge, index) in world.edges().iter().zip(0..) {
                if ids.binary_search(&ClosedEdge { edge: edge.id }).is_ok() {
                    closed.push(index);
                }
            }
        }
        self.closed = (run, closed);
        let closed = &self.closed.1;
        for renderer in all(&mut self.renderer, &mut self.further_levels) {
            renderer.set_closed(&world, closed);
        }
    }

    /// Draws doors and lifts anew if they have changed, or if some are in motion.
    fn update_facilities(&mut self, news: News, is_other_graph: bool) {
        let states = self.feed.facilities();
        let are_moving = states.iter().any(|state| state.ticks > 0);
        let is_new = news.facilities || news.world || is_other_graph || news.frame && are_moving;
        let (Some(world), true) = (self.feed.world(), is_new) else { return };
        let tick = self.feed.frame().map_or(0, |frame| frame.tick());
        for renderer in all(&mut self.renderer, &mut self.further_levels) {
            renderer.set_facilities(&world, states, tick);
        }
    }

    fn update_routes(&mut self) {
        self.remaining.clear();
        let mut segments = Vec::new();
        if let (Some(frame), Some(world)) = (self.feed.frame(), self.feed.world()) {
            for answer in self.routes.iter().filter(|answer| answer.is_found()) {
                let (rest, remaining) = remaining_route(answer, &frame, &world);
                segments.extend(rest);
                self.remaining.push((answer.robot, remaining));
            }
        }
        for renderer in self.renderers() {
            renderer.set_routes(&segments);
        }
    }

    /// Hides the robots that are on another level than the scene's. A window has this done by its
    /// other thread.
    pub fn hide_other_levels(&mut self) {
        let (Some(frame), Some(world), Some(_)) =
            (self.feed.frame(), self.feed.world(), &self.scene.level)
        else {
            return;
        };
        let filter = Filter::default().of_level(self.scene.level.as_deref());
        let matches =
            filter.matches(&frame, &world, FilterColumns::default(), &OpenOrders::default());
        self.renderer.set_on_level(matches.on_level.as_ref().map(RobotSet::words));
    }

    /// The current meaning of the robots' colours.
    pub fn legend(&self) -> Legend {
        let (theme, colouring) = (self.scene.theme, &self.scene.colouring);
        let legend = colouring.legend(theme, &self.robot_types, self.range);
        match colouring {
            Colouring::Column(_) if self.colouring_values().is_none() => legend.without_data(theme),
            _ => legend,
        }
    }

    /// Returns a plan of what is shown, or of the scene's level alone, as the text of an SVG file.
    /// `name` is that of the fleet or the recording; `scale` is 200 for 1:200.
    ///
    /// # Errors
    /// If there are too many robots.
    pub fn svg(&self, name: &str, theme: Theme, scale: Option<f32>) -> Result<String> {
        let (frame, world) = (self.frame(), self.feed.world().unwrap_or_default());
        let level = self.scene.level.as_deref();
        let bounds =
            bounds_of_graph(&world, level).map_or(self.bounds(), |bounds| self.moved(bounds));
        let values = match &self.scene.colouring {
            Colouring::Speed => frame.map(|frame| frame.speed()),
            _ => self.colouring_values(),
        };
        let legend = self.scene.colouring.legend(theme, &self.robot_types, self.range);
        svg::draw(&svg::Plan {
            world,
            frame,
            robot_type: self.feed.robot_type(),
            values,
            colouring: &self.scene.colouring,
            legend: &legend,
            theme,
            closed: &self.closed.1,
            facilities: self.feed.facilities(),
            level,
            bounds: Bounds { low: bounds.low - 1.0, high: bounds.high + 1.0 },
            offset: self.scene.offset,
            scale,
            name,
            seconds: frame.map_or(0.0, |frame| self.feed.clock_secs(&frame)),
        })
    }

    /// The bounds of the graph, or without a graph of the robots, with the scene's offset.
    pub fn bounds(&self) -> Bounds {
        self.moved(self.graph_bounds.or(self.robot_bounds).unwrap_or_default())
    }

    /// Adds the scene's offset to bounds.
    fn moved(&self, bounds: Bounds) -> Bounds {
        Bounds { low: bounds.low + self.scene.offset, high: bounds.high + self.scene.offset }
    }

    /// Returns the annotations of a picture by a camera that don't depend on what is asked for.
    pub(crate) fn annotations<'a>(
        &'a self,
        camera: &'a Camera,
        title: Vec<String>,
    ) -> Annotations<'a> {
        Annotations {
            camera,
            scene: &self.scene,
            legend: None,
            plan: false,
            plans: self.plan_facts(),
            title,
            frame: None,
            world: World::default(),
            heat: self.jam_facts().heat,
            hottest: &self.jam_facts().hottest,
            closed: self.closed().len() as u32,
            density: None,
            robots: Vec::new(),
            banner: Banner::default(),
        }
    }

    /// The moment to show, from the previous frame (0) to the newest (1).
    pub fn alpha(&self, now: Instant) -> f32 {
        if self.is_looking_back() { 1.0 } else { self.playhead.alpha(now) }
    }

    /// Appends a point to each trail without drawing.
    pub fn collect_trails(&mut self) {
        let legend = self.legend();
        let (camera, size) = (&Camera::default(), UVec2::ONE);
        let picture =
            Picture { camera, scene: &self.scene, legend: &legend, size, within: None, alpha: 1.0 };
        self.renderer.collect_trails(&picture);
    }

    /// Draws the fleet at a moment from the previous frame (0) to the newest (1).
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

    /// Draws the fleet into a part of a larger target: `within` is the part's top left corner and
    /// the target's size.
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
