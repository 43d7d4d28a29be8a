// The nodes and curves of the route graph.

// A cubic Bézier curve: an edge, or a part of one. The same as `CurveInstance` in graph.rs.
struct Curve {
    // Index of the edge in the world, or NO_EDGE if the curve isn't shown: it is on another level than the picture's.
    edge: u32,
    length: f32,
    edge_length: f32,
    reverse_speed: f32,
    start: vec2f,
    control_a: vec2f,
    control_b: vec2f,
    end: vec2f,
    // The parameter of the edge's arrow, or a negative number if the arrow is on another curve.
    arrow: f32,
    reserved: f32,
}

const NO_EDGE = 0xffffffffu;

struct Node {
    x: f32,
    y: f32,
}

@group(1) @binding(0) var<storage, read> curves: array<Curve>;
@group(1) @binding(1) var<storage, read> nodes: array<Node>;

// The point of a curve at a parameter from 0 to 1.
fn point_at(curve: Curve, at: f32) -> vec2f {
    let back = 1.0 - at;
    return back * back * (back * curve.start + 3.0 * at * curve.control_a)
        + at * at * (3.0 * back * curve.control_b + at * curve.end);
}

// The curve's direction at a parameter, not normalized.
fn tangent(curve: Curve, at: f32) -> vec2f {
    let back = 1.0 - at;
    let derivative = back * back * (curve.control_a - curve.start)
        + 2.0 * back * at * (curve.control_b - curve.control_a) + at * at * (curve.end - curve.control_b);
    // The derivative vanishes at an end whose control point coincides with it.
    return select(curve.end - curve.start, derivative, dot(derivative, derivative) > 1e-8);
}

// A point of the middle line of a strip along a curve, and the direction across the strip in the picture.
struct Spine {
    local: vec2f,
    clip: vec4f,
    across: vec2f,
}

fn spine(curve: Curve, at: f32) -> Spine {
    let local = point_at(curve, at) - view.origin.xy;
    let clip = clip_from(vec3f(local, 0.0));
    let ahead = view.clip_from_local * vec4f(normalize(tangent(curve, at)), 0.0, 0.0);
    let direction = (ahead.xy * clip.w - clip.xy * ahead.w) * view.viewport.xy;
    return Spine(local, clip, normalize(vec2f(-direction.y, direction.x) + vec2f(1e-12, 0.0)));
}

// The vertex of a strip that is `pixels` beside its middle line.
fn beside(spine: Spine, pixels: f32) -> vec4f {
    let offset = spine.across * pixels * 2.0 * view.viewport.zw * spine.clip.w;
    return cropped(vec4f(spine.clip.xy + offset, spine.clip.zw));
}

// The greatest distance of a control point from the curve's chord, in metres.
fn bend_of(curve: Curve) -> f32 {
    let chord = normalize(curve.end - curve.start + vec2f(1e-9, 0.0));
    let aside_a = curve.control_a - curve.start;
    let aside_b = curve.control_b - curve.start;
    return max(abs(chord.x * aside_a.y - chord.y * aside_a.x), abs(chord.x * aside_b.y - chord.y * aside_b.x));
}

// Whether a circle on the ground intersects the view frustum.
fn inside(local: vec2f, radius: f32) -> bool {
    var all_inside = true;
    for (var side = 0; side < 4; side++) {
        all_inside = all_inside && dot(view.planes[side].xyz, vec3f(local, 0.0) - view.eye.xyz) > -radius;
    }
    return all_inside;
}
