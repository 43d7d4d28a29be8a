//! The passes of a picture, in order.

use glam::{UVec2, Vec2};
use regatta_scene::{Item, Layers, Scene};
use wgpu::{BindGroup, CommandEncoder, RenderPass, TextureView};

use super::{Picture, Renderer};
use crate::attachments::Attachments;
use crate::copy::Source;
use crate::pick::Pick;
use crate::pipeline::Output;

impl Renderer {
    /// Records the commands that draw a picture into `target`.
    pub fn draw(
        &mut self,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        picture: &Picture<'_>,
    ) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        self.floor.prepare(&self.gpu, Vec2::new(view.origin.z, view.origin.w));
        self.drawn = Some((view, picture.scene.layers));
        self.fit_attachments(picture.within.map_or(picture.size, |(_, target)| target));
        self.marks.select(&self.gpu, picture.scene.marked);
        self.robots.set_variant(self.variant(&view, picture.scene));
        let ground = self.ground_copy.source(&self.gpu, &view, picture.scene.layers, picture.size);
        self.sort(encoder, picture, ground);
        let (poses, robots) = (self.columns.group(&self.gpu), view.robots);
        let timer = self.timer.as_ref().filter(|timer| timer.is_free());
        if ground == Source::DrawnToKeep
            && let Some(mut pass) = self.ground_copy.begin_pass(encoder, &view)
        {
            pass.set_bind_group(0, &self.view_group, &[]);
            self.draw_ground(&mut pass, picture);
        }
        let Some(attachments) = &self.attachments else { return };
        let mut pass = attachments.begin_pass(encoder, target, view.sky, timer);
        if let Some((at, _)) = picture.within {
            let (at, size) = (at.as_vec2(), picture.size.as_vec2());
            pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
        }
        if ground != Source::Drawn {
            self.ground_copy.draw(&mut pass);
        }
        pass.set_bind_group(0, &self.view_group, &[]);
        if ground == Source::Drawn {
            self.draw_ground(&mut pass, picture);
        }
        let (records, layers) = (self.graph.records(), picture.scene.layers);
        self.marks.draw_on_graph(&mut pass, records, layers);
        self.draw_robots(&mut pass, picture, &poses, robots);
        self.marks.draw_over_robots(&mut pass, records, &poses, layers);
        drop(pass);
        if let Some(timer) = timer {
            timer.finish(encoder);
        }
    }

    /// Sorts the robots, edges and nodes in sight into draw lists, on the GPU. A kept ground keeps
    /// the lists of the last picture.
    fn sort(&mut self, encoder: &mut CommandEncoder, picture: &Picture<'_>, ground: Source) {
        let Scene { layers, heat, theme, .. } = picture.scene;
        let (view, size) = (&self.view_group, picture.size);
        let timer = self.timer.as_ref().filter(|timer| timer.is_free());
        self.robots.sort(&self.gpu, encoder, size, view, &mut self.columns, timer);
        self.highlights.update(&self.gpu, encoder, view, &mut self.columns, picture.scene);
        if ground == Source::Kept {
            return;
        }
        if layers.edges || layers.arrows || layers.nodes {
            self.graph.sort(encoder, view);
        }
        if let Some(records) = self.graph.records().filter(|_| heat.is_some()) {
            self.heat.sort(&self.gpu, encoder, (view, records), size, *theme);
        }
    }

    /// Draws the floor, the walls, the graph and the heat map.
    fn draw_ground(&self, pass: &mut RenderPass<'_>, picture: &Picture<'_>) {
        let layers = picture.scene.layers;
        self.floor.draw(pass);
        self.marks.draw_under_graph(pass, layers);
        self.graph.draw(pass, Layers { arrows: false, nodes: false, ..layers });
        if let Some(records) = self.graph.records().filter(|_| picture.scene.heat.is_some()) {
            self.heat.draw(pass, records);
        }
        self.graph.draw(pass, Layers { edges: false, ..layers });
    }

    /// Draws the robots with their trails and halos, or their density.
    fn draw_robots(
        &self,
        pass: &mut RenderPass<'_>,
        picture: &Picture<'_>,
        poses: &BindGroup,
        robots: u32,
    ) {
        let layers = picture.scene.layers;
        if layers.trails {
            self.highlights.draw_trails(pass, poses, robots, picture.scene.trails);
        }
        self.highlights.draw_halos(pass, poses);
        if !layers.robots {
            return;
        }
        self.robots.draw_density(pass);
        if layers.shadows && !picture.camera.is_plan() {
            self.robots.draw_shadows(pass);
        }
        self.robots.draw(pass, Output::Colours);
    }

    /// Appends a point to each trail without drawing. [`draw`](Self::draw) appends points too.
    pub fn collect_trails(&mut self, picture: &Picture<'_>) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.encoder();
        let (group, columns) = (&self.view_group, &mut self.columns);
        self.highlights.update(&self.gpu, &mut encoder, group, columns, picture.scene);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Width and height of the last picture in pixels.
    pub fn drawn_size(&self) -> Vec2 {
        self.drawn.map_or(Vec2::ONE, |(view, _)| Vec2::new(view.viewport.x, view.viewport.y))
    }

    /// Returns the item that the last picture shows at a pixel, counted from its top left. Waits
    /// for the GPU.
    pub fn pick(&self, pixel: Vec2) -> Option<Item> {
        let (mut view, layers) = self.drawn?;
        view.crop = Pick::crop(pixel, Vec2::new(view.viewport.x, view.viewport.y));
        self.gpu.queue.write_buffer(&self.pick_view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.encoder();
        let mut pass = self.pick.begin_pass(&mut encoder);
        pass.set_bind_group(0, &self.pick_group, &[]);
        self.graph.draw_ids(&mut pass, layers);
        if layers.robots {
            self.robots.draw(&mut pass, Output::Ids);
        }
        drop(pass);
        self.pick.read(&self.gpu, encoder)
    }

    fn fit_attachments(&mut self, size: UVec2) {
        if self.attachments.as_ref().is_none_or(|attachments| attachments.size() != size) {
            self.attachments = Some(Attachments::new(&self.gpu, self.target, size));
        }
    }
}
