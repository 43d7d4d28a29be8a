// Draws the blurred density over the ground.

// The square root of each cell's colour, and its strength.
@group(1) @binding(0) var field: texture_2d<f32>;
@group(1) @binding(1) var field_sampler: sampler;

struct Place {
    @builtin(position) clip: vec4f,
    // Where the picture is in the field, from 0 to 1.
    @location(0) at: vec2f,
}

@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    let pixel = (at * vec2f(0.5, -0.5) + 0.5) * view.viewport.xy;
    return Place(vec4f(at, 0.0, 1.0), pixel / vec2f(cells() * CELL));
}

@fragment
fn fill(in: Place) -> @location(0) vec4f {
    let paint = textureSample(field, field_sampler, in.at);
    return vec4f(paint.rgb * paint.rgb, paint.w);
}
