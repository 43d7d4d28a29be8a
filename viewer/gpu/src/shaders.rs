//! The WGSL sources of all shaders.

use wgpu::ShaderModule;

use super::device::Gpu;

/// Concatenates WGSL files.
macro_rules! wgsl {
    ($($file:literal)+) => {
        concat!($(include_str!(concat!("shaders/", $file, ".wgsl"))),+)
    };
}

/// The source of each shader by name. Shared parts come before the shader's own part, as WGSL has
/// no imports.
pub const SHADERS: [(&str, &str); 17] = [
    ("floor", wgsl!("view" "floor")),
    ("graph", wgsl!("view" "curves" "graph")),
    ("routes", wgsl!("view" "curves" "routes")),
    ("closures", wgsl!("view" "curves" "closures")),
    ("marked", wgsl!("view" "curves" "marked")),
    ("heat", wgsl!("view" "triangle" "curves" "heat")),
    ("copy", wgsl!("triangle" "copy")),
    ("robots", wgsl!("view" "robots")),
    ("sort", wgsl!("view" "poses" "marks" "sort")),
    ("splats", wgsl!("view" "marks" "splats")),
    ("highlights", wgsl!("view" "poses" "highlights")),
    ("density", wgsl!("view" "marks" "density")),
    ("field", wgsl!("view" "triangle" "marks" "field")),
    ("goals", wgsl!("view" "curves" "goals")),
    ("stations", wgsl!("view" "stations")),
    ("waits", wgsl!("view" "poses" "waits")),
    ("interface", wgsl!("interface")),
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
