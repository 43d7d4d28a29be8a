// The heat map: ribbons along the curves of edges, coloured and widened by a figure.

// The width in metres near the camera of cold and of hot edges; the least and the greatest width in pixels of both.
const METRES = vec2f(0.12, 0.6);
const COLD_PIXELS = vec2f(1.6, 7.0);
const HOT_PIXELS = vec2f(4.5, 26.0);
// Parts of a bent curve's strip; the same as in heat.rs.
const PARTS = 16u;

@group(2) @binding(0) var<uniform> ramp: array<vec4f, 16>;

struct Ribbon {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) colour: vec3f,
    // Distance from the middle line and half the width, in pixels.
    @location(1) @interpolate(linear) across: f32,
    @location(2) half_width: f32,
}

fn colour_of(level: f32) -> vec3f {
    let index = clamp(level, 0.0, 1.0) * 15.0;
    let below = min(u32(index), 14u);
    return mix(ramp[below].rgb, ramp[below + 1u].rgb, index - f32(below));
}

// A vertex of a strip that has two vertices for each of the curve's points.
fn ribbon(index: u32, level: f32, at: f32, side: u32) -> Ribbon {
    let spine = spine(curves[index], at);
    let pixel = metres_per_pixel(vec3f(spine.local, 0.0));
    let pixels = mix(COLD_PIXELS, HOT_PIXELS, level);
    let half_width = clamp(mix(METRES.x, METRES.y, level) / pixel, pixels.x, pixels.y) * 0.5;
    let across = select(-1.0, 1.0, side == 1u) * (half_width + 0.5);
    return Ribbon(beside(spine, across), colour_of(level), across, half_width);
}

@vertex
fn straight(@location(0) index: u32, @location(1) level: f32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(index, level, f32(vertex / 2u), vertex & 1u);
}

@vertex
fn bent(@location(0) index: u32, @location(1) level: f32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(index, level, f32(vertex / 2u) / f32(PARTS), vertex & 1u);
}

@fragment
fn fill(in: Ribbon) -> @location(0) vec4f {
    return vec4f(in.colour, clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0));
}
