//! The levels that are shown beside the scene's, each drawn by a renderer of its own.

use std::iter;

use glam::UVec2;
use wgpu::{CommandEncoder, TextureView};

use super::Stage;
use crate::camera::Camera;
use crate::filter::{Filter, Matches, RobotSet};
use crate::gpu::renderer::{Picture, Renderer};
use crate::tasks::TaskBook;

/// A level beside the scene's.
#[derive(Debug)]
pub(super) struct Beside {
    level: String,
    renderer: Renderer,
}

/// The renderers of all levels that are shown.
pub(super) fn all<'a>(
    shown: &'a mut Renderer,
    beside: &'a mut [Beside],
) -> impl Iterator<Item = &'a mut Renderer> {
    iter::once(shown).chain(beside.iter_mut().map(|beside| &mut beside.renderer))
}

fn set_matches(renderer: &mut Renderer, matches: &Matches) {
    renderer.set_matches(matches.matching.as_ref().map(RobotSet::words));
    renderer.set_on_level(matches.on_level.as_ref().map(RobotSet::words));
}

impl Stage {
    /// All renderers: of the scene's level, and of those beside it.
    pub fn renderers(&mut self) -> impl Iterator<Item = &mut Renderer> {
        all(&mut self.renderer, &mut self.beside)
    }

    /// Shows these levels beside the scene's, and no others. `create` makes the renderer of one
    /// that isn't shown yet. Call this after [`apply`](Stage::apply). Returns whether there are new
    /// renderers.
    pub fn show_beside(&mut self, levels: &[&str], create: impl Fn() -> Renderer) -> bool {
        self.beside.retain(|beside| levels.contains(&beside.level.as_str()));
        let is_shown =
            |beside: &[Beside], level: &str| beside.iter().any(|beside| beside.level == level);
        let new: Vec<_> = levels.iter().filter(|level| !is_shown(&self.beside, level)).collect();
        for level in &new {
            let mut renderer = create();
            self.fill(&mut renderer, level);
            self.beside.push(Beside { level: (**level).to_string(), renderer });
            // The columns are uploaded again, to this renderer too.
            self.watched = None;
        }
        let is_new = !new.is_empty();
        if is_new {
            self.update_routes();
        }
        is_new
    }

    /// Uploads to a new renderer what the others have.
    fn fill(&self, renderer: &mut Renderer, level: &str) {
        renderer.set_level(Some(level));
        let Some(world) = self.feed.world() else { return };
        renderer.set_world(&world);
        renderer.set_closed(&world, &self.closed.1);
        renderer.set_heat(self.heat.as_ref());
        renderer.set_plans(&self.plans);
        // A world comes before its first frame.
        let Some(frame) = self.frame() else { return };
        // Twice, so that robots don't glide from nowhere.
        (0..2).for_each(|_| renderer.push_frame(&frame));
        if let Some(types) = self.feed.robot_type() {
            renderer.set_robot_type_column(types);
        }
        let filter = Filter::default().of_level(Some(level));
        set_matches(renderer, &filter.matches(&frame, &world, None, &TaskBook::default()));
    }

    /// Sets the robots of the scene's level that are shown, and those of them that are not dimmed.
    pub fn set_matches(&mut self, matches: &Matches) {
        set_matches(&mut self.renderer, matches);
    }

    /// Sets the robots of a level as [`set_matches`](Self::set_matches). Returns false if it isn't
    /// shown beside the scene's.
    pub fn set_matches_beside(&mut self, level: &str, matches: &Matches) -> bool {
        let beside = self.beside.iter_mut().find(|beside| beside.level == level);
        beside.map(|beside| set_matches(&mut beside.renderer, matches)).is_some()
    }

    /// Makes the scene's level the one that is shown. Returns whether it was shown beside the one
    /// before, so that its graph is uploaded already: they change places then.
    pub(super) fn change_level(&mut self) -> bool {
        let before = std::mem::replace(&mut self.level, self.scene.level.clone());
        let wanted =
            self.beside.iter_mut().find(|beside| Some(&beside.level) == self.level.as_ref());
        let (Some(beside), Some(before)) = (wanted, before) else {
            self.renderer.set_level(self.level.as_deref());
            return false;
        };
        std::mem::swap(&mut beside.renderer, &mut self.renderer);
        beside.level = before;
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
        if let Some(beside) = self.beside.iter_mut().find(|beside| beside.level == level) {
            beside.renderer.draw(encoder, target, &picture);
        }
    }
}
