// Culls each robot, computes its pose and colour, and puts it into a draw list by its level of detail: mesh, block or
// flat mark.

struct Body {
    // Local position on the ground.
    x: f32,
    y: f32,
    // Cosine and sine of the heading, 2 x 16 bits.
    heading: u32,
    // Red, green, blue (linear), 8 bits each.
    colour: u32,
    // Length and width, height: 16-bit floats.
    size: u32,
    height: u32,
    id: u32,
}

struct Draw {
    // Marks count three vertices each and tiles six, all of one instance.
    indices: atomic<u32>,
    instances: atomic<u32>,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

const MESHES = 8u;
const MESH_CAPACITY = 8192u;
// Lists after those of the meshes: boxes, round blocks, marks, tiles of the picture that have marks.
const BLOCKS = 8u;
const BLOCK_CAPACITY = 131072u;
const MARKS = 10u;
const TILES = 11u;

@group(2) @binding(0) var<storage, read_write> bodies: array<Body>;
@group(2) @binding(1) var<storage, read_write> corners: array<Corner>;
@group(2) @binding(2) var<storage, read_write> mark_ids: array<u32>;
@group(2) @binding(3) var<storage, read_write> draws: array<Draw, 12>;
// Pixels of the picture row by row, then tiles; see splats.wgsl.
@group(2) @binding(4) var<storage, read_write> pixels: array<atomic<u32>>;

// Whether this shader splats marks into pixels instead of emitting triangles: a software adapter does that on all its
// SIMD lanes.
override SPLATS = false;
// Whether robots that are small in the picture are added to the density rather than marked.
override DENSITY = false;

// What would else be decided for each robot anew. A software adapter carries all branches out, and loads are dear there.
// What robots are coloured by: as `view.source`.
override SOURCE = 0u;
// As `view.filtered`. Bit 0: robots that don't match a filter are dimmed. Bit 1: robots of other levels than the picture's are hidden.
// Bit 2: all are dimmed over a heat map.
override FILTERED = 0u;
// Whether a robot may be large enough for a block or a mesh.
override BODIES = true;

// A mark in the picture, in pixels.
struct Mark {
    middle: vec2f,
    // From the middle to the front, and to the left.
    axis: vec2f,
    side: vec2f,
    is_round: bool,
}

// The largest width and height of a mark in pixels. Larger robots are blocks, unless there are too many of those.
const MARK_PIXELS = 64;

// Whether a mark covers the point `away` from its middle, in units of its axis and side. The same shapes as in
// robots.wgsl.
fn covers(is_round: bool, away: vec2f) -> bool {
    let from_notch = away - vec2f(0.55, 0.0);
    let in_circle = (dot(away, away) <= 1.0) & (dot(from_notch, from_notch) >= 0.06);
    let in_dart = (away.x >= -1.0) & (2.0 * abs(away.y) <= 1.0 - away.x);
    return select(in_dart, in_circle, is_round);
}

fn splat(mark: Mark, key: u32) {
    let size = vec2i(view.viewport.xy);
    let half_size = abs(mark.axis) + abs(mark.side);
    // The first pixel whose centre the mark can cover, and one past the last.
    let low = max(vec2i(ceil(mark.middle - half_size - 0.5)), vec2i(0));
    let top = vec2i(ceil(mark.middle + half_size - 0.5));
    let high = min(min(top, size), low + MARK_PIXELS);
    if any(high <= low) {
        return;
    }
    let per_axis = mark.axis / dot(mark.axis, mark.axis);
    let per_side = mark.side / dot(mark.side, mark.side);
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            let away = vec2f(f32(x), f32(y)) + 0.5 - mark.middle;
            if covers(mark.is_round, vec2f(dot(away, per_axis), dot(away, per_side))) {
                atomicMax(&pixels[y * size.x + x], key);
            }
        }
    }
    let tiles = (size + i32(TILE) - 1) / i32(TILE);
    let first = low / i32(TILE);
    let last = (high - 1) / i32(TILE);
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let number = y * tiles.x + x;
            let flag = size.x * size.y + number;
            if atomicLoad(&pixels[flag]) == 0u {
                if atomicExchange(&pixels[flag], 1u) == 0u {
                    let slot = i32(atomicAdd(&draws[TILES].indices, 6u) / 6u);
                    atomicStore(&pixels[size.x * size.y + tiles.x * tiles.y + slot], u32(number));
                }
            }
        }
    }
}

// Reserves a slot in a list; the result is not below `capacity` if the list is full.
fn reserve(list: u32, capacity: u32) -> u32 {
    let slot = atomicAdd(&draws[list].instances, 1u);
    if slot >= capacity {
        atomicSub(&draws[list].instances, 1u);
    }
    return slot;
}

// Emits the flat mark of a robot: a dart with its tip ahead, or a circle.
fn mark(i: u32, at: vec2f, heading: vec2f, robot_type: RobotType, depth: f32, colour: u32) {
    // Each robot has its own height, so that overlapping marks don't flicker. Higher categories are above lower ones.
    var rank = 0.0;
    if SOURCE == 0u {
        rank = select(0.0, clamp((value_of(i) - view.low) * view.per_span, 0.0, 1.0), view.categories == 1u);
    }
    let own = fract(f32(i) * 0.6180339887);
    let layer = robot_type.height * (0.2 + 0.3 * own + 0.5 * rank);
    let clip = clip_from(vec3f(at, layer));
    let tip = clip_from(vec3f(at + heading * 0.5 * robot_type.length, layer));
    let edge = clip_from(vec3f(at + vec2f(-heading.y, heading.x) * 0.5 * robot_type.width, layer));
    let ndc = clip.xyz / clip.w;
    let half_size = view.viewport.xy * 0.5;
    var axis = (tip.xy / tip.w - ndc.xy) * half_size;
    let across = (edge.xy / edge.w - ndc.xy) * half_size;
    // Where robots are smaller than pixels, smaller marks keep them apart.
    let pixels_long = robot_type.length * view.eye.w / depth;
    let least = view.detail.z * mix(0.34, 0.5, clamp(pixels_long - 0.4, 0.0, 1.0));
    let reach = max(length(axis), 1e-6);
    let width = max(abs(axis.x * across.y - axis.y * across.x) / reach, least * 0.6);
    axis *= max(least / reach, 1.0);
    let side = vec2f(-axis.y, axis.x) / max(length(axis), 1e-6) * width;
    let is_round = (robot_type.flags & 1u) != 0u;
    if !SPLATS {
        triangle(i, ndc, axis, side, is_round, colour);
        return;
    }
    if i < arrayLength(&corners) {
        corners[i].depth = ndc.z;
        corners[i].colour = colour;
        let middle = (ndc.xy * vec2f(0.5, -0.5) + 0.5) * view.viewport.xy;
        let down = vec2f(1.0, -1.0);
        splat(Mark(middle, axis * down, side * down, is_round), key_of(depth, layer, i));
    }
}

// Emits a mark's triangle; for a circle, the triangle around it.
fn triangle(i: u32, middle: vec3f, axis: vec2f, side: vec2f, is_round: bool, colour: u32) {
    let per_pixel = 2.0 * view.viewport.zw;
    let aside = side * select(1.0, 1.7320508, is_round);
    let left = middle.xy + (aside - axis) * per_pixel;
    let right = middle.xy - (aside + axis) * per_pixel;
    let front = middle.xy + axis * select(1.0, 2.0, is_round) * per_pixel;
    let paint = colour | select(0u, 0xff000000u, is_round);
    let depth = set_apart(middle.z, i);
    let slot = atomicAdd(&draws[MARKS].indices, 3u);
    if slot + 3u > arrayLength(&corners) {
        atomicSub(&draws[MARKS].indices, 3u);
        return;
    }
    corners[slot] = Corner(left.x, left.y, depth, paint);
    corners[slot + 1u] = Corner(right.x, right.y, depth, paint);
    corners[slot + 2u] = Corner(front.x, front.y, depth, paint);
    mark_ids[slot / 3u] = i;
}

// Whether a robot of a length in pixels is part of the density. Between the two ends of the fade, each robot changes over at a
// size of its own.
fn is_in_field(i: u32, pixels: f32) -> bool {
    let marked = clamp((pixels - view.density.x) / (view.density.y - view.density.x), 0.0, 1.0);
    return fract(f32(i) * 0.6180339887) >= marked;
}

// Adds a robot to the density.
fn add(local: vec3f, colour: vec3f) {
    let clip = clip_from(local);
    let at = (clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5) * view.viewport.xy;
    if any(at < vec2f(0.0)) || any(at >= view.viewport.xy) {
        return;
    }
    let cell = vec2u(at) / CELL;
    let first = first_cell(SPLATS) + 4u * (cell.y * cells().x + cell.x);
    let steps = vec3u(colour * COLOUR_STEPS + 0.5);
    atomicAdd(&pixels[first], steps.r);
    atomicAdd(&pixels[first + 1u], steps.g);
    atomicAdd(&pixels[first + 2u], steps.b);
    atomicAdd(&pixels[first + 3u], 1u);
}

// The colour of a robot, as `colour_of`.
fn own_colour_of(i: u32, state: u32) -> vec3f {
    var at = f32(state);
    if SOURCE == 0u {
        at = value_of(i);
    }
    if SOURCE == 2u {
        at = f32(robot_type_of(i) % 16u);
    }
    let colour = select(view.unknown.rgb, shade_of(at), (SOURCE != 0u) | (i < u32(view.detail.w)));
    if (FILTERED & 5u) != 0u {
        let shown = select(1.0, OVER_HEAT, (FILTERED & 4u) != 0u);
        return mix(view.floor.rgb, colour, select(DIMMED, shown, matches(i)));
    }
    return colour;
}

// Whether a robot is drawn, as far as its place doesn't matter.
fn is_shown(i: u32, state: u32) -> bool {
    if (FILTERED & 2u) != 0u {
        return state != ABSENT && bit_of(i, 1u);
    }
    return state != ABSENT;
}

@compute @workgroup_size(64)
fn sort(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= view.robots {
        return;
    }
    let state = state_of(i);
    if !is_shown(i, state) {
        return;
    }
    let pose = pose_of(i);
    let heading = vec2f(cos(pose.z), sin(pose.z));
    let local = vec3f(pose.xy, 0.0);
    let robot_type = robot_types[min(robot_type_of(i), 63u)];
    let depth = dot(local - view.eye.xyz, view.forward.xyz);
    let scale = view.eye.w / max(depth, 0.05);
    let pixels = max(robot_type.length, robot_type.width) * scale;

    // A comparison with NaN is false: a robot without a position is not drawn.
    let radius = max(length(vec2f(robot_type.length, robot_type.width)) + robot_type.height, view.detail.z / scale);
    for (var side = 0; side < 4; side++) {
        if !(dot(view.planes[side].xyz, local - view.eye.xyz) > -radius) {
            return;
        }
    }
    let own_colour = own_colour_of(i, state);
    if DENSITY {
        if is_in_field(i, pixels) && depth >= 0.05 {
            add(local, own_colour);
            return;
        }
    }
    let colour = pack4x8unorm(vec4f(own_colour, 0.0));

    if BODIES && pixels >= max(view.detail.y, view.detail.z) {
        var body = Body(local.x, local.y, pack2x16snorm(heading), colour, 0u, 0u, i);
        if pixels >= view.detail.x {
            let mesh = min(robot_type.flags >> 8u, MESHES - 1u);
            let slot = reserve(mesh, MESH_CAPACITY);
            if slot < MESH_CAPACITY {
                let own = (robot_type.flags & 2u) != 0u;
                body.size = pack2x16float(select(vec2f(robot_type.length, robot_type.width), vec2f(1.0), own));
                body.height = pack2x16float(vec2f(select(robot_type.height, 1.0, own), 0.0));
                bodies[mesh * MESH_CAPACITY + slot] = body;
                return;
            }
        }
        let is_round = robot_type.flags & 1u;
        let slot = reserve(BLOCKS + is_round, BLOCK_CAPACITY);
        if slot < BLOCK_CAPACITY {
            body.size = pack2x16float(vec2f(robot_type.length, robot_type.width));
            body.height = pack2x16float(vec2f(robot_type.height, 0.0));
            bodies[MESHES * MESH_CAPACITY + is_round * BLOCK_CAPACITY + slot] = body;
            return;
        }
    }
    if depth >= 0.05 {
        mark(i, local.xy, heading, robot_type, depth, colour);
    }
}

// In place of `sort` if every robot in sight is part of the density: without marks, blocks and meshes.
@compute @workgroup_size(64)
fn add_all(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= view.robots {
        return;
    }
    let state = state_of(i);
    if !is_shown(i, state) {
        return;
    }
    let local = vec3f(pose_of(i).xy, 0.0);
    if dot(local - view.eye.xyz, view.forward.xyz) >= 0.05 {
        add(local, own_colour_of(i, state));
    }
}
