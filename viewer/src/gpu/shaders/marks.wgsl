// A mark in a pixel, as one number, of which the highest is in front: how near it is, in steps, then its rank, then a
// number of its own, so that of many marks in one place no colour is seen more than another, then its colour. 0 for none.

const STEP_AT = 25u;
const STEPS = 128.0;
const RANK_AT = 22u;
const RANKS = 8.0;
const OWN_AT = 18u;
const OWN = 16.0;
// Colours are kept as their roots, each in so many bits.
const ROOT_BITS = 6u;
const ROOTS = 63.0;
// Pixels across of a tile.
const TILE = 32u;

fn target_distance() -> f32 {
    return view.spacing.y * view.eye.w;
}

// Half of the steps are nearer than the camera's target. Rank and own number are parts of 1.
fn key_of(distance: f32, rank: f32, own: f32, colour: vec3f) -> u32 {
    let target_away = target_distance();
    let step = u32(clamp(target_away / (target_away + distance) * STEPS, 1.0, STEPS - 1.0));
    let place = u32(min(rank * RANKS, RANKS - 1.0));
    let root = vec3u(sqrt(clamp(colour, vec3f(0.0), vec3f(1.0))) * ROOTS + 0.5);
    let paint = (((root.r << ROOT_BITS) | root.g) << ROOT_BITS) | root.b;
    return (step << STEP_AT) | (place << RANK_AT) | (u32(own * OWN) << OWN_AT) | paint;
}

// To the middle of a step.
fn distance_of(key: u32) -> f32 {
    let near = (f32(key >> STEP_AT) + 0.5) / STEPS;
    return target_distance() * (1.0 - near) / near;
}

fn colour_of_key(key: u32) -> vec3f {
    let root = vec3f((vec3u(key) >> vec3u(2u * ROOT_BITS, ROOT_BITS, 0u)) & vec3u(u32(ROOTS))) / ROOTS;
    return root * root;
}
