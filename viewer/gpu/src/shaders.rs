//! The WGSL sources of all shaders.

use wgpu::ShaderModule;

use super::device::Gpu;

/// The source of each shader by name. Shared parts come before the shader's own part, as WGSL has
/// no imports.
pub const SHADERS: [(&str, &str); 17] = [
    ("floor", concat!(include_str!("shaders/view.wgsl"), include_str!("shaders/floor.wgsl"))),
    (
        "graph",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/graph.wgsl")
        ),
    ),
    (
        "routes",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/routes.wgsl")
        ),
    ),
    (
        "closures",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/closures.wgsl")
        ),
    ),
    (
        "marked",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/marked.wgsl")
        ),
    ),
    (
        "heat",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/heat.wgsl")
        ),
    ),
    ("copy", include_str!("shaders/copy.wgsl")),
    ("robots", concat!(include_str!("shaders/view.wgsl"), include_str!("shaders/robots.wgsl"))),
    (
        "sort",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/poses.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/sort.wgsl")
        ),
    ),
    (
        "splats",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/splats.wgsl")
        ),
    ),
    (
        "highlights",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/poses.wgsl"),
            include_str!("shaders/highlights.wgsl")
        ),
    ),
    (
        "density",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/density.wgsl")
        ),
    ),
    (
        "field",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/field.wgsl")
        ),
    ),
    (
        "goals",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/goals.wgsl")
        ),
    ),
    ("stations", concat!(include_str!("shaders/view.wgsl"), include_str!("shaders/stations.wgsl"))),
    (
        "waits",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/poses.wgsl"),
            include_str!("shaders/waits.wgsl")
        ),
    ),
    ("interface", include_str!("shaders/interface.wgsl")),
];

/// Compiles one of [`SHADERS`].
///
/// # Panics
/// If no shader has this name.
pub fn shader(gpu: &Gpu, name: &str) -> ShaderModule {
    let (_, text) = SHADERS.iter().find(|(listed, _)| *listed == name).expect("a shader's name");
    let source = wgpu::ShaderSource::Wgsl((*text).into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}
