// The floor: every pixel's ray is met with the ground. Drawn first, over the whole picture.

struct Ray {
    @builtin(position) clip: vec4f,
    @location(0) ray: vec3f,
}

@group(1) @binding(0) var picture: texture_2d<f32>;
@group(1) @binding(1) var picture_sampler: sampler;
// How the floor's picture lies: x and y of its lower left corner (local), cosine and sine of its turn; one over width
// and height in metres, how much of it shows, nothing.
struct Lie {
    corner: vec4f,
    size: vec4f,
}
@group(1) @binding(2) var<uniform> lie: Lie;

@vertex
fn ray(@builtin(vertex_index) corner: u32) -> Ray {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    let tan_x = view.right.w;
    let tan_y = view.up.w;
    return Ray(vec4f(at, 0.0, 1.0), view.forward.xyz + view.right.xyz * (at.x * tan_x) + view.up.xyz * (at.y * tan_y));
}

// How much of a pixel the lines of a grid cover, `width` pixels wide.
fn lines(at: vec2f, spacing: f32, pixel: vec2f, width: f32) -> f32 {
    let away = abs(fract(at / spacing + 0.5) - 0.5) * spacing / pixel;
    let near = clamp(vec2f(0.5 + 0.5 * width) - away, vec2f(0.0), vec2f(1.0));
    // Closer than a few pixels they run into each other.
    let room = clamp(spacing / pixel * 0.1 - 0.3, vec2f(0.0), vec2f(1.0));
    return max(near.x * room.x, near.y * room.y);
}

// Where the ray meets the ground, in local coordinates.
fn met(in: Ray) -> vec2f {
    // Beyond the horizon the distance would be negative.
    return view.eye.xy + in.ray.xy * (view.eye.z / max(-in.ray.z, 1e-4));
}

fn ground(in: Ray, local: vec2f, bare: vec3f) -> vec4f {
    let world = local + view.origin.zw;
    let pixel = max(fwidth(local), vec2f(1e-5));
    let fine = lines(world, view.spacing.x, pixel, 0.6);
    let coarse = lines(world, view.spacing.x * 10.0, pixel, 1.4);
    var colour = mix(bare, view.grid.rgb, max(fine * 0.55, coarse) * view.grid.a);
    let count = lamps(local);
    for (var i = 0u; i < count; i++) {
        let way = view.lights[i].position.xyz - vec3f(local, 0.0);
        let square = dot(way, way);
        colour += colour * view.lights[i].colour.rgb * way.z * inverseSqrt(square) * 4.0 / (1.0 + square);
    }
    let beside = max(view.floor_bounds.xy - local, local - view.floor_bounds.zw) / pixel;
    let inside = 1.0 - clamp(max(beside.x, beside.y), 0.0, 1.0);
    // The floor fades into the sky: some ten times the eye's height away, it begins to.
    let flat = clamp(1.0 + in.ray.z * inverseSqrt(dot(in.ray, in.ray)) * 14.0, 0.0, 1.0);
    return vec4f(mix(view.sky.rgb, colour, inside * (1.0 - flat * flat) * step(1e-4, -in.ray.z)), 1.0);
}

@fragment
fn plain(in: Ray) -> @location(0) vec4f {
    return ground(in, met(in), view.floor.rgb);
}

@fragment
fn textured(in: Ray) -> @location(0) vec4f {
    let local = met(in);
    let out = local - lie.corner.xy;
    let turned = vec2f(out.x * lie.corner.z + out.y * lie.corner.w, out.y * lie.corner.z - out.x * lie.corner.w);
    let place = turned * lie.size.xy;
    let sample = textureSample(picture, picture_sampler, vec2f(place.x, 1.0 - place.y));
    let inside = all(place >= vec2f(0.0)) && all(place <= vec2f(1.0));
    return ground(in, local, mix(view.floor.rgb, sample.rgb, select(0.0, sample.a * lie.size.z, inside)));
}
