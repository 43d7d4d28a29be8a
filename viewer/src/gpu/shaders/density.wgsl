// The density of robots that are too small to be told apart: a smooth field over the ground. The sorting shader has added them
// up by cells; here the sums are blurred and drawn. Its hue is the mean of the robots' colours.

// Whether the cells come after the pixels and tiles of splatted marks.
override SPLATS = false;

// Sums of red, green, blue and robots by cell, row by row.
@group(1) @binding(0) var<storage, read> sums: array<u32>;
@group(1) @binding(1) var<storage, read_write> blurred_across: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> blurred: array<vec4f>;

// Binomial weights: a standard deviation of 1.2 cells.
const WEIGHTS = array<f32, 7>(0.015625, 0.09375, 0.234375, 0.3125, 0.234375, 0.09375, 0.015625);

fn sum_at(x: i32, y: u32, size: vec2u) -> vec4f {
    let column = u32(clamp(x, 0, i32(size.x) - 1));
    let first = first_cell(SPLATS) + 4u * (y * size.x + column);
    let sum = vec4u(sums[first], sums[first + 1u], sums[first + 2u], sums[first + 3u]);
    return vec4f(sum) * vec4f(vec3f(1.0 / COLOUR_STEPS), 1.0);
}

@compute @workgroup_size(64)
fn across(@builtin(global_invocation_id) at: vec3u) {
    let size = cells();
    if at.x >= size.x * size.y {
        return;
    }
    var sum = vec4f(0.0);
    for (var i = 0; i < 7; i++) {
        sum += WEIGHTS[i] * sum_at(i32(at.x % size.x) + i - 3, at.x / size.x, size);
    }
    blurred_across[at.x] = sum;
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
        sum += WEIGHTS[i] * blurred_across[row * size.x + at.x % size.x];
    }
    blurred[at.x] = sum;
}
