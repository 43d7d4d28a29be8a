// Bars on the ground: doors and the cabins of lifts in the colours of their states, walls, racks, and lines from stations to nodes.

// Linear colours of doors and cabins by `BarColour` in facilities.rs: closed, in motion, open, away. Then those of the theme.
const COLOURS = array(vec3f(0.686, 0.0168, 0.0284), vec3f(0.9, 0.5, 0.02), vec3f(0.03, 0.45, 0.12), vec3f(0.2, 0.22, 0.25));
// The width of a bar in metres near the camera; its least and its greatest width in pixels.
const METRES = 0.14;
const PIXELS = vec2f(2.5, 9.0);
// The same of walls, of lines from stations to nodes, and of racks.
const WALL = 4u;
const WALL_PIXELS = vec2f(1.8, 5.0);
const LINK = 5u;
const LINK_PIXELS = vec2f(1.0, 1.2);
const RACK = 6u;
const RACK_PIXELS = vec2f(1.0, 1.8);
// The least distance from the camera at which something has a place in the picture, in metres.
const NEAR = 0.05;

struct Bar {
    @builtin(position) clip: vec4f,
    // Distance from the middle line and half the width, in pixels.
    @location(0) @interpolate(linear) across: f32,
    @location(1) @interpolate(flat) half_width: f32,
    @location(2) @interpolate(flat) colour: u32,
}

@vertex
fn bar(@location(0) ends: vec4f, @location(1) colour: u32, @builtin(vertex_index) corner: u32) -> Bar {
    let is_end = corner >= 2u;
    let whole = array(ends.xy - view.origin.xy, ends.zw - view.origin.xy);
    let distances = vec2f(clip_from(vec3f(whole[0], 0.0)).w, clip_from(vec3f(whole[1], 0.0)).w);
    // An end behind the camera has no place in the picture: the bar begins where it comes into sight.
    let behind = clamp((NEAR - distances) / max(distances.yx - distances, vec2f(1e-6)), vec2f(0.0), vec2f(1.0));
    let from_local = vec3f(mix(whole[0], whole[1], behind.x), 0.0);
    let to_local = vec3f(mix(whole[1], whole[0], behind.y), 0.0);
    let local = select(from_local, to_local, is_end);
    let from_clip = clip_from(from_local);
    let to_clip = clip_from(to_local);
    if max(distances.x, distances.y) < NEAR {
        return Bar(vec4f(2.0, 2.0, 2.0, 1.0), 0.0, 0.0, 0u);
    }
    let along = (to_clip.xy / to_clip.w - from_clip.xy / from_clip.w) * view.viewport.xy;
    let direction = normalize(along + vec2f(1e-9, 0.0));
    let theme_pixels = select(select(WALL_PIXELS, LINK_PIXELS, colour == LINK), RACK_PIXELS, colour == RACK);
    let pixels = select(PIXELS, theme_pixels, colour >= WALL);
    let half_width = clamp(METRES / metres_per_pixel(local), pixels.x, pixels.y) * 0.5;
    let across = select(-1.0, 1.0, (corner & 1u) == 1u) * (half_width + 0.5);
    let offset = vec2f(-direction.y, direction.x) * across * 2.0 * view.viewport.zw;
    let clip = select(from_clip, to_clip, is_end);
    return Bar(cropped(vec4f(clip.xy + offset * clip.w, clip.zw)), across, half_width, colour);
}

@fragment
fn bar_fill(in: Bar) -> @location(0) vec4f {
    let cover = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    var colours = COLOURS;
    let theme_colour = select(select(view.wall.rgb, view.node.rgb, in.colour == LINK), view.rack.rgb, in.colour == RACK);
    return vec4f(select(colours[min(in.colour, 3u)], theme_colour, in.colour >= WALL), cover);
}
