// The uniforms of the picture, which every shader shares. The layout is that of `ViewUniform` in view.rs.
//
// Local coordinates are world coordinates relative to a point near the camera's target, so that single precision
// suffices far from the world's origin.

struct Light {
    position: vec4f,
    colour: vec4f,
}

struct View {
    clip_from_local: mat4x4f,
    // Position of the eye; w: pixels that a metre covers at a distance of one metre.
    eye: vec4f,
    // The camera's axes. w of `right` and `up`: tangent of half the field of view, horizontal and vertical.
    forward: vec4f,
    right: vec4f,
    up: vec4f,
    // Inward normals of the frustum's four sides, which pass through the eye.
    planes: array<vec4f, 4>,
    // Width and height in pixels, and their reciprocals.
    viewport: vec4f,
    // Crops the picture to a few pixels for picking: clip coordinates are multiplied by xy, and zw is added.
    crop: vec4f,
    // The origin of local coordinates: xy for robots and graph (their offset is subtracted), zw for the floor.
    origin: vec4f,
    // The moment to show, from the previous frame (0) to the current one (1); robots whose positions in the two are
    // farther apart than `teleport_distance` metres are not interpolated.
    alpha: f32,
    teleport_distance: f32,
    robots: u32,
    previous_robots: u32,
    // Robots are coloured by 0: value, 1: state, 2: type. Then the lowest value, the reciprocal of the range of values, and
    // 1 for categories.
    source: u32,
    low: f32,
    per_span: f32,
    categories: u32,
    unknown: vec4f,
    // Robot lengths in pixels from which on there are meshes (x) and blocks (y), and the least length of marks (z);
    // w: robots that have a value.
    detail: vec4f,
    // Direction towards the sun; w: opacity of shadows.
    sun: vec4f,
    sun_colour: vec4f,
    ambient_above: vec4f,
    ambient_below: vec4f,
    sky: vec4f,
    floor: vec4f,
    grid: vec4f,
    // Metres between two lines of the grid; metres per pixel at the target; number of lights; length in pixels below which
    // edges are thin.
    spacing: vec4f,
    // The floor's rectangle in local coordinates: low and high corner.
    floor_bounds: vec4f,
    edge: vec4f,
    two_way: vec4f,
    node: vec4f,
    selection: vec4f,
    route: vec4f,
    waiting: vec4f,
    ring: vec4f,
    wall: vec4f,
    rack: vec4f,
    // Robots below the length x in pixels are part of the density, those from y on are not; z: the reciprocal of the density of
    // half the strength, in square metres; w: the length of robots, in metres.
    density: vec4f,
    // Bit 0: robots that don't match a filter are dimmed. Bit 1: robots of other levels than the picture's are hidden.
    // Bit 2: all are dimmed over a heat map.
    filtered: u32,
    // 1 if there is a heat map.
    heated: u32,
    // The colours of categories by index, or a ramp: red, green, blue (linear), 8 bits each.
    palette: array<vec4u, 16>,
    lights: array<Light, 8>,
}

@group(0) @binding(0) var<uniform> view: View;

fn clip_from(local: vec3f) -> vec4f {
    return view.clip_from_local * vec4f(local, 1.0);
}

// Moves a robot away from the eye by a tiny part of its distance, a different one for each of 64 robots in a row, so that of
// faces at the same depth the same one is in front in every picture. The lists of robots have no fixed order. A step is several
// units in the last place: interpolation has errors of one. At 100 m, the largest part is 2.4 cm.
fn set_apart(depth: f32, id: u32) -> f32 {
    return depth * (1.0 - f32(id & 63u) * 0x1p-18);
}

// Crops clip coordinates for picking, as the last step of every vertex shader.
fn cropped(clip: vec4f) -> vec4f {
    return vec4f(clip.xy * view.crop.xy + view.crop.zw * clip.w, clip.zw);
}

// The corner of a quad, numbered row by row, at a vertex of its two triangles. A quad of six vertices rather than an instance of
// four: small instances leave a GPU's lanes idle, and a software adapter works on them one by one.
fn quad_corner(vertex: u32) -> u32 {
    return (0xda4u >> ((vertex % 6u) * 2u)) & 3u;
}

// The size of a pixel at a point, in metres.
fn metres_per_pixel(local: vec3f) -> f32 {
    return max(dot(local - view.eye.xyz, view.forward.xyz), 0.05) / view.eye.w;
}

// The number of lights that reach a point: none beyond ten kilometres.
//
// The count depends on the point as well as on a uniform, because Mesa's software driver (22.3) recompiles shaders that
// branch on a uniform alone for each picture, and never frees them.
fn light_count(local: vec2f) -> u32 {
    return select(0u, u32(view.spacing.z), dot(local, local) < 1e8);
}

// Diffuse and ambient lighting.
fn lit(colour: vec3f, normal: vec3f, local: vec3f) -> vec3f {
    let ambient = mix(view.ambient_below.rgb, view.ambient_above.rgb, normal.z * 0.5 + 0.5);
    var light = ambient + view.sun_colour.rgb * max(dot(normal, view.sun.xyz), 0.0);
    let count = light_count(local.xy);
    for (var i = 0u; i < count; i++) {
        let towards = view.lights[i].position.xyz - local;
        let square = dot(towards, towards);
        light += view.lights[i].colour.rgb * max(dot(normal, towards) * inverseSqrt(square), 0.0) * 4.0 / (1.0 + square);
    }
    return colour * light;
}
