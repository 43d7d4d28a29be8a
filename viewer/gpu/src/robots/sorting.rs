//! The variants of the sorting shader.

use std::collections::BTreeMap;

use wgpu::{BindGroupLayout, ComputePipeline, ShaderModule, ShaderStages};

use crate::bindings::{Binding, bind_group_layout};
use crate::device::Gpu;
use crate::pipeline::compute_pipeline;
use crate::shaders::shader;

/// The robots that are drawn as their density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dense {
    /// None.
    #[default]
    None,
    /// Those that are small in the picture.
    Small,
    /// All: none in sight is large enough for a mark.
    All,
}

/// The decisions for all robots of a picture at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// Whether marks are splatted.
    pub splats: bool,
    /// The robots that are drawn as their density.
    pub dense: Dense,
    /// The source of the robots' colours, as in the view.
    pub source: u32,
    /// Whether robots are dimmed and hidden, as in the view.
    pub filtered: u32,
    /// Whether a robot in sight may be large enough for a block or a mesh.
    pub bodies: bool,
}

/// The sorting shader. A variant is compiled when it is first needed.
#[derive(Debug)]
pub struct Sorting {
    module: ShaderModule,
    groups: [BindGroupLayout; 3],
    pipelines: BTreeMap<Variant, ComputePipeline>,
}

impl Sorting {
    pub fn new(gpu: &Gpu, view: &BindGroupLayout, columns: &BindGroupLayout) -> Self {
        let lists = bind_group_layout(gpu, "lists", ShaderStages::COMPUTE, &[Binding::Write; 5]);
        let groups = [view.clone(), columns.clone(), lists];
        Self { module: shader(gpu, "sort"), groups, pipelines: BTreeMap::new() }
    }

    /// The layout of the group of draw lists.
    pub fn lists_layout(&self) -> &BindGroupLayout {
        &self.groups[2]
    }

    /// Returns a variant.
    pub fn pipeline(&mut self, gpu: &Gpu, variant: Variant) -> &ComputePipeline {
        let Self { module, groups, pipelines } = self;
        pipelines.entry(variant).or_insert_with(|| {
            let Variant { splats, dense, source, filtered, bodies } = variant;
            let entry = if dense == Dense::All { "add_all" } else { "sort" };
            let constants = [
                ("SPLATS", f64::from(splats)),
                ("DENSITY", f64::from(dense != Dense::None)),
                ("SOURCE", f64::from(source)),
                ("FILTERED", f64::from(filtered)),
                ("BODIES", f64::from(bodies)),
            ];
            compute_pipeline(gpu, module, entry, &groups.each_ref(), &constants)
        })
    }
}
