// The route graph: ribbons along the Bézier curves of edges, arrows, and nodes. Compute shaders choose what is drawn,
// and with how many segments.

// Widths in metres of edges, arrows and nodes near the camera.
const EDGE_METRES = 0.07;
const ARROW_METRES = 0.34;
const NODE_METRES = 0.11;
// The least and the greatest width of edges in pixels.
const EDGE_PIXELS = vec2f(1.2, 5.0);

// --- Sorting into draw lists.

struct Draw {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

// The draw lists; the same as in graph.rs. Curves that are ribbons of the heat map are drawn for picking only.
const FAR = 0u;
const STRAIGHT = 1u;
const ARROWS = 5u;
const NODES = 6u;
const HOT_FAR = 7u;
const HOT_NEAR = 8u;
const LISTS = 9u;
// The vertices of an entry of each list, in pictures and for picking: a line; a quad; strips of 9, 33 and 129 points; two
// triangles; a quad.
const VERTICES = array<u32, 9>(2, 6, 18, 66, 258, 6, 6, 0, 0);
const PICK_VERTICES = array<u32, 9>(6, 6, 66, 66, 66, 6, 6, 6, 66);

@group(2) @binding(0) var<storage, read_write> lists: array<u32>;
// The lists of each curve and then of each node, as bits.
@group(2) @binding(1) var<storage, read_write> masks: array<u32>;
// Of pictures, then of picking.
@group(2) @binding(2) var<storage, read_write> draws: array<Draw, 18>;
// A bit per curve: whether it is a ribbon of the heat map.
@group(2) @binding(3) var<storage, read> hot: array<u32>;

// The room of each list: for all curves; for all nodes in theirs. The same as in graph.rs: lists are bound one by one.
fn list_room() -> u32 {
    return (max(arrayLength(&curves), arrayLength(&nodes)) + 63u) / 64u * 64u;
}

// Draws a list. Entries of few vertices are all of one instance.
fn draw_of(count: u32, vertices: u32) -> Draw {
    let is_flat = vertices <= 6u;
    return Draw(vertices * select(1u, count, is_flat), select(count, 1u, is_flat), 0u, 0u);
}

// The invocations that fill the lists.
const WORKERS = 256u;
// By list and worker: the number of its entries, and then where they begin.
var<workgroup> starts: array<u32, 2304>;

// Fills the lists in the order of curves and nodes, and writes the arguments of draws. A single workgroup, so that overlapping
// edges are blended in the same order in each picture: with a slot for whoever comes first, films would differ.
@compute @workgroup_size(256)
fn fill_lists(@builtin(local_invocation_index) worker: u32) {
    let all_curves = arrayLength(&curves);
    let all = all_curves + arrayLength(&nodes);
    let share = (all + WORKERS - 1u) / WORKERS;
    let first = min(worker * share, all);
    let end = min(first + share, all);
    var next: array<u32, 9>;
    for (var i = first; i < end; i++) {
        for (var mask = masks[i]; mask != 0u; mask &= mask - 1u) {
            next[firstTrailingBit(mask)] += 1u;
        }
    }
    for (var list = 0u; list < LISTS; list++) {
        starts[list * WORKERS + worker] = next[list];
    }
    workgroupBarrier();
    if worker < LISTS {
        var vertices = VERTICES;
        var pick_vertices = PICK_VERTICES;
        var count = 0u;
        for (var other = 0u; other < WORKERS; other++) {
            let entries = starts[worker * WORKERS + other];
            starts[worker * WORKERS + other] = count;
            count += entries;
        }
        draws[worker] = draw_of(count, vertices[worker]);
        draws[LISTS + worker] = draw_of(count, pick_vertices[worker]);
    }
    workgroupBarrier();
    for (var list = 0u; list < LISTS; list++) {
        next[list] = starts[list * WORKERS + worker];
    }
    for (var i = first; i < end; i++) {
        for (var mask = masks[i]; mask != 0u; mask &= mask - 1u) {
            let list = firstTrailingBit(mask);
            lists[list * list_room() + next[list]] = select(i - all_curves, i, i < all_curves);
            next[list] += 1u;
        }
    }
}

@compute @workgroup_size(64)
fn sort_curves(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= arrayLength(&curves) {
        return;
    }
    masks[i] = lists_of(i);
}

// The lists of a curve, as bits.
fn lists_of(i: u32) -> u32 {
    let curve = curves[i];
    let low = min(min(curve.start, curve.end), min(curve.control_a, curve.control_b)) - view.origin.xy;
    let high = max(max(curve.start, curve.end), max(curve.control_a, curve.control_b)) - view.origin.xy;
    let middle = (low + high) * 0.5;
    let radius = length(high - low) * 0.5;
    if !inside(middle, radius + 1.0) {
        return 0u;
    }
    var mask = 0u;
    let nearest = max(dot(vec3f(middle, 0.0) - view.eye.xyz, view.forward.xyz) - radius, 0.05);
    let pixels = curve.length * view.eye.w / nearest;
    let bent = bend_of(curve) * view.eye.w / nearest;
    // Of the whole edge: an edge of many short curves is visible from as far away as one of a single curve.
    let edge_pixels = curve.edge_length * view.eye.w / nearest;
    if edge_pixels > 0.4 {
        let near = 1u + u32(bent >= 0.5) + u32(bent >= 12.0) + u32(bent >= 120.0);
        // Straight curves are thin lines up to a greater length.
        let thin = pixels < select(min(view.spacing.w, 8.0), view.spacing.w, near == STRAIGHT);
        // Its ribbon covers it.
        let is_hot = (extractBits(hot[i / 32u], i % 32u, 1u) & view.heated) == 1u;
        mask = 1u << select(select(near, FAR, thin), select(HOT_NEAR, HOT_FAR, thin | (near == STRAIGHT)), is_hot);
    }
    if edge_pixels > 36.0 && curve.arrow >= 0.0 {
        mask |= 1u << ARROWS;
    }
    return mask;
}

@compute @workgroup_size(64)
fn sort_nodes(@builtin(global_invocation_id) at: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = at.x + at.y * groups.x * 64u;
    if i >= arrayLength(&nodes) {
        return;
    }
    let local = vec2f(nodes[i].x, nodes[i].y) - view.origin.xy;
    let is_shown = inside(local, 1.0) && metres_per_pixel(vec3f(local, 0.0)) < NODE_METRES;
    masks[arrayLength(&curves) + i] = select(0u, 1u << NODES, is_shown);
}

// --- Drawing.

// The list that is drawn.
@group(2) @binding(0) var<storage, read> shown: array<u32>;

fn edge_colour(curve: Curve) -> vec3f {
    return select(view.edge.rgb, view.two_way.rgb, curve.reverse_speed > 0.0);
}

// The opacity of edges: lower far away, where many edges share a pixel.
fn edge_alpha(local: vec2f) -> f32 {
    return clamp(0.22 / metres_per_pixel(vec3f(local, 0.0)), 0.30, 1.0);
}

struct Ribbon {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
    // Distance from the middle line and half the width, in pixels.
    @location(1) @interpolate(linear) across: f32,
    @location(2) half_width: f32,
    @location(3) @interpolate(flat) id: u32,
}

// A vertex of a strip that has two vertices for each of the curve's points.
fn ribbon(index: u32, vertex: u32, points: u32, least: f32) -> Ribbon {
    let curve = curves[index];
    let at = f32(vertex / 2u) / f32(points - 1u);
    let spine = spine(curve, at);
    let local = spine.local;
    let half_width = max(clamp(EDGE_METRES / metres_per_pixel(vec3f(local, 0.0)), EDGE_PIXELS.x, EDGE_PIXELS.y), least) * 0.5;
    let across = select(-1.0, 1.0, (vertex & 1u) == 1u) * (half_width + 0.5);
    let colour = vec4f(edge_colour(curve), edge_alpha(local));
    return Ribbon(beside(spine, across), colour, across, half_width, curve.edge);
}

@vertex
fn edge_far(@builtin(vertex_index) vertex: u32) -> Ribbon {
    let curve = curves[shown[vertex / 2u]];
    let local = select(curve.start, curve.end, vertex % 2u == 1u) - view.origin.xy;
    let clip = clip_from(vec3f(local, 0.0));
    // A line has no antialiased border and looks stronger than a ribbon, so it is fainter.
    return Ribbon(cropped(clip), vec4f(edge_colour(curve), edge_alpha(local) * 0.8), 0.0, 0.5, curve.edge);
}

@vertex
fn edge_straight(@builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[vertex / 6u], quad_corner(vertex), 2u, 0.0);
}

@vertex
fn edge_bent(@builtin(instance_index) entry: u32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[entry], vertex, 9u, 0.0);
}

@vertex
fn edge_curved(@builtin(instance_index) entry: u32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[entry], vertex, 33u, 0.0);
}

@vertex
fn edge_near(@builtin(instance_index) entry: u32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[entry], vertex, 129u, 0.0);
}

@fragment
fn ribbon_fill(in: Ribbon) -> @location(0) vec4f {
    let cover = clamp(in.half_width + 0.5 - abs(in.across), 0.0, 1.0);
    return vec4f(in.colour.rgb, in.colour.a * cover);
}

// Picking draws wider ribbons, which are easier to hit.
@vertex
fn edge_id(@builtin(instance_index) entry: u32, @builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[entry], vertex, 33u, 7.0);
}

@vertex
fn edge_id_straight(@builtin(vertex_index) vertex: u32) -> Ribbon {
    return ribbon(shown[vertex / 6u], quad_corner(vertex), 2u, 7.0);
}

@fragment
fn ribbon_id(in: Ribbon) -> @location(0) u32 {
    return in.id | 0x40000000u;
}

struct Flat {
    @builtin(position) clip: vec4f,
    @location(0) colour: vec4f,
    @location(1) position: vec2f,
    @location(2) @interpolate(flat) id: u32,
}

// Draws an arrow in the edge's direction, and a second one in the opposite direction on two-way edges.
@vertex
fn arrow(@builtin(vertex_index) vertex: u32) -> Flat {
    let index = shown[vertex / 6u];
    let curve = curves[index];
    let both = curve.reverse_speed > 0.0;
    let back = vertex % 6u >= 3u;
    // Two arrows are apart by an eighth of the edge, of which the curve may be a part.
    let apart = min(0.06 * curve.edge_length / max(curve.length, 1e-6), 0.5);
    let at = clamp(curve.arrow + select(0.0, select(apart, -apart, back), both), 0.0, 1.0);
    let local = point_at(curve, at) - view.origin.xy;
    let direction = normalize(tangent(curve, at)) * select(1.0, -1.0, back);
    let pixel = metres_per_pixel(vec3f(local, 0.0));
    let size = clamp(ARROW_METRES, 6.0 * pixel, 16.0 * pixel) * select(1.0, 0.0, back && !both);
    let corner = vertex % 3u;
    let along = select(-0.5, 0.6, corner == 2u);
    let across = (f32(corner == 0u) - f32(corner == 1u)) * 0.42;
    let ground = local + (direction * along + vec2f(-direction.y, direction.x) * across) * size;
    let colour = vec4f(mix(edge_colour(curve), view.node.rgb, 0.45), clamp(0.4 / pixel * 0.1, 0.55, 1.0));
    return Flat(cropped(clip_from(vec3f(ground, 0.0))), colour, vec2f(0.0), index);
}

@fragment
fn flat_fill(in: Flat) -> @location(0) vec4f {
    return in.colour;
}

fn disc(index: u32, corner: u32, least: f32) -> Flat {
    let node = nodes[index];
    let local = vec2f(node.x, node.y) - view.origin.xy;
    let pixel = metres_per_pixel(vec3f(local, 0.0));
    let radius = max(clamp(NODE_METRES, 1.5 * pixel, 7.0 * pixel), least * pixel);
    let unit = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let outer = radius + pixel;
    let ground = local + unit * outer;
    let near = clamp((NODE_METRES / pixel - 1.0) * 0.5, 0.0, 1.0);
    return Flat(cropped(clip_from(vec3f(ground, 0.0))), vec4f(view.node.rgb, near), unit * outer / radius, index);
}

@vertex
fn node(@builtin(vertex_index) vertex: u32) -> Flat {
    return disc(shown[vertex / 6u], quad_corner(vertex), 0.0);
}

@fragment
fn disc_fill(in: Flat) -> @location(0) vec4f {
    let away = length(in.position);
    let cover = clamp((1.0 - away) / max(fwidth(away), 1e-4) + 0.5, 0.0, 1.0);
    // The middle of the disc has the floor's colour.
    let middle = clamp((0.55 - away) / max(fwidth(away), 1e-4) + 0.5, 0.0, 1.0);
    return vec4f(mix(in.colour.rgb, view.floor.rgb, middle), in.colour.a * cover);
}

@vertex
fn node_id(@builtin(vertex_index) vertex: u32) -> Flat {
    return disc(shown[vertex / 6u], quad_corner(vertex), 5.0);
}

@fragment
fn disc_id(in: Flat) -> @location(0) u32 {
    if dot(in.position, in.position) > 1.0 {
        discard;
    }
    return in.id | 0x80000000u;
}
