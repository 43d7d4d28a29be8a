// The heat map: ribbons along the curves of edges, coloured and widened by a figure.

// The width in metres near the camera of cold and of hot edges; the least and the greatest width in pixels of both.
const METRES = vec2f(0.12, 0.6);
const COLD_PIXELS = vec2f(2.0, 7.0);
const HOT_PIXELS = vec2f(6.5, 26.0);
// Parts of a bent curve's ribbon, and the vertices of each part; the same as in heat.rs.
const PARTS = 16u;
const QUAD = 6u;
// Steps of heat: colder ribbons are drawn before hotter ones. The same as in heat.rs.
const STEPS = 16u;

// A curve with its heat, from 0 to 1: straight curves first, then bent ones, and the coldest first of both.
struct Hot {
    curve: u32,
    level: f32,
}

@group(2) @binding(0) var<storage, read> all: array<Hot>;

fn half_width_of(level: f32, pixel: f32) -> f32 {
    let pixels = mix(COLD_PIXELS, HOT_PIXELS, level);
    return clamp(mix(METRES.x, METRES.y, level) / pixel, pixels.x, pixels.y) * 0.5;
}

// --- Sorting by what is in sight.

struct Draw {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

// Where each step of heat begins in `all` and in `visible`, of straight and of bent curves, and the end of the last one.
@group(2) @binding(1) var<uniform> starts: array<vec4u, 9>;
@group(2) @binding(2) var<storage, read_write> visible: array<u32>;
// Of each step of heat, and then whether there are ribbons in `pixels`.
@group(2) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 33>;
@group(2) @binding(4) var<storage, read_write> draws: array<Draw, 33>;
// A key per pixel, row by row: whether a ribbon covers at least half of the pixel, how hot it is, and how much of the pixel it
// covers. The highest key is in front.
@group(2) @binding(5) var<storage, read_write> pixels: array<atomic<u32>>;

// Whether short ribbons are drawn into pixels rather than as triangles: a software adapter does that on all its SIMD lanes.
override SPLATS = false;
// The greatest width and height in pixels of a ribbon that is drawn into pixels.
const SHORT = 64.0;
// Parts of a bent one.
const SHORT_PARTS = 6u;

fn start_of(step: u32) -> u32 {
    return starts[step / 4u][step % 4u];
}

// Draws a part of a ribbon into pixels: for each pixel along its longer side, those across it.
fn splat(a: vec2f, b: vec2f, half_width: f32, level: u32) {
    let is_steep = abs(b.y - a.y) > abs(b.x - a.x);
    let from_end = select(a, a.yx, is_steep);
    let to_end = select(b, b.yx, is_steep);
    let size = select(view.viewport.xy, view.viewport.yx, is_steep);
    let run = to_end.x - from_end.x;
    let slope = select((to_end.y - from_end.y) / run, 0.0, abs(run) < 1e-3);
    let stretch = sqrt(1.0 + slope * slope);
    let reach = (half_width + 0.5) * stretch;
    let half_length = abs(run) * 0.5 * stretch;
    let middle = (from_end + to_end) * 0.5;
    // The ends are at right angles to the sides.
    let half_run = abs(run) * 0.5 + 0.5 + half_width * abs(slope) / stretch;
    let high = min(ceil(middle.x + half_run - 0.5), size.x);
    for (var x = max(ceil(middle.x - half_run - 0.5), 0.0); x < high; x += 1.0) {
        let along = x + 0.5 - middle.x;
        let spine = middle.y + slope * along;
        let end = min(ceil(spine + reach - 0.5), size.y);
        for (var y = max(ceil(spine - reach - 0.5), 0.0); y < end; y += 1.0) {
            let beside = half_width + 0.5 - abs(y + 0.5 - spine) / stretch;
            let beyond = half_length + 0.5 - abs(along + (y + 0.5 - middle.y) * slope) / stretch;
            let cover = clamp(min(beside, beyond), 0.0, 1.0);
            let key = (u32(cover >= 0.5) << 31u) | (level << 16u) | u32(cover * 65535.0);
            let at = vec2u(vec2f(select(x, y, is_steep), select(y, x, is_steep)));
            let pixel = &pixels[at.y * u32(view.viewport.x) + at.x];
            if cover > 0.0 && atomicLoad(pixel) < key {
                atomicMax(pixel, key);
            }
        }
    }
}

fn pixel_of(clip: vec4f) -> vec2f {
    return (clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5) * view.viewport.xy;
}

// Draws a short ribbon into pixels.
fn splat_curve(curve: Curve, level: f32, bend: f32) {
    let parts = select(1u, SHORT_PARTS, bend > 0.7);
    let pixel = metres_per_pixel(vec3f(point_at(curve, 0.5) - view.origin.xy, 0.0));
    let half_width = half_width_of(level, pixel);
    var before = pixel_of(clip_from(vec3f(curve.start - view.origin.xy, 0.0)));
    for (var i = 1u; i <= parts; i++) {
        let at = point_at(curve, f32(i) / f32(parts)) - view.origin.xy;
        let next = pixel_of(clip_from(vec3f(at, 0.0)));
        // Parts overlap by a pixel, so that there is no gap between them.
        let over = (next - before) * 0.5 / max(length(next - before), 1e-3);
        let from_place = before - over * f32(i > 1u);
        splat(from_place, next + over * f32(i < parts), half_width, u32(level * 32767.0));
        before = next;
    }
}

@compute @workgroup_size(64)
fn sort(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = at.x + at.y * groups.x * 64u;
    let end = start_of(2u * STEPS);
    if number >= end {
        return;
    }
    // The hottest first: most of the colder ones under them are then not written into pixels.
    let i = end - 1u - number;
    let hot = all[i];
    let curve = curves[hot.curve];
    if curve.edge == NO_EDGE {
        return;
    }
    let low = min(min(curve.start, curve.end), min(curve.control_a, curve.control_b)) - view.origin.xy;
    let high = max(max(curve.start, curve.end), max(curve.control_a, curve.control_b)) - view.origin.xy;
    let middle = (low + high) * 0.5;
    let radius = length(high - low) * 0.5;
    if !inside(middle, radius + METRES.y) {
        return;
    }
    let depth = dot(vec3f(middle, 0.0) - view.eye.xyz, view.forward.xyz);
    let per_metre = view.eye.w / max(depth - radius, 0.05);
    if SPLATS {
        if radius * 2.0 * per_metre < SHORT && depth - radius > 0.05 {
            splat_curve(curve, hot.level, bend_of(curve) * per_metre);
            atomicStore(&counts[2u * STEPS], 1u);
            return;
        }
    }
    let step = min(u32(hot.level * f32(STEPS)), STEPS - 1u) + select(0u, STEPS, i >= start_of(STEPS));
    visible[start_of(step) + atomicAdd(&counts[step], 1u)] = i;
}

// Turns the numbers of ribbons into the arguments of draws.
@compute @workgroup_size(32)
fn count_draws(@builtin(local_invocation_index) step: u32) {
    let vertices = QUAD * select(1u, PARTS, step >= STEPS);
    draws[step] = Draw(vertices * atomicLoad(&counts[step]), 1u, vertices * start_of(step), 0u);
    if step == 0u {
        draws[2u * STEPS] = Draw(3u * atomicLoad(&counts[2u * STEPS]), 1u, 0u, 0u);
    }
}

// --- Drawing.

@group(2) @binding(1) var<uniform> ramp: array<vec4f, 16>;
// Numbers of ribbons in sight, at the places of their steps of heat.
@group(2) @binding(2) var<storage, read> shown: array<u32>;
@group(2) @binding(3) var<storage, read> splatted: array<u32>;

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

// A vertex of a part of a ribbon.
fn ribbon(hot: Hot, vertex: u32, parts: u32) -> Ribbon {
    let corner = quad_corner(vertex);
    let at = f32(vertex / QUAD % parts + corner / 2u) / f32(parts);
    let spine = spine(curves[hot.curve], at);
    let half_width = half_width_of(hot.level, metres_per_pixel(vec3f(spine.local, 0.0)));
    let across = select(-1.0, 1.0, corner % 2u == 1u) * (half_width + 0.5);
    return Ribbon(beside(spine, across), colour_of(hot.level), across, half_width);
}

@vertex
fn straight(@builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(all[shown[vertex / QUAD]], vertex, 1u);
}

@vertex
fn bent(@builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(all[shown[vertex / (QUAD * PARTS)]], vertex, PARTS);
}

@fragment
fn fill(in: Ribbon) -> @location(0) vec4f {
    return vec4f(in.colour, clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0));
}

@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    return triangle_corner(corner, view.viewport.xy);
}

@fragment
fn fill_splatted(in: Place) -> @location(0) vec4f {
    let size = vec2u(view.viewport.xy);
    let at = min(vec2u(in.at), size - 1u);
    let key = splatted[at.y * size.x + at.x];
    if key == 0u {
        discard;
    }
    return vec4f(colour_of(f32(extractBits(key, 16u, 15u)) / 32767.0), f32(extractBits(key, 0u, 16u)) / 65535.0);
}
