// Marks that the sorting shader has put into pixels: drawn into the picture, tile by tile.

// A pixel each, in rows; then whether there is a mark in a tile; then the numbers of the tiles with one.
@group(1) @binding(0) var<storage, read> pixels: array<u32>;

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
    // Two triangles.
    let corner = (0xda4u >> ((vertex % 6u) * 2u)) & 3u;
    let place = vec2u(number % tiles.x, number / tiles.x) + vec2u(corner & 1u, corner >> 1u);
    let at = vec2f(place * TILE);
    return Tile(vec4f((at * view.viewport.zw * 2.0 - 1.0) * vec2f(1.0, -1.0), 0.0, 1.0), at);
}

struct Splat {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn splat(in: Tile) -> Splat {
    let at = vec2u(in.at);
    let key = pixels[at.y * u32(view.viewport.x) + at.x];
    if key == 0u {
        discard;
    }
    // Depth is reversed, and endless: what is in the matrix is the near plane's distance.
    return Splat(vec4f(colour_of_key(key), 1.0), view.clip_from_local[3].z / distance_of(key));
}
