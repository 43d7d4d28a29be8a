// Draws the blurred density over the ground.

// The square root of each cell's colour, and its strength.
@group(1) @binding(0) var field: texture_2d<f32>;
@group(1) @binding(1) var field_sampler: sampler;

// The field may reach beyond the picture, by a part of a cell.
@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    return triangle_corner(corner, view.viewport.xy / vec2f(cells() * CELL));
}

@fragment
fn fill(in: Place) -> @location(0) vec4f {
    let paint = textureSample(field, field_sampler, in.at);
    return vec4f(paint.rgb * paint.rgb, paint.w);
}
