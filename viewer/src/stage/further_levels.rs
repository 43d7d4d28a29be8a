//! The levels that are shown beside the scene's, each drawn by a renderer of its own.

use std::iter;

use glam::UVec2;
use regatta_gpu::renderer::{Picture, Renderer};
use regatta_interface::orders::OpenOrders;
use regatta_interface::robot_filter::{Filter, FilterColumns, Matches, RobotSet};
use regatta_scene::camera::Camera;
use wgpu::{CommandEncoder, TextureView};

use super::Stage;

/// A level that is shown beside the scene's.
#[derive(Debug)]
pub(super) struct LevelView {
    level: String,
    renderer: Renderer,
}

/// The renderers of all levels that are shown.
pub(super) fn all<'a>(
    shown: &'a mut Renderer,
    further: &'a mut [LevelView],
) -> impl Iterator<Item = &'a mut Renderer> {
    iter::once(shown).chain(further.iter_mut().map(|view| &mut view.renderer))
}

fn set_matches(renderer: &mut Renderer, matches: &Matches) {
    renderer.set_matches(matches.matching.as_ref().map(RobotSet::words));
    renderer.set_on_level(matches.on_level.as_ref().map(RobotSet::words));
}

impl Stage {
    /// All renderers: of the scene's level, and of those beside it.
    pub fn renderers(&mut self) -> impl Iterator<Item = &mut Renderer> {
        all(&mut self.renderer, &mut self.further_levels)
    }

    /// Shows these levels beside the scene's, and no others. `create` makes the renderer of one
    /// that isn't shown yet. Call this after [`apply`](Stage::apply). Returns whether there are new
    /// renderers.
    pub fn show_beside(&mut self, levels: &[&str], create: impl Fn() -> Renderer) -> bool {
        self.further_levels.retain(|view| levels.contains(&view.level.as_str()));
        let is_shown =
            |views: &[LevelView], level: &str| views.iter().any(|view| view.level == level);
        let new: Vec<_> =
            levels.iter().filter(|level| !is_shown(&self.further_levels, level)).collect();
        for level in &new {
            let mut renderer = create();
            self.fill(&mut renderer, level);
            self.further_levels.push(LevelView { level: (**level).to_string(), renderer });
            // The columns are uploaded again, to this renderer too.
            self.watched = None;
        }
        let is_new = !new.is_empty();
        if is_new {
            self.update_routes();
        }
        is_new
    }

    /// Uploads the data of the other renderers to a new one.
    fn fill(&self, renderer: &mut Renderer, level: &str) {
        renderer.set_level(Some(level));
        let Some(world) = self.feed.world() else { return };
        renderer.set_world(&world);
        renderer.set_closed(&world, &self.closed.1);
        let tick = self.feed.frame().map_or(0, |frame| frame.tick());
        renderer.set_facilities(&world, self.feed.facilities(), tick);
        renderer.set_heat(self.heat.as_ref());
        renderer.set_plans(&self.plans);
        // A world comes before its first frame.
        let Some(frame) = self.frame() else { return };
        // Twice, so that robots don't glide from nowhere.
        for _ in 0..2 {
            renderer.push_frame(&frame);
        }
        if let Some(types) = self.feed.robot_type() {
            renderer.set_robot_type_column(types);
        }
        let filter = Filter::default().of_level(Some(level));
        set_matches(
            renderer,
            &filter.matches(&frame, &world, FilterColumns::default(), &OpenOrders::default()),
        );
    }

    /// Sets the robots of the scene's level that are shown, and those of them that are not dimmed.
    pub fn set_matches(&mut self, matches: &Matches) {
        set_matches(&mut self.renderer, matches);
    }

    /// Sets the robots of a level as [`set_matches`](Self::set_matches). Returns false if it isn't
    /// shown beside the scene's.
    pub fn set_matches_beside(&mut self, level: &str, matches: &Matches) -> bool {
        let Some(view) = self.further_levels.iter_mut().find(|view| view.level == level) else {
            return false;
        };
        set_matches(&mut view.renderer, matches);
        true
    }

    /// Shows the scene's level. Returns whether it was shown beside the previous one. In that case
    /// its graph is uploaded already, and both swap places.
    pub(super) fn change_level(&mut self) -> bool {
        let before = std::mem::replace(&mut self.level, self.scene.level.clone());
        let wanted =
            self.further_levels.iter_mut().find(|view| Some(&view.level) == self.level.as_ref());
        let (Some(view), Some(before)) = (wanted, before) else {
            self.renderer.set_level(self.level.as_deref());
            return false;
        };
        std::mem::swap(&mut view.renderer, &mut self.renderer);
        view.level = before;
        true
    }

    /// Draws a level that is shown beside the scene's.
    pub fn draw_beside(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        level: &str,
        camera: &Camera,
        size: UVec2,
        alpha: f32,
    ) {
        let legend = self.legend();
        let picture =
            Picture { camera, scene: &self.scene, legend: &legend, size, within: None, alpha };
        if let Some(view) = self.further_levels.iter_mut().find(|view| view.level == level) {
            view.renderer.draw(encoder, target, &picture);
        }
    }
}
