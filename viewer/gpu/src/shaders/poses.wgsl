// The fleet's columns, and accessors for a robot's row.

struct RobotType {
    length: f32,
    width: f32,
    height: f32,
    // Bit 0: round. Bit 1: the mesh has its own size. From bit 8 on: the mesh's number.
    flags: u32,
}

const ABSENT = 255u;

// The columns x, y and theta.
@group(1) @binding(0) var<storage, read> previous: array<f32>;
@group(1) @binding(1) var<storage, read> current: array<f32>;
// The columns of values, robot types and states, four states per word; then two rows of
// bits: whether a robot matches the filter, and whether it is on the level that is shown.
@group(1) @binding(2) var<storage, read> attributes: array<u32>;
@group(1) @binding(3) var<uniform> robot_types: array<RobotType, 64>;

// The length of each column.
fn rows() -> u32 {
    return arrayLength(&current) / 3u;
}

fn state_of(i: u32) -> u32 {
    return extractBits(attributes[2u * rows() + i / 4u], (i % 4u) * 8u, 8u);
}

fn robot_type_of(i: u32) -> u32 {
    return u32(bitcast<f32>(attributes[rows() + i]));
}

fn value_of(i: u32) -> f32 {
    return bitcast<f32>(attributes[i]);
}

// The local position and the heading, interpolated between the two frames.
fn pose_of(i: u32) -> vec3f {
    let stride = rows();
    var position = vec2f(current[i], current[stride + i]);
    var theta = current[2u * stride + i];
    if (i < view.previous_robots) & (view.alpha < 1.0) {
        let before = vec2f(previous[i], previous[stride + i]);
        let motion = position - before;
        if dot(motion, motion) < view.teleport_distance * view.teleport_distance {
            position = before + motion * view.alpha;
            let turn = theta - previous[2u * stride + i];
            // The heading turns by the smaller angle.
            theta -= (turn - round(turn / 6.2831853) * 6.2831853) * (1.0 - view.alpha);
        }
    }
    return vec3f(position - view.origin.xy, theta);
}

// How much of a robot's colour is left if it doesn't match the filter.
const DIMMED = 0.16;
// How much of it is left over a heat map.
const OVER_HEAT = 0.45;

// A robot's bit in one of the rows of bits.
fn bit_of(i: u32, row: u32) -> bool {
    let stride = rows();
    return extractBits(attributes[2u * stride + stride / 4u + row * (stride / 32u) + i / 32u], i % 32u, 1u) == 1u;
}

// Here and below, both sides are evaluated: Mesa's software driver (22.3) compiles a shader that branches on a uniform alone
// anew for each picture, and never frees it.
fn matches(i: u32) -> bool {
    return ((view.filtered & 1u) == 0u) | bit_of(i, 0u);
}

// Whether a robot isn't shown: it is on another level than the picture's.
fn is_hidden(i: u32) -> bool {
    return ((view.filtered & 2u) != 0u) & !bit_of(i, 1u);
}

fn colour_of(i: u32) -> vec3f {
    let shown = select(1.0, OVER_HEAT, (view.filtered & 4u) != 0u);
    return mix(view.floor.rgb, undimmed_colour_of(i), select(DIMMED, shown, matches(i)));
}

fn undimmed_colour_of(i: u32) -> vec3f {
    let by_state = view.source == 1u;
    let by_type = view.source == 2u;
    let at = select(select(value_of(i), f32(state_of(i)), by_state), f32(robot_type_of(i) % 16u), by_type);
    return select(view.unknown.rgb, shade_of(at), by_state | by_type | (i < u32(view.detail.w)));
}

// The colour of a value or of a category.
fn shade_of(at: f32) -> vec3f {
    // Four steps between two colours of a ramp, of which there are 16.
    let step = clamp((at - view.low) * view.per_span, 0.0, 1.0) * 60.0 + 0.5;
    let shade = min(u32(select(step, clamp(at, 0.0, 15.0), view.categories == 1u)), 63u);
    return unpack4x8unorm(view.palette[shade / 4u][shade % 4u]).rgb;
}
