// Draws egui's meshes: colours have premultiplied alpha, and are blended in sRGB.
//
// There is no branch on a uniform: Mesa's software driver recompiles shaders with such a branch for each picture.

// Factors from points to clip coordinates in x and y; z and w are unused.
@group(0) @binding(0) var<uniform> scale: vec4f;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) colour: vec4f,
}

@vertex
fn corner(@location(0) position: vec2f, @location(1) uv: vec2f, @location(2) colour: vec4f) -> Corner {
    return Corner(vec4f(position * scale.xy + vec2f(-1.0, 1.0), 0.0, 1.0), uv, colour);
}

// For targets that store sRGB values without conversion.
@fragment
fn encoded(in: Corner) -> @location(0) vec4f {
    return in.colour * textureSample(image, image_sampler, in.uv);
}

// For targets that convert linear values to sRGB.
@fragment
fn linear(in: Corner) -> @location(0) vec4f {
    let colour = in.colour * textureSample(image, image_sampler, in.uv);
    let dark = colour.rgb / 12.92;
    let bright = pow((colour.rgb + 0.055) / 1.055, vec3f(2.4));
    return vec4f(select(bright, dark, colour.rgb < vec3f(0.04045)), colour.a);
}
