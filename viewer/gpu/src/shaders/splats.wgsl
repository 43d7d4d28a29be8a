// Draws the marks that the sorting shader has splatted into pixels, tile by tile.

// The key of each pixel, row by row; then a flag per tile: whether it has marks; then the numbers of the tiles with marks.
@group(1) @binding(0) var<storage, read> pixels: array<u32>;
// The mark of each robot.
@group(1) @binding(1) var<storage, read> marks: array<Corner>;

struct Tile {
    @builtin(position) clip: vec4f,
    // In pixels from the top left.
    @location(0) at: vec2f,
}

@vertex
fn tile(@builtin(vertex_index) vertex: u32) -> Tile {
    let size = vec2u(view.viewport.xy);
    let tiles = (size + TILE - 1u) / TILE;
    let number = pixels[size.x * size.y + tiles.x * tiles.y + vertex / 6u];
    let corner = quad_corner(vertex);
    let tile_corner = vec2u(number % tiles.x, number / tiles.x) + vec2u(corner & 1u, corner >> 1u);
    let at = vec2f(tile_corner * TILE);
    return Tile(cropped(vec4f((at * view.viewport.zw * 2.0 - 1.0) * vec2f(1.0, -1.0), 0.0, 1.0)), at);
}

fn key_at(at: vec2f) -> u32 {
    let pixel = vec2u(at);
    let size = vec2u(view.viewport.xy);
    let is_inside = all(pixel < size);
    return select(0u, pixels[pixel.y * size.x + pixel.x], is_inside);
}

struct Splat {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn splat(in: Tile) -> Splat {
    let key = key_at(in.at);
    if key == 0u {
        discard;
    }
    let mark = marks[id_of_key(key)];
    return Splat(vec4f(unpack4x8unorm(mark.colour).rgb, 1.0), mark.depth);
}

struct Id {
    @location(0) id: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn splat_id(in: Tile) -> Id {
    let key = key_at(in.at);
    if key == 0u {
        discard;
    }
    return Id(id_of_key(key), marks[id_of_key(key)].depth);
}
