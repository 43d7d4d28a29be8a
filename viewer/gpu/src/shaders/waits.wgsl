// Arrows from robots that wait to those that they wait for. Those of rings are wider and of another colour.

// Half the width of the shaft in metres near the camera, and its least and greatest value in pixels.
const SHAFT_METRES = 0.05;
const SHAFT_PIXELS = vec2f(0.9, 2.6);
const RING = 2.0;
// Half the width and the length of the head, in half widths of the shaft.
const HEAD = vec2f(3.0, 7.0);
// The height of arrows above the floor, in metres: about that of robots.
const HEIGHT = 0.3;

struct Arrow {
    @builtin(position) clip: vec4f,
    // In pixels: along the arrow from its start, and across it from its middle line.
    @location(0) @interpolate(linear) position: vec2f,
    @location(1) @interpolate(flat) length: f32,
    @location(2) @interpolate(flat) half_width: f32,
    @location(3) @interpolate(flat) in_ring: u32,
}

const NO_ARROW = Arrow(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0), 0.0, 0.0, 0u);

fn is_absent(robot: u32) -> bool {
    return robot >= view.robots || state_of(min(robot, view.robots - 1u)) == ABSENT;
}

@vertex
fn mark(
    @location(0) start: u32,
    @location(1) end: u32,
    @location(2) in_ring: u32,
    @builtin(vertex_index) corner: u32,
) -> Arrow {
    if view.robots == 0u || is_absent(start) || is_absent(end) || is_hidden(start) || is_hidden(end) {
        return NO_ARROW;
    }
    let from_clip = clip_from(vec3f(pose_of(start).xy, HEIGHT));
    let to_local = vec3f(pose_of(end).xy, HEIGHT);
    let to_clip = clip_from(to_local);
    // An end behind the camera has no place in the picture.
    if min(from_clip.w, to_clip.w) < 0.05 {
        return NO_ARROW;
    }
    let half_size = view.viewport.xy * 0.5;
    let origin = from_clip.xy / from_clip.w * half_size;
    let shaft = to_clip.xy / to_clip.w * half_size - origin;
    let whole = length(shaft);
    if whole < 1.5 {
        return NO_ARROW;
    }
    let pixel = metres_per_pixel(to_local);
    let half_width = clamp(SHAFT_METRES / pixel, SHAFT_PIXELS.x, SHAFT_PIXELS.y) * select(1.0, RING, in_ring == 1u);
    // The tip is at the border of the robot that is waited for rather than at its centre, which other arrows point at, too.
    let border = robot_types[min(robot_type_of(end), 63u)].length * 0.35 / pixel;
    let reach = max(whole - border, whole * 0.5);
    let direction = shaft / whole;
    let across = vec2f(-direction.y, direction.x);
    let margin = half_width * HEAD.x + 2.0;
    let at = vec2f(select(-2.0, reach + 2.0, corner >= 2u), select(-margin, margin, (corner & 1u) == 1u));
    let place = origin + direction * at.x + across * at.y;
    let clip = select(from_clip, to_clip, corner >= 2u);
    return Arrow(cropped(vec4f(place / half_size * clip.w, clip.zw)), at, reach, half_width, in_ring);
}

// The distance from the outline of an arrow, in pixels. Negative within.
fn arrow_distance(in: Arrow) -> f32 {
    let head = min(in.half_width * HEAD.y, in.length * 0.6);
    let along = in.position.x;
    let across = abs(in.position.y);
    let shaft = max(across - in.half_width, max(-along, along - (in.length - head)));
    let wing = in.half_width * HEAD.x / head;
    let slope = (across - (in.length - along) * wing) * inverseSqrt(1.0 + wing * wing);
    let point = max(slope, in.length - head - along);
    return min(shaft, point);
}

@fragment
fn mark_fill(in: Arrow) -> @location(0) vec4f {
    let away = arrow_distance(in);
    let colour = select(view.waiting.rgb, view.ring.rgb, in.in_ring == 1u);
    // A dark rim sets arrows off from robots of a similar colour.
    let inside = clamp(0.5 - away, 0.0, 1.0);
    return vec4f(mix(vec3f(0.008), colour, inside), clamp(1.5 - away, 0.0, 1.0));
}
