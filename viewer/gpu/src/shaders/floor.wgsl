// The floor: intersects each pixel's ray with the ground. Drawn first, over the whole picture.

struct Ray {
    @builtin(position) clip: vec4f,
    @location(0) ray: vec3f,
}

@group(1) @binding(0) var picture: texture_2d<f32>;
@group(1) @binding(1) var picture_sampler: sampler;
// The placement of the floor picture. corner: the lower left corner in local coordinates, cosine and sine of the turn.
// size: the reciprocals of width and height in metres, the opacity; w is unused.
struct Placement {
    corner: vec4f,
    size: vec4f,
}
@group(1) @binding(2) var<uniform> placement: Placement;

@vertex
fn ray(@builtin(vertex_index) corner: u32) -> Ray {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    let tan_x = view.right.w;
    let tan_y = view.up.w;
    return Ray(vec4f(at, 0.0, 1.0), view.forward.xyz + view.right.xyz * (at.x * tan_x) + view.up.xyz * (at.y * tan_y));
}

// The share of a pixel that the lines of a grid cover, if lines are `width` pixels wide.
fn lines(at: vec2f, spacing: f32, pixel: vec2f, width: f32) -> f32 {
    let away = abs(fract(at / spacing + 0.5) - 0.5) * spacing / pixel;
    let near = clamp(vec2f(0.5 + 0.5 * width) - away, vec2f(0.0), vec2f(1.0));
    // Lines fade out where they are only a few pixels apart.
    let room = clamp(spacing / pixel * 0.1 - 0.3, vec2f(0.0), vec2f(1.0));
    return max(near.x * room.x, near.y * room.y);
}

// The intersection of the ray with the ground, in local coordinates.
fn ground_point(in: Ray) -> vec2f {
    // Beyond the horizon the distance would be negative.
    return view.eye.xy + in.ray.xy * (view.eye.z / max(-in.ray.z, 1e-4));
}

fn ground(in: Ray, local: vec2f, bare: vec3f) -> vec4f {
    let world = local + view.origin.zw;
    let pixel = max(fwidth(local), vec2f(1e-5));
    let fine = lines(world, view.spacing.x, pixel, 0.6);
    let coarse = lines(world, view.spacing.x * 10.0, pixel, 1.4);
    var colour = mix(bare, view.grid.rgb, max(fine * 0.55, coarse) * view.grid.a);
    let count = light_count(local);
    for (var i = 0u; i < count; i++) {
        let towards = view.lights[i].position.xyz - vec3f(local, 0.0);
        let square = dot(towards, towards);
        colour += colour * view.lights[i].colour.rgb * towards.z * inverseSqrt(square) * 4.0 / (1.0 + square);
    }
    let beside = max(view.floor_bounds.xy - local, local - view.floor_bounds.zw) / pixel;
    let inside = 1.0 - clamp(max(beside.x, beside.y), 0.0, 1.0);
    // The floor fades into the sky, from a distance of about ten times the eye's height on.
    let flat = clamp(1.0 + in.ray.z * inverseSqrt(dot(in.ray, in.ray)) * 14.0, 0.0, 1.0);
    return vec4f(mix(view.sky.rgb, colour, inside * (1.0 - flat * flat) * step(1e-4, -in.ray.z)), 1.0);
}

@fragment
fn plain(in: Ray) -> @location(0) vec4f {
    return ground(in, ground_point(in), view.floor.rgb);
}

@fragment
fn textured(in: Ray) -> @location(0) vec4f {
    let local = ground_point(in);
    let out = local - placement.corner.xy;
    let turned = vec2f(out.x * placement.corner.z + out.y * placement.corner.w, out.y * placement.corner.z - out.x * placement.corner.w);
    let uv = turned * placement.size.xy;
    let sample = textureSample(picture, picture_sampler, vec2f(uv.x, 1.0 - uv.y));
    let inside = all(uv >= vec2f(0.0)) && all(uv <= vec2f(1.0));
    return ground(in, local, mix(view.floor.rgb, sample.rgb, select(0.0, sample.a * placement.size.z, inside)));
}
