// Draws the blurred density over the ground.

@group(1) @binding(0) var<storage, read> field: array<vec4f>;

struct Place {
    @builtin(position) clip: vec4f,
    @location(0) ray: vec3f,
    // In pixels from the top left.
    @location(1) at: vec2f,
}

@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    let ray = view.forward.xyz + view.right.xyz * (at.x * view.right.w) + view.up.xyz * (at.y * view.up.w);
    return Place(vec4f(at, 0.0, 1.0), ray, (at * vec2f(0.5, -0.5) + 0.5) * view.viewport.xy);
}

// The sums per cell at a place, interpolated between the middles of cells.
fn sums_at(at: vec2f) -> vec4f {
    let size = cells();
    let place = at / f32(CELL) - 0.5;
    let part = fract(place);
    let low = vec2u(clamp(vec2i(floor(place)), vec2i(0), vec2i(size) - 1));
    let high = min(vec2u(clamp(vec2i(floor(place)) + 1, vec2i(0), vec2i(size) - 1)), size - 1u);
    let upper = mix(field[low.y * size.x + low.x], field[low.y * size.x + high.x], part.x);
    let lower = mix(field[high.y * size.x + low.x], field[high.y * size.x + high.x], part.x);
    return mix(upper, lower, part.y);
}

@fragment
fn fill(in: Place) -> @location(0) vec4f {
    let sums = sums_at(in.at);
    if sums.w < 1e-4 {
        discard;
    }
    // The ground that a pixel covers, in square metres: more at a flat angle.
    let down = max(-in.ray.z, 1e-3);
    let local = view.eye.xyz + in.ray * (view.eye.z / down);
    let pixel = metres_per_pixel(local);
    let ground = pixel * pixel * length(in.ray) / down;
    let density = sums.w / (ground * f32(CELL * CELL));
    // From afar, the mean density of the fleet's ground has half the strength. Where marks take over, the field covers as much as
    // they do, so that there is no jump: a mark is about a third of the square over a robot's length.
    let pixels_long = view.density.w / pixel;
    let far = log2(view.density.y / pixels_long) / log2(view.density.y / view.density.x);
    let mark = 0.48 * view.density.w * view.density.w;
    let per_robot = exp2(mix(log2(mark), log2(view.density.z), clamp(far, 0.0, 1.0)));
    let strength = 1.0 - exp2(-density * per_robot);
    return vec4f(sums.rgb / sums.w, strength);
}
