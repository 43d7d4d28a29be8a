// Trails behind robots, and halos around the selected ones.

// The ring buffer of trail points: in each slot a point per robot.
@group(2) @binding(1) var<storage, read_write> written: array<vec2f>;

// The point of a robot that is absent.
const NOWHERE = vec2f(1e30);

@compute @workgroup_size(64)
fn append(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= view.robots {
        return;
    }
    let stride = rows();
    let point = vec2f(current[i], current[stride + i]);
    written[ring.newest * stride + i] = select(point, NOWHERE, state_of(i) == ABSENT);
}

struct RingBuffer {
    // Slot of the newest points, slots that have points, all slots; the number of selected robots if only their trails
    // are drawn, else 0.
    newest: u32,
    filled: u32,
    slots: u32,
    selected: u32,
}

@group(2) @binding(0) var<uniform> ring: RingBuffer;
@group(2) @binding(1) var<storage, read> points: array<vec2f>;
@group(2) @binding(2) var<storage, read> selected: array<u32>;

struct Trail {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
    // Distance from the middle line and half the width, in pixels.
    @location(1) @interpolate(linear) across: f32,
    @location(2) half_width: f32,
    // Distance from the newer point, and the length of the segment, in pixels.
    @location(3) @interpolate(linear) along: f32,
    @location(4) @interpolate(flat) length: f32,
}

fn point_of(robot: u32, age: u32) -> vec2f {
    let slot = (ring.newest + ring.slots - age) % ring.slots;
    let point = points[slot * rows() + robot];
    return select(point - view.origin.xy, NOWHERE, point.x > 1e20);
}

// Draws a segment of a trail, from the point of an age to the next newer one; at age 0 to the robot itself.
@vertex
fn trail(@builtin(instance_index) instance: u32, @builtin(vertex_index) corner: u32) -> Trail {
    let robots = select(ring.selected, view.robots, ring.selected == 0u);
    let age = instance / robots;
    let index = instance % robots;
    let robot = select(index, selected[min(index, arrayLength(&selected) - 1u)], ring.selected > 0u);
    var newer = point_of(robot, max(age, 1u) - 1u);
    if age == 0u {
        newer = select(pose_of(robot).xy, NOWHERE, state_of(robot) == ABSENT || robot >= view.robots);
    }
    let older = point_of(robot, age);
    let motion = newer - older;
    if robot >= view.robots || is_hidden(robot) {
        return Trail(vec4f(2.0, 2.0, 2.0, 1.0), vec4f(0.0), 0.0, 0.0, 0.0, 0.0);
    }
    // Segments of 20 m or more are teleports. The comparison with NaN is false.
    if !(dot(motion, motion) < 400.0) || dot(motion, motion) < 1e-8 {
        return Trail(vec4f(2.0, 2.0, 2.0, 1.0), vec4f(0.0), 0.0, 0.0, 0.0, 0.0);
    }
    let is_older = corner >= 2u;
    let local = select(newer, older, is_older);
    let clip = clip_from(vec3f(local, 0.0));
    let ahead = view.clip_from_local * vec4f(motion, 0.0, 0.0);
    let direction = (ahead.xy * clip.w - clip.xy * ahead.w) * view.viewport.xy;
    let normal = normalize(vec2f(-direction.y, direction.x) + vec2f(1e-12, 0.0));
    // Where robots are small, trails are thinner, so that they don't hide the robots.
    let pixels = 1.0 / metres_per_pixel(vec3f(local, 0.0));
    let half_width = clamp(0.09 * pixels, 0.4, 3.0);
    let reach = length(motion) * pixels;
    let across = select(-1.0, 1.0, (corner & 1u) == 1u) * (half_width + 0.5);
    let fade = 1.0 - (f32(age) + select(0.0, 1.0, is_older)) / f32(ring.slots);
    let colour = vec4f(colour_of(robot), fade * clamp(0.1 * pixels, 0.25, 0.9));
    return Trail(cropped(vec4f(clip.xy + normal * across * 2.0 * view.viewport.zw * clip.w, clip.zw)), colour, across, half_width, select(0.0, reach, is_older), reach);
}

@fragment
fn trail_fill(in: Trail) -> @location(0) vec4f {
    let line = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    // A bead at the older point, so that trails don't look like edges, and their spacing shows the speed. Where beads would
    // touch each other, the trail is a line.
    let away = length(vec2f(in.length - in.along, in.across));
    let before = length(vec2f(in.along, in.across));
    let bead = clamp(in.half_width + 0.5 - min(away, before), 0.0, 1.0);
    let apart = clamp(in.length / (in.half_width * 4.0) - 0.5, 0.0, 1.0);
    let thin = clamp(in.half_width * 0.3 + 0.5 - abs(in.across), 0.0, 1.0) * 0.45;
    return vec4f(in.colour.rgb, in.colour.a * mix(line, max(bead, thin), apart));
}

struct Halo {
    @builtin(position) clip: vec4f,
    // Position relative to the centre, in units of the halo's radius.
    @location(0) position: vec2f,
}

@vertex
fn halo(@builtin(instance_index) instance: u32, @builtin(vertex_index) corner: u32) -> Halo {
    let robot = selected[instance];
    if robot >= view.robots || state_of(robot) == ABSENT || is_hidden(robot) {
        return Halo(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0));
    }
    let robot_type = robot_types[min(robot_type_of(robot), 63u)];
    let local = vec3f(pose_of(robot).xy, 0.0);
    let pixel = metres_per_pixel(local);
    let radius = max(length(vec2f(robot_type.length, robot_type.width)) * 0.62, 9.0 * pixel);
    let unit = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let outer = radius + 5.0 * pixel;
    return Halo(cropped(clip_from(local + vec3f(unit * outer, 0.0))), unit * outer / radius);
}

@fragment
fn halo_fill(in: Halo) -> @location(0) vec4f {
    let radius = length(in.position);
    let away = abs(radius - 1.0) / max(fwidth(radius), 1e-4);
    // Four arcs with a border: a shape that tells them from robots in the colours of any data.
    let gap = abs(abs(in.position.x) - abs(in.position.y)) / max(fwidth(radius), 1e-4);
    let arc = clamp((gap - 2.5) * 0.5, 0.0, 1.0);
    let line = clamp(1.8 - away, 0.0, 1.0) * arc;
    let border = clamp(3.4 - away, 0.0, 1.0) * clamp((gap - 0.8) * 0.5, 0.0, 1.0);
    let border_colour = vec3f(select(1.0, 0.0, view.selection.g > 0.5));
    return vec4f(mix(border_colour, view.selection.rgb, line), max(line, border * 0.85));
}
