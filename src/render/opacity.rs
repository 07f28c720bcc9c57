//! See-through primitives: drawn in a part of the samples as large as their opacity, so that nothing has to be sorted.
//!
//! Which samples those are is fixed: the sample's turn in a low-discrepancy order, moved by the primitive's id. All that have
//! one id (a mesh) come and go together; of others each has samples of its own. The order is the third
//! dimension of Sobol's sequence, as the first two place the sample in its pixel ([`super::settings::sample_offset`]): with one
//! of those a see-through edge would move by a quarter of a pixel.
//!
//! Light is hidden in the same way: in each sample by some of the see-through primitives only, so that a shadow has the share of
//! the opacity ([`hides_in_sample`]). Those must not be the ones that are drawn in the sample. A point behind a see-through surface is
//! seen exactly where that is not drawn: it would never lie in its shadow, and the inside of a closed shell would be as bright
//! as if there were none. So hiding goes by the bits of the same turn read backwards, moved by another part of the id's hash: of any run
//! of turns, as those are in which something is seen through a surface, each part of them holds its share. (Another move of the same
//! order would not do: whether two runs of turns overlap is luck, and the shadow off by as much as the opacity.) The ground's light, which has
//! no samples, is dimmed by the share itself ([`super::field`]).
//!
//! With one sample (ids, depths, normals, the channel of sky visibility, a window in motion) what has an opacity of at least a half
//! is there, and hides light. `shaders/opacity.wgsl` holds the twin.

/// Sobol's third dimension as a 32-bit fraction: primitive polynomial x² + x + 1, first numbers 1 and 3 (Joe and Kuo, SIAM J.
/// Sci. Comput. 2008, 30, 2635).
fn sobol_third(index: u32) -> u32 {
    // m_k = 2·m_{k−1} ⊕ 4·m_{k−2} ⊕ m_{k−2}; as fractions v_k = m_k / 2^k the shifts turn round.
    let (mut before, mut direction) = (1u32 << 31, 3u32 << 30);
    let (mut sum, mut rest) = (0, index);
    while rest != 0 {
        if rest & 1 == 1 {
            sum ^= before;
        }
        (before, direction) = (direction, direction ^ before ^ (before >> 2));
        rest >>= 1;
    }
    sum
}

/// Place of a sample in the order in which see-through primitives take their samples, 0 to `turns` − 1, and `turns`: the
/// number of samples, or the next power of two.
#[must_use]
pub fn sample_turn(sample_index: u32, sample_count: u32) -> (u32, u32) {
    let turns = sample_count.clamp(1, 1 << 16).next_power_of_two();
    let turn = (u64::from(sobol_third(sample_index)) * u64::from(turns)) >> 32;
    (turn as u32, turns)
}

/// Spreads ids over the turns (the finaliser of MurmurHash3, Appleby 2011).
fn hash(id: u32) -> u32 {
    let id = (id ^ (id >> 16)).wrapping_mul(0x85eb_ca6b);
    let id = (id ^ (id >> 13)).wrapping_mul(0xc2b2_ae35);
    id ^ (id >> 16)
}

/// Whether a primitive with this id and opacity (0–255) is there in a sample: in as many of the samples as are nearest
/// to its opacity.
#[must_use]
pub fn is_drawn_in_sample(sample_index: u32, sample_count: u32, id: u32, opacity: u8) -> bool {
    if opacity == u8::MAX {
        return true;
    }
    let (turn, turns) = sample_turn(sample_index, sample_count);
    (turn.wrapping_add(hash(id)) & (turns - 1)) < (u32::from(opacity) * turns + 127) / 255
}

/// Whether a primitive with this id and opacity (0–255) hides light in a sample: in as many of the samples as are nearest to its
/// opacity, whichever of them it is drawn in.
#[must_use]
pub fn hides_in_sample(sample_index: u32, sample_count: u32, id: u32, opacity: u8) -> bool {
    if opacity == u8::MAX {
        return true;
    }
    let (turn, turns) = sample_turn(sample_index, sample_count);
    let turn = backwards(turn, turns);
    (turn.wrapping_add(hash(id) >> 16) & (turns - 1)) < (u32::from(opacity) * turns + 127) / 255
}

/// A turn with its bits in the other order.
#[must_use]
pub fn backwards(turn: u32, turns: u32) -> u32 {
    ((u64::from(turn.reverse_bits()) * u64::from(turns)) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(samples: u32, id: u32, opacity: u8) -> u32 {
        (0..samples).map(|sample| u32::from(is_drawn_in_sample(sample, samples, id, opacity))).sum()
    }

    #[test]
    fn a_primitive_is_there_in_as_many_samples_as_its_opacity_says() {
        for id in [0, 1, 2, 77, 4_000_000_000] {
            for (opacity, sixteenths) in [(0, 0), (64, 4), (127, 8), (128, 8), (191, 12), (255, 16)] {
                assert_eq!(count(16, id, opacity), sixteenths, "{id} {opacity}");
                assert!(count(64, id, opacity).abs_diff(4 * sixteenths) <= 1, "{id} {opacity}");
            }
            assert!((0..=255).all(|a| (f64::from(count(4096, id, a)) / 4096.0 - f64::from(a) / 255.0).abs() < 1e-3));
        }
    }

    #[test]
    fn it_hides_light_in_as_many_samples_and_in_its_share_of_those_that_see_through_it() {
        let hidden = |samples: u32, id, opacity, other: u32| {
            let behind = |s: &u32| !is_drawn_in_sample(*s, samples, other, opacity);
            let seen: Vec<u32> = (0..samples).filter(behind).collect();
            let hides = seen.iter().filter(|&&s| hides_in_sample(s, samples, id, opacity)).count();
            (hides as f64, seen.len() as f64)
        };
        for samples in [4, 16, 64] {
            let (mut squares, mut cases, mut bias) = (0.0, 0.0, 0.0);
            for id in 0..400 {
                for opacity in (0..=255).step_by(5) {
                    let hides = (0..samples).filter(|&s| hides_in_sample(s, samples, id, opacity)).count() as u32;
                    assert_eq!(hides, count(samples, id, opacity));
                    // Seen through itself, and through another.
                    for other in [id, id + 1000] {
                        let (hides, seen) = hidden(samples, id, opacity, other);
                        let off = hides - seen * f64::from(count(samples, id, opacity)) / f64::from(samples);
                        (squares, cases, bias) = (squares + off * off, cases + 1.0, bias + off);
                        assert!(off.abs() <= 3.0, "{samples} {id} {other} {opacity}: {off}");
                    }
                }
            }
            let rms: f64 = f64::sqrt(squares / cases);
            println!("{samples} samples: off by {rms:.2} of them, {:.3} in the mean", bias / cases);
            assert!(rms < 0.7 && (bias / cases).abs() < 0.1, "{samples}: {rms}");
        }
        assert!((0..100).all(|id| hides_in_sample(0, 1, id, 128) && !hides_in_sample(0, 1, id, 127)));
    }

    #[test]
    fn one_sample_shows_what_is_more_there_than_not() {
        for id in 0..100 {
            assert!(!is_drawn_in_sample(0, 1, id, 127) && is_drawn_in_sample(0, 1, id, 128));
        }
    }

    #[test]
    fn every_turn_comes_once_and_halves_of_the_pixel_have_the_same_share() {
        for samples in [4, 16, 64] {
            let mut turns: Vec<u32> = (0..samples).map(|sample| sample_turn(sample, samples).0).collect();
            turns.sort_unstable();
            assert_eq!(turns, (0..samples).collect::<Vec<_>>());
        }
        for id in 0..200 {
            let drawn = |sample: &u32| is_drawn_in_sample(*sample, 16, id, 128);
            let places = (0..16).filter(drawn).map(|sample| super::super::settings::sample_offset(sample, 16));
            let mean = places.fold([0.0, 0.0], |sum, p| [sum[0] + p[0] / 8.0, sum[1] + p[1] / 8.0]);
            assert!(mean.iter().all(|m| (m - 0.5f32).abs() < 0.13), "{id}: {mean:?}");
        }
    }

    #[test]
    fn ids_have_samples_of_their_own() {
        let same = (0..1000).filter(|&id| {
            (0..16).all(|s| is_drawn_in_sample(s, 16, id, 128) == is_drawn_in_sample(s, 16, id + 1, 128))
        });
        assert!(same.count() < 150);
    }
}
