// Marks as the sorting shader hands them on.

// A corner of a mark's triangle: ready to be drawn, as instances of three corners keep a GPU's lanes idle and a
// processor that draws busy. Of a mark that is put into pixels: its middle, in the place of its robot.
struct Corner {
    // Place in the whole picture, and depth.
    x: f32,
    y: f32,
    depth: f32,
    // Red, green, blue (linear), and 1 for a circle, 8 bits each.
    colour: u32,
}

// Pixels across of a tile.
const TILE = 32u;

// A mark in a pixel is one number, 0 for none, of which the highest is in front: how near and how high it is, in steps,
// then whose it is. The more robots there are, the more bits their ids need, and the larger the steps are.
fn id_bits() -> u32 {
    return 32u - countLeadingZeros(view.robots);
}

// A part of 1 in steps of so many bits.
fn step_of(part: f32, bits: u32) -> u32 {
    return u32(clamp(part, 0.0, 0.9999) * f32(1u << bits));
}

// Half of the steps are nearer than the camera's target, and half of them lower than a metre.
fn key_of(distance: f32, height: f32, id: u32) -> u32 {
    let target_distance = view.spacing.y * view.eye.w;
    let height_bits = (32u - id_bits()) / 2u;
    let near_bits = 32u - id_bits() - height_bits;
    let near = max(step_of(target_distance / (target_distance + distance), near_bits), 1u);
    let high = step_of(height / (height + 1.0), height_bits);
    return (((near << height_bits) | high) << id_bits()) | id;
}

fn id_of_key(key: u32) -> u32 {
    return extractBits(key, 0u, id_bits());
}
