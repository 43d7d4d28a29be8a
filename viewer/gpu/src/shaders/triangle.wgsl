// A triangle over the whole picture.

struct Place {
    @builtin(position) clip: vec4f,
    @location(0) at: vec2f,
}

// A corner of the triangle. `at` goes from 0 at the top left to `end` at the bottom right of the picture.
fn triangle_corner(corner: u32, end: vec2f) -> Place {
    let at = vec2f(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return Place(vec4f(at, 0.0, 1.0), (at * vec2f(0.5, -0.5) + 0.5) * end);
}
