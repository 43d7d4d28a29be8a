// The mark of a selected edge or node: an outline with a border, in a shape that neither routes nor robots have.

// Widths of the outline and of its border, in pixels.
const LINE = 2.2;
const BORDER = 1.3;

// Black on light outlines, white on dark ones.
fn border_colour() -> vec3f {
    return vec3f(select(1.0, 0.0, view.selection.g > 0.5));
}

// An outline around the pixels that are `inside` pixels within its inner side; negative outside of it.
fn outline(inside: f32) -> vec4f {
    let line = clamp(LINE * 0.5 + 0.5 - abs(inside + LINE * 0.5), 0.0, 1.0);
    let border = clamp(LINE * 0.5 + BORDER + 0.5 - abs(inside + LINE * 0.5), 0.0, 1.0);
    return vec4f(mix(border_colour(), view.selection.rgb, line), max(line, border * 0.9));
}

struct Side {
    @builtin(position) clip: vec4f,
    // Distance from the middle line and half the free width, in pixels.
    @location(0) @interpolate(linear) across: f32,
    @location(1) half_width: f32,
}

// An instance is a curve's index; its strip has 64 parts.
@vertex
fn edge(@location(0) index: u32, @builtin(vertex_index) vertex: u32) -> Side {
    let spine = spine(curves[index], f32(vertex / 2u) / 64.0);
    let half_width = clamp(0.16 / metres_per_pixel(vec3f(spine.local, 0.0)), 3.5, 11.0);
    let across = select(-1.0, 1.0, (vertex & 1u) == 1u) * (half_width + LINE + BORDER + 1.0);
    return Side(beside(spine, across), across, half_width);
}

@fragment
fn edge_fill(in: Side) -> @location(0) vec4f {
    return outline(in.half_width - abs(in.across));
}

struct Diamond {
    @builtin(position) clip: vec4f,
    // Relative to the node, in pixels of the ground.
    @location(0) position: vec2f,
    @location(1) radius: f32,
}

// An instance is a node's index.
@vertex
fn node(@location(0) index: u32, @builtin(vertex_index) corner: u32) -> Diamond {
    let local = vec3f(vec2f(nodes[index].x, nodes[index].y) - view.origin.xy, 0.0);
    let pixel = metres_per_pixel(local);
    // Beyond the robots that stand on it.
    let radius = clamp(0.95 / pixel, 10.0, 70.0);
    let unit = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let position = unit * (radius + 6.0);
    return Diamond(cropped(clip_from(local + vec3f(position * pixel, 0.0))), position, radius);
}

@fragment
fn node_fill(in: Diamond) -> @location(0) vec4f {
    let away = (abs(in.position.x) + abs(in.position.y)) * 0.70710678;
    return outline(in.radius * 0.70710678 - away);
}
