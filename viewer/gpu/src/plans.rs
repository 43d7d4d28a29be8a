//! The marks of plans: goals of robots, and arrows from robots that wait to those that they wait
//! for.

use regatta_scene::plans::{GoalMark, WaitArrow};
use wgpu::{
    BindGroup, BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline, VertexAttribute,
    VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::columns::Columns;
use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::shaders::shader;

/// The attributes of a [`GoalMark`].
const GOAL: [VertexAttribute; 2] = vertex_attr_array![0 => Uint32, 1 => Uint32];
/// The attributes of a [`WaitArrow`].
const ARROW: [VertexAttribute; 3] = vertex_attr_array![0 => Uint32, 1 => Uint32, 2 => Uint32];

/// Draws the marks.
#[derive(Debug)]
pub struct PlanMarks {
    goal: RenderPipeline,
    arrow: RenderPipeline,
    goals: Instances<GoalMark>,
    arrows: Instances<WaitArrow>,
}

impl PlanMarks {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
        columns: &Columns,
    ) -> Self {
        let quad = |module: &str,
                    groups: &[&BindGroupLayout],
                    stride: usize,
                    attributes: &[VertexAttribute]| {
            let instance = VertexBufferLayout {
                array_stride: stride as u64,
                step_mode: VertexStepMode::Instance,
                attributes,
            };
            let descriptor = PipelineDescriptor {
                module: &shader(gpu, module),
                vertex: "mark",
                fragment: "mark_fill",
                groups,
                buffers: &[instance],
                topology: PrimitiveTopology::TriangleStrip,
                depth: DepthMode::Ignored,
                blend: true,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        Self {
            goal: quad("goals", &[view, records], size_of::<GoalMark>(), &GOAL),
            arrow: quad("waits", &[view, columns.layout()], size_of::<WaitArrow>(), &ARROW),
            goals: Instances::new(gpu, "goals"),
            arrows: Instances::new(gpu, "wait arrows"),
        }
    }

    /// Replaces the goals.
    pub fn set_goals(&mut self, gpu: &Gpu, goals: &[GoalMark]) {
        self.goals.set(gpu, goals);
    }

    /// Replaces the arrows.
    pub fn set_arrows(&mut self, gpu: &Gpu, arrows: &[WaitArrow]) {
        self.arrows.set(gpu, arrows);
    }

    /// Draws the goals over the robots, and with `waits` the arrows.
    pub fn draw(
        &self,
        pass: &mut RenderPass<'_>,
        records: Option<&BindGroup>,
        poses: &BindGroup,
        waits: bool,
    ) {
        if waits && self.arrows.count() > 0 {
            pass.set_pipeline(&self.arrow);
            pass.set_bind_group(1, poses, &[]);
            self.arrows.draw(pass, 4);
        }
        if let Some(records) = records.filter(|_| self.goals.count() > 0) {
            pass.set_pipeline(&self.goal);
            pass.set_bind_group(1, records, &[]);
            self.goals.draw(pass, 4);
        }
    }
}
