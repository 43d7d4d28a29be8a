// egui's triangles: colours are premultiplied, and blended as they are seen.
//
// Nothing branches on a uniform: Mesa's software driver compiles such shaders anew for each picture.

// Points that a clip coordinate counts, in x and y; then nothing.
@group(0) @binding(0) var<uniform> scale: vec4f;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var filtering: sampler;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
    @location(1) colour: vec4f,
}

@vertex
fn corner(@location(0) place: vec2f, @location(1) at: vec2f, @location(2) colour: vec4f) -> Corner {
    return Corner(vec4f(place * scale.xy + vec2f(-1.0, 1.0), 0.0, 1.0), at, colour);
}

// For a surface that takes colours as they are seen.
@fragment
fn seen(in: Corner) -> @location(0) vec4f {
    return in.colour * textureSample(image, filtering, in.at);
}

// For a surface that takes light.
@fragment
fn light(in: Corner) -> @location(0) vec4f {
    let colour = in.colour * textureSample(image, filtering, in.at);
    let dark = colour.rgb / 12.92;
    let bright = pow((colour.rgb + 0.055) / 1.055, vec3f(2.4));
    return vec4f(select(bright, dark, colour.rgb < vec3f(0.04045)), colour.a);
}
