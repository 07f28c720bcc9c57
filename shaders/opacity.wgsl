// Which see-through primitives are there in a sample, and which hide light: the twin of src/render/opacity.rs. Comments stand there.
#import "common.wgsl"

// Twin of hash.
fn id_hash(id: u32) -> u32 {
    var hash = (id ^ (id >> 16u)) * 0x85ebca6bu;
    hash = (hash ^ (hash >> 13u)) * 0xc2b2ae35u;
    return hash ^ (hash >> 16u);
}

// Whether a turn, moved, is among the share of all that the opacity takes.
fn takes_turn(turn: u32, opacity: u32) -> bool {
    let turns = 1u << (one_sample.turn >> 24u);
    return (turn & (turns - 1u)) < (opacity * turns + 127u) / 255u;
}

// The opacity is the colour's highest byte.
fn is_drawn_in_sample(id: u32, color: u32) -> bool {
    let opacity = color >> 24u;
    return opacity == 255u || takes_turn((one_sample.turn & 0xfffu) + id_hash(id), opacity);
}

fn hides_in_sample(id: u32, opacity: u32) -> bool {
    return opacity == 255u || takes_turn(((one_sample.turn >> 12u) & 0xfffu) + (id_hash(id) >> 16u), opacity);
}
