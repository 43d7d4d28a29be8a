// For each robot: where it is now, its colour, and whether it is drawn as a mesh, a block, a flat mark or not at all.

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

// A corner of a mark's triangle: ready to be drawn, as instances of three corners keep a GPU's lanes idle and a
// processor that draws busy.
struct Corner {
    // Place in the whole picture, and depth.
    x: f32,
    y: f32,
    depth: f32,
    // Red, green, blue (linear), and 1 for a circle, 8 bits each.
    colour: u32,
}

struct Draw {
    // Of marks: three corners for each, drawn as one instance.
    indices: atomic<u32>,
    instances: atomic<u32>,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

const MESHES = 8u;
const MESH_CAPACITY = 8192u;
// After the meshes: boxes, round blocks, marks.
const BLOCKS = 8u;
const BLOCK_CAPACITY = 131072u;
const MARKS = 10u;

@group(2) @binding(0) var<storage, read_write> bodies: array<Body>;
@group(2) @binding(1) var<storage, read_write> corners: array<Corner>;
@group(2) @binding(2) var<storage, read_write> mark_ids: array<u32>;
@group(2) @binding(3) var<storage, read_write> draws: array<Draw, 11>;

// Takes a place in a list, if there is one.
fn place_in(list: u32, capacity: u32) -> u32 {
    let place = atomicAdd(&draws[list].instances, 1u);
    if place >= capacity {
        atomicSub(&draws[list].instances, 1u);
    }
    return place;
}

@compute @workgroup_size(64)
fn sort(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= view.robots {
        return;
    }
    if state_of(i) == ABSENT {
        return;
    }
    let pose = pose_of(i);
    let heading = vec2f(cos(pose.z), sin(pose.z));
    let local = vec3f(pose.xy, 0.0);
    let look = types[min(kind_of(i), 63u)];
    let depth = dot(local - view.eye.xyz, view.forward.xyz);
    let scale = view.eye.w / max(depth, 0.05);
    let pixels = look.length * scale;

    // Not a number compares false: such a robot is nowhere.
    let radius = max(length(vec2f(look.length, look.width)) + look.height, view.detail.z / scale);
    for (var side = 0; side < 4; side++) {
        if !(dot(view.planes[side].xyz, local - view.eye.xyz) > -radius) {
            return;
        }
    }
    let colour = pack4x8unorm(vec4f(colour_of(i), 0.0));

    if pixels >= max(view.detail.y, view.detail.z) {
        var body = Body(local.x, local.y, pack2x16snorm(heading), colour, 0u, 0u, i);
        if pixels >= view.detail.x {
            let mesh = min(look.look >> 8u, MESHES - 1u);
            let place = place_in(mesh, MESH_CAPACITY);
            if place < MESH_CAPACITY {
                let own = (look.look & 2u) != 0u;
                body.size = pack2x16float(select(vec2f(look.length, look.width), vec2f(1.0), own));
                body.height = pack2x16float(vec2f(select(look.height, 1.0, own), 0.0));
                bodies[mesh * MESH_CAPACITY + place] = body;
                return;
            }
        }
        let is_round = look.look & 1u;
        let place = place_in(BLOCKS + is_round, BLOCK_CAPACITY);
        if place < BLOCK_CAPACITY {
            body.size = pack2x16float(vec2f(look.length, look.width));
            body.height = pack2x16float(vec2f(look.height, 0.0));
            bodies[MESHES * MESH_CAPACITY + is_round * BLOCK_CAPACITY + place] = body;
            return;
        }
    }
    if depth < 0.05 {
        return;
    }
    // Each at a height of its own, so that which one is in front doesn't change from picture to picture; those with
    // a higher colour's number above the others.
    let rank = select(0.0, clamp((value_of(i) - view.low) * view.per_span, 0.0, 1.0), view.categories == 1u);
    let layer = look.height * (0.2 + 0.3 * fract(f32(i) * 0.6180339887) + 0.5 * rank);
    let clip = clip_from(vec3f(local.xy, layer));
    let tip = clip_from(vec3f(local.xy + heading * 0.5 * look.length, layer));
    let side = clip_from(vec3f(local.xy + vec2f(-heading.y, heading.x) * 0.5 * look.width, layer));
    let half_size = view.viewport.xy * 0.5;
    var axis = (tip.xy / tip.w - clip.xy / clip.w) * half_size;
    let across = (side.xy / side.w - clip.xy / clip.w) * half_size;
    // Robots that share pixels with many others are drawn finer.
    let least = view.detail.z * mix(0.34, 0.5, clamp(pixels - 0.4, 0.0, 1.0));
    let reach = max(length(axis), 1e-6);
    let width = max(abs(axis.x * across.y - axis.y * across.x) / reach, least * 0.6);
    axis *= max(least / reach, 1.0);
    // A dart: its two ends behind, its tip ahead; around a circle, a triangle that holds it.
    let is_round = (look.look & 1u) != 0u;
    let ahead = axis * select(1.0, 2.0, is_round);
    let aside = vec2f(-axis.y, axis.x) / max(length(axis), 1e-6) * width * select(1.0, 1.7320508, is_round);
    let ndc = clip.xyz / clip.w;
    let per_pixel = 2.0 * view.viewport.zw;
    let left = ndc.xy + (aside - axis) * per_pixel;
    let right = ndc.xy - (aside + axis) * per_pixel;
    let front = ndc.xy + ahead * per_pixel;
    let paint = colour | select(0u, 0xff000000u, is_round);
    let place = atomicAdd(&draws[MARKS].indices, 3u);
    corners[place] = Corner(left.x, left.y, ndc.z, paint);
    corners[place + 1u] = Corner(right.x, right.y, ndc.z, paint);
    corners[place + 2u] = Corner(front.x, front.y, ndc.z, paint);
    mark_ids[place / 3u] = i;
}
