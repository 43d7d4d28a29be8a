// Copies a picture.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    return triangle_corner(corner, vec2f(1.0));
}

@fragment
fn copied(in: Place) -> @location(0) vec4f {
    return textureSample(picture, picture_sampler, in.at);
}
