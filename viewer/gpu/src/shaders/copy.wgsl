// Copies a picture.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct Place {
    @builtin(position) clip: vec4f,
    // Where it is in the picture, from 0 to 1.
    @location(0) at: vec2f,
}

@vertex
fn place(@builtin(vertex_index) corner: u32) -> Place {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return Place(vec4f(at, 0.0, 1.0), at * vec2f(0.5, -0.5) + 0.5);
}

@fragment
fn copied(in: Place) -> @location(0) vec4f {
    return textureSample(picture, picture_sampler, in.at);
}
