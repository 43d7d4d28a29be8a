// What every shader knows of the picture. The same as `ViewUniform` in view.rs.
//
// Local coordinates are the world's, counted from a point near the camera's target: single precision stays fine
// far from the world's origin.

struct Light {
    position: vec4f,
    colour: vec4f,
}

struct View {
    clip_from_local: mat4x4f,
    // Where the eye is; w: pixels that a metre covers at a distance of a metre.
    eye: vec4f,
    // w: nothing yet.
    forward: vec4f,
    right: vec4f,
    up: vec4f,
    // Through the eye along the sides of the picture, pointing inwards.
    planes: array<vec4f, 4>,
    // Width and height in pixels, and one over them.
    viewport: vec4f,
    // Clip coordinates are multiplied by xy, and zw is added: a picture of a few pixels of this one.
    window: vec4f,
    // Position minus this is local: xy for robots and graph (their offset is in it), zw for the floor.
    origin: vec4f,
    // From the previous frame (0) to the current (1); longest way between the two that is driven rather than jumped.
    alpha: f32,
    jump: f32,
    robots: u32,
    previous_robots: u32,
    // Colours: 0 by value, 1 by state, 2 by type; first value, one over the span of values, 1 for categories.
    source: u32,
    low: f32,
    per_span: f32,
    categories: u32,
    unknown: vec4f,
    // Sizes in pixels of a robot's length: mesh, block, mark; w: robots of which the value is known.
    detail: vec4f,
    // Towards the sun; w: how dark shadows are.
    sun: vec4f,
    sun_colour: vec4f,
    ambient_above: vec4f,
    ambient_below: vec4f,
    sky: vec4f,
    floor: vec4f,
    grid: vec4f,
    // Metres between two lines of the grid; metres per pixel at the target; lights; pixels of a thin edge.
    spacing: vec4f,
    // The floor's rectangle: low and high corner.
    floor_bounds: vec4f,
    edge: vec4f,
    two_way: vec4f,
    node: vec4f,
    selection: vec4f,
    route: vec4f,
    palette: array<vec4f, 16>,
    lights: array<Light, 8>,
}

@group(0) @binding(0) var<uniform> view: View;

fn clip_from(local: vec3f) -> vec4f {
    return view.clip_from_local * vec4f(local, 1.0);
}

// Last step of every vertex: the part of the picture that is wanted.
fn framed(clip: vec4f) -> vec4f {
    return vec4f(clip.xy * view.window.xy + view.window.zw * clip.w, clip.zw);
}

// Metres that a pixel covers at a point.
fn metres_per_pixel(local: vec3f) -> f32 {
    return max(dot(local - view.eye.xyz, view.forward.xyz), 0.05) / view.eye.w;
}

// Lamps that reach a point: none does beyond ten kilometres.
//
// What is asked of the point as well as of the picture is no branch on a uniform alone: shaders with such a branch are
// compiled anew for each picture by Mesa's software driver (22.3), which then keeps what it compiled.
fn lamps(local: vec2f) -> u32 {
    return select(0u, u32(view.spacing.z), dot(local, local) < 1e8);
}

fn lit(colour: vec3f, normal: vec3f, local: vec3f) -> vec3f {
    let ambient = mix(view.ambient_below.rgb, view.ambient_above.rgb, normal.z * 0.5 + 0.5);
    var light = ambient + view.sun_colour.rgb * max(dot(normal, view.sun.xyz), 0.0);
    let count = lamps(local.xy);
    for (var i = 0u; i < count; i++) {
        let way = view.lights[i].position.xyz - local;
        let square = dot(way, way);
        light += view.lights[i].colour.rgb * max(dot(normal, way) * inverseSqrt(square), 0.0) * 4.0 / (1.0 + square);
    }
    return colour * light;
}
