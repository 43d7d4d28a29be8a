// Draws robots as meshes, blocks and flat marks, their shadows, and their ids for picking.

struct Vertex {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) colour: vec3f,
    @location(2) local: vec3f,
    // The share of the robot's own colour.
    @location(3) own: f32,
}

struct Id {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) id: u32,
}

fn rotated(heading: vec2f, point: vec2f) -> vec2f {
    return vec2f(heading.x * point.x - heading.y * point.y, heading.y * point.x + heading.x * point.y);
}

struct Instance {
    @location(0) at: vec2f,
    @location(1) heading: vec2f,
    @location(2) colour: vec4f,
    @location(3) size: vec2f,
    @location(4) height: vec2f,
    @location(5) id: u32,
}

fn clip_of(instance: Instance, local: vec3f) -> vec4f {
    let clip = clip_from(local);
    return cropped(vec4f(clip.xy, set_apart(clip.z, instance.id), clip.w));
}

fn placed(instance: Instance, point: vec3f) -> vec3f {
    let scaled = point * vec3f(instance.size, instance.height.x);
    return vec3f(instance.at + rotated(instance.heading, scaled.xy), scaled.z);
}

// `paint` is red, green, blue, and the share of the robot's own colour.
@vertex
fn body(instance: Instance, @location(6) point: vec3f, @location(7) normal: vec4f, @location(8) paint: vec4f) -> Vertex {
    let local = placed(instance, point);
    // A mesh that is scaled by a vector has its normals divided by it.
    let across = normal.xyz / vec3f(instance.size, instance.height.x);
    let facing = normalize(vec3f(rotated(instance.heading, across.xy), across.z));
    let colour = mix(paint.rgb, instance.colour.rgb, paint.a);
    return Vertex(clip_of(instance, local), facing, colour, local, paint.a);
}

@fragment
fn shaded(in: Vertex) -> @location(0) vec4f {
    let normal = normalize(in.normal);
    let towards = normalize(view.eye.xyz - in.local);
    let half_way = normalize(towards + view.sun.xyz);
    let gloss = pow(max(dot(normal, half_way), 0.0), 40.0) * 0.25;
    let rim = pow(1.0 - max(dot(normal, towards), 0.0), 4.0) * 0.12;
    // The robot's colour is data: a shine would make it paler.
    let shine = (gloss + rim) * (1.0 - in.own);
    return vec4f(lit(in.colour, normal, in.local) + shine * view.sun_colour.rgb, 1.0);
}

@vertex
fn body_id(instance: Instance, @location(6) point: vec3f) -> Id {
    return Id(clip_of(instance, placed(instance, point)), instance.id);
}

// Blocks are small, so lighting per vertex is enough.
@vertex
fn block(instance: Instance, @location(6) point: vec3f, @location(7) normal: vec4f, @location(8) paint: vec4f) -> Vertex {
    let local = placed(instance, point);
    let facing = vec3f(rotated(instance.heading, normal.xy), normal.z);
    // In a plan all of an outline has the robot's colour, darker in front: a light front would vanish on a light floor. The
    // narrow field of view tells a plan.
    let outline = instance.colour.rgb * max(paint.a, 0.45);
    let painted = select(mix(paint.rgb, instance.colour.rgb, paint.a), outline, view.up.w < 0.01);
    let colour = lit(painted, facing, local);
    return Vertex(clip_of(instance, local), facing, colour, local, paint.a);
}

@fragment
fn plain(in: Vertex) -> @location(0) vec4f {
    return vec4f(in.colour, 1.0);
}

struct Shadow {
    @builtin(position) clip: vec4f,
    // Position in the shadow's rectangle and half the rectangle's size, in metres; half the width of the soft edge.
    @location(0) position: vec2f,
    @location(1) half_size: vec2f,
    @location(2) soft: f32,
}

@vertex
fn shadow(instance: Instance, @builtin(vertex_index) corner: u32) -> Shadow {
    let height = min(instance.height.x, 1.0);
    let soft = 0.3 * height + 0.05;
    let half_size = instance.size * 0.5;
    let unit = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let position = unit * (half_size + soft);
    // Shadows are shifted away from the sun.
    let ground = instance.at - view.sun.xy / max(view.sun.z, 0.2) * height * 0.35 + rotated(instance.heading, position);
    return Shadow(cropped(clip_from(vec3f(ground, 0.0))), position, half_size, soft);
}

@fragment
fn shadowed(in: Shadow) -> @location(0) vec4f {
    let outside = abs(in.position) - in.half_size + in.soft;
    let distance = length(max(outside, vec2f(0.0))) / (2.0 * in.soft);
    let dark = 1.0 - smoothstep(0.0, 1.0, distance);
    return vec4f(0.0, 0.0, 0.0, dark * view.sun.w);
}

struct Corner {
    @location(0) at: vec3f,
    @location(1) colour: vec4f,
}

struct MarkVertex {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) colour: vec3f,
}

@vertex
fn mark(corner: Corner) -> MarkVertex {
    return MarkVertex(cropped(vec4f(corner.at, 1.0)), corner.colour.rgb);
}

@fragment
fn mark_plain(in: MarkVertex) -> @location(0) vec4f {
    return vec4f(in.colour, 1.0);
}

@group(1) @binding(0) var<storage, read> mark_ids: array<u32>;

@vertex
fn mark_id(corner: Corner, @builtin(vertex_index) vertex: u32) -> Id {
    return Id(cropped(vec4f(corner.at, 1.0)), mark_ids[vertex / 3u]);
}

@fragment
fn id_of(in: Id) -> @location(0) u32 {
    return in.id;
}

struct RoundVertex {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) colour: vec3f,
    // Position relative to the centre of a circle with radius 1. For darts it is zero: all of a dart is drawn.
    @location(1) position: vec2f,
}

@vertex
fn round_mark(corner: Corner, @builtin(vertex_index) vertex: u32) -> RoundVertex {
    let number = vertex % 3u;
    let across = (f32(number == 0u) - f32(number == 1u)) * 1.7320508;
    let position = vec2f(select(-1.0, 2.0, number == 2u), across) * corner.colour.a;
    return RoundVertex(cropped(vec4f(corner.at, 1.0)), corner.colour.rgb, position);
}

@fragment
fn mark_round(in: RoundVertex) -> @location(0) vec4f {
    if dot(in.position, in.position) > 1.0 {
        discard;
    }
    // A dark notch in front shows the heading.
    let ahead = in.position - vec2f(0.55, 0.0);
    let tint = select(1.0, 0.45, dot(ahead, ahead) < 0.06);
    return vec4f(in.colour * tint, 1.0);
}
