// Routes: ribbons along the remaining edges, wide ones of selected robots and narrow ones of all. Released edges are solid,
// planned ones dashed.

// The width in metres near the camera; the least and the greatest width in pixels.
const ROUTE_METRES = 0.34;
const ROUTE_PIXELS = vec2f(5.0, 18.0);
const NARROW_METRES = 0.12;
const NARROW_PIXELS = vec2f(1.8, 6.0);
// Parts of a segment's strip: of wide and of narrow routes; the same as in routes.rs.
const PARTS = 32u;
const NARROW_PARTS = 12u;
// The least length of a dash with its gap, in metres and in pixels.
const DASH_METRES = 1.2;
const DASH_PIXELS = 18.0;

struct Route {
    @builtin(position) clip: vec4f,
    // Distance from the middle line and half the width, in pixels.
    @location(0) @interpolate(linear) across: f32,
    @location(1) half_width: f32,
    // Distance from the curve's start, in dashes.
    @location(2) along: f32,
    @location(3) @interpolate(flat) released: u32,
}

// An instance is a curve's index, the parameters of the segment's start and end, and whether the edge is released.
@vertex
fn route(
    @location(0) index: u32,
    @location(1) range: vec2f,
    @location(2) released: u32,
    @builtin(vertex_index) vertex: u32,
) -> Route {
    return ribbon(index, range, released, f32(vertex / 2u) / f32(PARTS), vertex & 1u, ROUTE_METRES, ROUTE_PIXELS);
}

@vertex
fn narrow_route(
    @location(0) index: u32,
    @location(1) range: vec2f,
    @location(2) released: u32,
    @builtin(vertex_index) vertex: u32,
) -> Route {
    return ribbon(index, range, released, f32(vertex / 2u) / f32(NARROW_PARTS), vertex & 1u, NARROW_METRES, NARROW_PIXELS);
}

fn ribbon(index: u32, range: vec2f, released: u32, part: f32, side: u32, metres: f32, pixels: vec2f) -> Route {
    let curve = curves[index];
    if curve.edge == NO_EDGE {
        return Route(vec4f(2.0, 2.0, 2.0, 1.0), 0.0, 0.0, 0.0, 0u);
    }
    let at = mix(range.x, range.y, part);
    let spine = spine(curve, at);
    let pixel = metres_per_pixel(vec3f(spine.local, 0.0));
    let half_width = clamp(metres / pixel, pixels.x, pixels.y) * 0.5;
    let across = select(-1.0, 1.0, side == 1u) * (half_width + 0.5);
    // A curve has a whole number of dashes, and begins and ends in the middle of one, so that dashes continue from curve to
    // curve. Their length grows by powers of two as the camera moves away, so that it seldom changes.
    let dash = max(DASH_METRES, exp2(ceil(log2(DASH_PIXELS * view.spacing.y))));
    let dashes = max(round(curve.length / dash), 1.0);
    return Route(beside(spine, across), across, half_width, at * dashes, released);
}

@fragment
fn route_fill(in: Route) -> @location(0) vec4f {
    let away = abs(in.across);
    let cover = clamp(in.half_width + 0.5 - away, 0.0, 1.0);
    // Dashes per pixel. Where dashes can't be told apart, they blend into an even, fainter ribbon.
    let fine = max(fwidth(in.along), 1e-5);
    let beside_gap = 0.29 - abs(fract(in.along + 0.5) - 0.5);
    let dash = mix(clamp(beside_gap / fine + 0.5, 0.0, 1.0), 0.5, clamp(fine * 4.0 - 0.6, 0.0, 1.0));
    let rim = clamp(away - in.half_width + 2.0, 0.0, 1.0);
    let solid = mix(0.42, 0.95, rim);
    // Narrow dashes have no area to be faint in.
    let strength = select(dash * mix(0.9, 0.55, clamp(in.half_width - 2.0, 0.0, 1.0)), solid, in.released == 1u);
    return vec4f(view.route.rgb, strength * cover);
}
