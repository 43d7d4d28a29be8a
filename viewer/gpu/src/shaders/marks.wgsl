// The output of the sorting shader for marks.

// A corner of a mark's triangle in final coordinates: instances of three vertices would leave a GPU's lanes idle, and
// cost a software adapter time. For splats the entry has the mark's depth and colour only, at the robot's index.
struct Corner {
    // Normalized device coordinates and depth.
    x: f32,
    y: f32,
    depth: f32,
    // Red, green, blue (linear), and 1 for a circle, 8 bits each.
    colour: u32,
}

// Width and height of a tile in pixels.
const TILE = 32u;

// A splatted pixel holds a key, 0 for none; the highest key is in front. From its high bits to its low ones, a key is the
// quantized nearness, the quantized height and the robot's id. The more robots there are, the more bits their ids need,
// and the fewer remain for the quantized values.
fn id_bits() -> u32 {
    return 32u - countLeadingZeros(view.robots);
}

// Quantizes a value from 0 to 1.
fn quantized(value: f32, bits: u32) -> u32 {
    return u32(clamp(value, 0.0, 0.9999) * f32(1u << bits));
}

// Half of the steps of nearness are nearer than the camera's target; half of the steps of height are below one metre.
fn key_of(distance: f32, height: f32, id: u32) -> u32 {
    let target_distance = view.spacing.y * view.eye.w;
    let height_bits = (32u - id_bits()) / 2u;
    let near_bits = 32u - id_bits() - height_bits;
    let near = max(quantized(target_distance / (target_distance + distance), near_bits), 1u);
    let high = quantized(height / (height + 1.0), height_bits);
    return (((near << height_bits) | high) << id_bits()) | id;
}

fn id_of_key(key: u32) -> u32 {
    return extractBits(key, 0u, id_bits());
}

// Width and height of a cell of the density, in pixels.
const CELL = 4u;
// Colours are added up in so many steps of each channel.
const COLOUR_STEPS = 255.0;

// Columns and rows of cells.
fn cells() -> vec2u {
    return (vec2u(view.viewport.xy) + CELL - 1u) / CELL;
}

// Where the sums of cells begin: after the pixels, tiles and tile numbers of splatted marks, if there are any.
fn first_cell(are_splats: bool) -> u32 {
    let size = vec2u(view.viewport.xy);
    let tiles = (size + TILE - 1u) / TILE;
    return select(0u, size.x * size.y + 2u * tiles.x * tiles.y, are_splats);
}
