// The world's edge and node records, and the edges' Bézier curves.

struct Edge {
    id: u32,
    origin: u32,
    destination: u32,
    length: f32,
    start: vec2f,
    control_a: vec2f,
    control_b: vec2f,
    end: vec2f,
    forward: f32,
    backwards: f32,
    reserved: vec2u,
}

struct Node {
    id: u32,
    x: f32,
    y: f32,
    theta: f32,
}

@group(1) @binding(0) var<storage, read> edges: array<Edge>;
@group(1) @binding(1) var<storage, read> nodes: array<Node>;

// The point of an edge's curve at a parameter from 0 to 1.
fn curve(edge: Edge, at: f32) -> vec2f {
    let back = 1.0 - at;
    return back * back * (back * edge.start + 3.0 * at * edge.control_a)
        + at * at * (3.0 * back * edge.control_b + at * edge.end);
}

// The curve's direction at a parameter, not normalized.
fn tangent(edge: Edge, at: f32) -> vec2f {
    let back = 1.0 - at;
    let derivative = back * back * (edge.control_a - edge.start) + 2.0 * back * at * (edge.control_b - edge.control_a)
        + at * at * (edge.end - edge.control_b);
    // The derivative vanishes at an end whose control point coincides with it.
    return select(edge.end - edge.start, derivative, dot(derivative, derivative) > 1e-8);
}

// A point of the middle line of a strip along a curve, and the direction across the strip in the picture.
struct Spine {
    local: vec2f,
    clip: vec4f,
    across: vec2f,
}

fn spine(edge: Edge, at: f32) -> Spine {
    let local = curve(edge, at) - view.origin.xy;
    let clip = clip_from(vec3f(local, 0.0));
    let ahead = view.clip_from_local * vec4f(normalize(tangent(edge, at)), 0.0, 0.0);
    let direction = (ahead.xy * clip.w - clip.xy * ahead.w) * view.viewport.xy;
    return Spine(local, clip, normalize(vec2f(-direction.y, direction.x) + vec2f(1e-12, 0.0)));
}

// The vertex of a strip that is `pixels` beside its middle line.
fn beside(spine: Spine, pixels: f32) -> vec4f {
    let offset = spine.across * pixels * 2.0 * view.viewport.zw * spine.clip.w;
    return cropped(vec4f(spine.clip.xy + offset, spine.clip.zw));
}
