// The fleet's columns, and what they say of a robot.

struct RobotType {
    length: f32,
    width: f32,
    height: f32,
    // Bit 0: a circle. From bit 8 on: which mesh. Bit 1: the mesh has its own size.
    look: u32,
}

const ABSENT = 255u;

// x, y and heading, each a column.
@group(1) @binding(0) var<storage, read> previous: array<f32>;
@group(1) @binding(1) var<storage, read> current: array<f32>;
// Values, types and states, each a column; four states in a word.
@group(1) @binding(2) var<storage, read> attributes: array<u32>;
@group(1) @binding(3) var<uniform> types: array<RobotType, 64>;

fn rows() -> u32 {
    return arrayLength(&current) / 3u;
}

fn state_of(i: u32) -> u32 {
    return extractBits(attributes[2u * rows() + i / 4u], (i % 4u) * 8u, 8u);
}

fn kind_of(i: u32) -> u32 {
    return u32(bitcast<f32>(attributes[rows() + i]));
}

fn value_of(i: u32) -> f32 {
    return bitcast<f32>(attributes[i]);
}

// Local position and heading at the moment that is shown.
fn pose_of(i: u32) -> vec3f {
    let stride = rows();
    var position = vec2f(current[i], current[stride + i]);
    var theta = current[2u * stride + i];
    if (i < view.previous_robots) & (view.alpha < 1.0) {
        let before = vec2f(previous[i], previous[stride + i]);
        let way = position - before;
        if dot(way, way) < view.jump * view.jump {
            position = before + way * view.alpha;
            let turn = theta - previous[2u * stride + i];
            // The short way round.
            theta -= (turn - round(turn / 6.2831853) * 6.2831853) * (1.0 - view.alpha);
        }
    }
    return vec3f(position - view.origin.xy, theta);
}

fn colour_of(i: u32) -> vec3f {
    let by_state = view.source == 1u;
    let by_kind = view.source == 2u;
    if !(by_state | by_kind | (i < u32(view.detail.w))) {
        return view.unknown.rgb;
    }
    let at = select(select(value_of(i), f32(state_of(i)), by_state), f32(kind_of(i) % 16u), by_kind);
    let category = view.palette[u32(clamp(at, 0.0, 15.0))].rgb;
    let place = clamp((at - view.low) * view.per_span, 0.0, 1.0) * 15.0;
    let below = min(u32(place), 14u);
    let ramp = mix(view.palette[below].rgb, view.palette[below + 1u].rgb, place - f32(below));
    return select(ramp, category, view.categories == 1u);
}
