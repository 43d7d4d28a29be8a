// Marks at goals: pins that stand on their nodes and face the viewer.

// The height of a pin in metres near the camera, and the least and the greatest height in pixels; of goals of selected robots
// both are larger.
const PIN_METRES = 0.9;
const PIN_PIXELS = vec2f(9.0, 26.0);
const SELECTED_PIXELS = vec2f(24.0, 42.0);

struct Pin {
    @builtin(position) clip: vec4f,
    // Position in the picture relative to the tip, in units of the height; y is up.
    @location(0) position: vec2f,
    @location(1) @interpolate(flat) selected: u32,
    // The size of a pixel in the same units.
    @location(2) @interpolate(flat) pixel: f32,
}

// An instance is the index of the node, which has no place on another level than the picture's, and whether a selected robot goes
// there.
@vertex
fn mark(@location(0) index: u32, @location(1) selected: u32, @builtin(vertex_index) corner: u32) -> Pin {
    let place = vec2f(nodes[index].x, nodes[index].y);
    let local = vec3f(place - view.origin.xy, 0.0);
    let clip = clip_from(local);
    let pixels = select(PIN_PIXELS, SELECTED_PIXELS, selected == 1u);
    let height = clamp(PIN_METRES / metres_per_pixel(local), pixels.x, pixels.y);
    let unit = vec2f(f32(corner & 1u) * 2.0 - 1.0, f32(corner >> 1u)) * vec2f(0.5, 1.3) - vec2f(0.0, 0.15);
    let offset = unit * height * 2.0 * view.viewport.zw * clip.w;
    return Pin(cropped(vec4f(clip.xy + offset, clip.zw)), unit, selected, 1.0 / height);
}

// The distance from the outline of a pin: a circle, and a wedge from it to the tip at the origin. Negative within.
fn pin_distance(at: vec2f) -> f32 {
    let round = length(at - vec2f(0.0, 0.68)) - 0.32;
    // The wedge touches the circle: its half angle has the sine 0.32 / 0.68.
    let side = abs(at.x) * 0.8824 - at.y * 0.4706;
    return select(round, min(round, side), at.y < 0.53 && at.y > 0.0);
}

@fragment
fn mark_fill(in: Pin) -> @location(0) vec4f {
    let away = pin_distance(in.position) / in.pixel;
    let hole = (length(in.position - vec2f(0.0, 0.68)) - 0.13) / in.pixel;
    let cover = clamp(1.2 - away, 0.0, 1.0);
    // A dark rim and a dark hole set the pin off from what is behind it.
    let inside = clamp(-0.3 - away, 0.0, 1.0) * clamp(hole + 0.5, 0.0, 1.0);
    let bright = mix(view.route.rgb, vec3f(1.0), select(0.0, 0.25, in.selected == 1u));
    return vec4f(mix(vec3f(0.008), bright, inside), cover * select(0.85, 1.0, in.selected == 1u));
}
