// The density of robots that are too small to be told apart: a smooth field over the ground. The sorting shader has added them
// up by cells; here the sums are blurred and drawn. Its hue is the mean of the robots' colours.

// Whether the cells come after the pixels and tiles of splatted marks.
override SPLATS = false;

// Sums of red, green, blue and robots by cell, row by row.
@group(1) @binding(0) var<storage, read> sums: array<u32>;
// The same as four halves, and then blurred in one direction.
@group(1) @binding(1) var<storage, read_write> packed: array<vec2u>;
@group(1) @binding(2) var<storage, read_write> blurred_across: array<vec2u>;
// The square root of each cell's colour, and its strength.
@group(1) @binding(3) var field: texture_storage_2d<rgba8unorm, write>;

// Binomial weights: a standard deviation of 1.2 cells.
const WEIGHTS = array<f32, 7>(0.015625, 0.09375, 0.234375, 0.3125, 0.234375, 0.09375, 0.015625);
// A half is below 65,520, and there may be more robots in a cell.
const SCALE = 64.0;

fn halves(sum: vec4f) -> vec2u {
    return vec2u(pack2x16float(sum.xy), pack2x16float(sum.zw));
}

fn unpacked(halves: vec2u) -> vec4f {
    return vec4f(unpack2x16float(halves.x), unpack2x16float(halves.y));
}

@compute @workgroup_size(64)
fn pack(@builtin(global_invocation_id) at: vec3u) {
    let size = cells();
    if at.x >= size.x * size.y {
        return;
    }
    let first = first_cell(SPLATS) + 4u * at.x;
    let sum = vec4f(vec4u(sums[first], sums[first + 1u], sums[first + 2u], sums[first + 3u]));
    packed[at.x] = halves(sum * vec4f(vec3f(1.0 / COLOUR_STEPS), 1.0) / SCALE);
}

@compute @workgroup_size(64)
fn across(@builtin(global_invocation_id) at: vec3u) {
    let size = cells();
    if at.x >= size.x * size.y {
        return;
    }
    let row = at.x / size.x * size.x;
    var sum = vec4f(0.0);
    for (var i = 0; i < 7; i++) {
        let column = u32(clamp(i32(at.x - row) + i - 3, 0, i32(size.x) - 1));
        sum += WEIGHTS[i] * unpacked(packed[row + column]);
    }
    blurred_across[at.x] = halves(sum);
}

// The colour and the strength of a cell with these sums.
fn paint_of(cell: vec2u, sums: vec4f) -> vec4f {
    let at = (vec2f(cell) + 0.5) * f32(CELL) * view.viewport.zw * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    let ray = view.forward.xyz + view.right.xyz * (at.x * view.right.w) + view.up.xyz * (at.y * view.up.w);
    // The ground that a pixel covers, in square metres: more at a flat angle.
    let down = max(-ray.z, 1e-3);
    let pixel = metres_per_pixel(view.eye.xyz + ray * (view.eye.z / down));
    let ground = pixel * pixel * length(ray) / down;
    let density = sums.w / (ground * f32(CELL * CELL));
    // From afar, the mean density of the fleet's ground has half the strength. Where marks take over, the field covers as much as
    // they do, so that there is no jump: a mark is about a third of the square over a robot's length.
    let pixels_long = view.density.w / pixel;
    let far = log2(view.density.y / pixels_long) / log2(view.density.y / view.density.x);
    let mark = 0.48 * view.density.w * view.density.w;
    let per_robot = exp2(mix(log2(mark), log2(view.density.z), clamp(far, 0.0, 1.0)));
    let strength = 1.0 - exp2(-density * per_robot);
    return vec4f(sums.rgb / max(sums.w, 1e-6), strength);
}

@compute @workgroup_size(64)
fn down(@builtin(global_invocation_id) at: vec3u) {
    let size = cells();
    if at.x >= size.x * size.y {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0; i < 7; i++) {
        let row = u32(clamp(i32(at.x / size.x) + i - 3, 0, i32(size.y) - 1));
        sum += WEIGHTS[i] * unpacked(blurred_across[row * size.x + at.x % size.x]);
    }
    let cell = vec2u(at.x % size.x, at.x / size.x);
    let paint = paint_of(cell, sum * SCALE);
    textureStore(field, cell, vec4f(sqrt(paint.rgb), paint.w));
}
