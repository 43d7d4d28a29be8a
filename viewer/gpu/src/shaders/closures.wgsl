// Closed edges: a dashed ribbon along each, and a no-entry sign in its middle.

// Red; the same as `CLOSED` in palette.rs, but linear.
const COLOUR = vec3f(0.686, 0.0168, 0.0284);
// The width of the ribbon in metres near the camera; its least and its greatest width in pixels.
const METRES = 0.26;
const PIXELS = vec2f(3.5, 12.0);
// Parts of a curve's strip; the same as in closures.rs.
const PARTS = 32u;
// The least length of a dash with its gap, in metres and in pixels.
const DASH_METRES = 0.9;
const DASH_PIXELS = 14.0;
// The diameter of a sign in metres near the camera; its least and its greatest one in pixels.
const SIGN_METRES = 0.9;
const SIGN_PIXELS = vec2f(9.0, 34.0);

struct Ribbon {
    @builtin(position) clip: vec4f,
    // Distance from the middle line and half the width, in pixels.
    @location(0) @interpolate(linear) across: f32,
    @location(1) half_width: f32,
    // Distance from the curve's start, in dashes.
    @location(2) along: f32,
}

// An instance is a curve's index.
@vertex
fn ribbon(@location(0) index: u32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    let curve = curves[index];
    let at = f32(vertex / 2u) / f32(PARTS);
    let spine = spine(curve, at);
    let half_width = clamp(METRES / metres_per_pixel(vec3f(spine.local, 0.0)), PIXELS.x, PIXELS.y) * 0.5;
    let across = select(-1.0, 1.0, (vertex & 1u) == 1u) * (half_width + 0.5);
    let dash = max(DASH_METRES, exp2(ceil(log2(DASH_PIXELS * view.spacing.y))));
    let dashes = max(round(curve.length / dash), 1.0);
    return Ribbon(beside(spine, across), across, half_width, at * dashes);
}

@fragment
fn ribbon_fill(in: Ribbon) -> @location(0) vec4f {
    let cover = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    // Dashes per pixel. Where dashes can't be told apart, they blend into an even ribbon.
    let fine = max(fwidth(in.along), 1e-5);
    let beside_gap = 0.32 - abs(fract(in.along + 0.5) - 0.5);
    let dash = mix(clamp(beside_gap / fine + 0.5, 0.0, 1.0), 0.65, clamp(fine * 4.0 - 0.6, 0.0, 1.0));
    return vec4f(COLOUR, dash * cover);
}

struct Sign {
    @builtin(position) clip: vec4f,
    // Position relative to the centre, in units of the radius; y is up.
    @location(0) position: vec2f,
    // The size of a pixel in the same units.
    @location(1) @interpolate(flat) pixel: f32,
}

@vertex
fn sign(@location(0) place: vec2f, @builtin(vertex_index) corner: u32) -> Sign {
    let local = vec3f(place - view.origin.xy, 0.0);
    let clip = clip_from(local);
    if clip.w < 0.05 {
        return Sign(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0), 1.0);
    }
    let radius = clamp(SIGN_METRES / metres_per_pixel(local), SIGN_PIXELS.x, SIGN_PIXELS.y) * 0.5;
    let unit = (vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0) * (1.0 + 1.5 / radius);
    let offset = unit * radius * 2.0 * view.viewport.zw * clip.w;
    return Sign(cropped(vec4f(clip.xy + offset, clip.zw)), unit, 1.0 / radius);
}

@fragment
fn sign_fill(in: Sign) -> @location(0) vec4f {
    let disc = clamp((1.0 - length(in.position)) / in.pixel, 0.0, 1.0);
    let red = clamp((0.9 - length(in.position)) / in.pixel, 0.0, 1.0);
    let beside_bar = max(abs(in.position.x) - 0.62, abs(in.position.y) - 0.19);
    let bar = clamp(-beside_bar / in.pixel + 0.5, 0.0, 1.0);
    return vec4f(mix(vec3f(1.0), COLOUR, red * (1.0 - bar)), disc);
}
