// Badges at stations: discs that face the viewer, with a sign for what robots do there. The shape alone tells them apart.

// The diameter in metres near the camera, the greatest one in pixels, and that from which on badges appear.
const BADGE_METRES = 0.8;
const BADGE_PIXELS = 30.0;
const LEAST_PIXELS = 7.0;

struct Badge {
    @builtin(position) clip: vec4f,
    // Position relative to the centre, in units of the radius; y is up.
    @location(0) position: vec2f,
    @location(1) @interpolate(flat) role: u32,
    // The size of a pixel in the same units; the opacity.
    @location(2) @interpolate(flat) pixel: f32,
    @location(3) @interpolate(flat) alpha: f32,
}

@vertex
fn badge(@location(0) place: vec2f, @location(1) role: u32, @builtin(vertex_index) corner: u32) -> Badge {
    let local = vec3f(place - view.origin.xy, 0.0);
    let clip = clip_from(local);
    let size = BADGE_METRES / metres_per_pixel(local);
    if clip.w < 0.05 || size < LEAST_PIXELS {
        return Badge(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0), 0u, 1.0, 0.0);
    }
    let radius = min(size, BADGE_PIXELS) * 0.5;
    let unit = (vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0) * (1.0 + 1.5 / radius);
    let offset = unit * radius * 2.0 * view.viewport.zw * clip.w;
    let alpha = clamp((size - LEAST_PIXELS) / 3.0, 0.0, 1.0);
    return Badge(cropped(vec4f(clip.xy + offset, clip.zw)), unit, role, 1.0 / radius, alpha);
}

// The distance from a triangle that points up, with its base at y = -0.4 and its tip at y = 0.6.
fn triangle_distance(at: vec2f) -> f32 {
    return max(-0.4 - at.y, (abs(at.x) * 2.0 + at.y - 0.6) * 0.447);
}

// The distance from a bar between two points.
fn bar_distance(at: vec2f, a: vec2f, b: vec2f, half_width: f32) -> f32 {
    let along = clamp(dot(at - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    return length(at - mix(a, b, along)) - half_width;
}

// The distance from the sign of a role: pick is a triangle that points up, drop one that points down, transfer has both, park is
// a P, charge a flash. A station without a role has no sign.
fn sign_distance(role: u32, at: vec2f) -> f32 {
    switch role {
        case 1u: { return triangle_distance(at); }
        case 2u: { return triangle_distance(vec2f(at.x, -at.y)); }
        case 3u: {
            let stem = bar_distance(at, vec2f(-0.22, -0.5), vec2f(-0.22, 0.5), 0.12);
            let bow = abs(length(at - vec2f(0.02, 0.2)) - 0.28) - 0.11;
            return min(stem, max(bow, -0.22 - at.x));
        }
        case 5u: {
            let up = triangle_distance((at - vec2f(0.0, 0.3)) * 1.8);
            return min(up, triangle_distance((vec2f(at.x, -at.y) - vec2f(0.0, 0.3)) * 1.8)) / 1.8;
        }
        case 0u: { return 1.0; }
        default: {
            let upper = bar_distance(at, vec2f(0.14, 0.6), vec2f(-0.22, -0.02), 0.1);
            let middle = bar_distance(at, vec2f(-0.22, -0.02), vec2f(0.22, 0.04), 0.1);
            return min(min(upper, middle), bar_distance(at, vec2f(0.22, 0.04), vec2f(-0.14, -0.6), 0.1));
        }
    }
}

@fragment
fn badge_fill(in: Badge) -> @location(0) vec4f {
    let radius = length(in.position);
    let cover = clamp((1.0 - radius) / in.pixel + 0.5, 0.0, 1.0);
    let rim = clamp((radius - 0.84) / in.pixel + 0.5, 0.0, 1.0);
    let sign = clamp(0.5 - sign_distance(in.role, in.position) / in.pixel, 0.0, 1.0);
    return vec4f(mix(view.floor.rgb, view.node.rgb, max(rim, sign)), cover * in.alpha);
}
