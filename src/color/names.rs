//! Colours by name: those of CSS that pictures of molecules use, and those that PyMOL has beside them.
//!
//! Where both know a name (`green`, `orange`, `teal`, `salmon`, …) it is the colour of CSS, so that a name means here what it means everywhere else.
//! Sources: CSS Color Module Level 4; PyMOL 3's table of named colours (open source, `layer1/Color.cpp`), its values 0 to 1 as bytes.

use super::Srgb8;
use crate::error::slips;

/// The colour of a name in lower case: one of the table, or `grey00` to `grey99`.
pub(super) fn of(name: &str) -> Option<Srgb8> {
    if let Ok(place) = NAMED.binary_search_by_key(&name, |&(known, _)| known) {
        return Some(Srgb8::from_rgb_u32(NAMED[place].1));
    }
    let shade = name.strip_prefix("grey").or(name.strip_prefix("gray"))?;
    let is_number = shade.len() == 2 && shade.bytes().all(|byte| byte.is_ascii_digit());
    let shade: u16 = shade.parse().ok().filter(|_| is_number)?;
    let byte = ((shade * 255 + 49) / 99) as u8;
    Some(Srgb8::rgb(byte, byte, byte))
}

/// The name that was likely meant by one that is none: one slip in a short one, two in a long one.
pub(super) fn likely(text: &str) -> Option<&'static str> {
    let text = text.trim().to_ascii_lowercase();
    let most = if text.chars().count() <= 4 { 1 } else { 2 };
    let nearest = NAMED.iter().map(|&(name, _)| (slips(&text, name), name)).min_by_key(|&(count, _)| count);
    nearest.filter(|&(count, _)| count <= most).map(|(_, name)| name)
}

/// In the order of their names; those that only PyMOL has are marked.
const NAMED: &[(&str, u32)] = &[
    ("aqua", 0x00_FF_FF),
    ("aquamarine", 0x7F_FF_D4),
    ("beige", 0xF5_F5_DC),
    ("black", 0x00_00_00),
    ("blue", 0x00_00_FF),
    ("bluewhite", 0xD9_D9_FF),    // PyMOL
    ("brightorange", 0xFF_B3_33), // PyMOL
    ("brown", 0xA5_2A_2A),
    ("cadetblue", 0x5F_9E_A0),
    ("carbon", 0x33_FF_33), // PyMOL
    ("chartreuse", 0x7F_FF_00),
    ("chocolate", 0xD2_69_1E),
    ("coral", 0xFF_7F_50),
    ("cornflowerblue", 0x64_95_ED),
    ("crimson", 0xDC_14_3C),
    ("cyan", 0x00_FF_FF),
    ("darkblue", 0x00_00_8B),
    ("darkcyan", 0x00_8B_8B),
    ("darkgray", 0xA9_A9_A9),
    ("darkgreen", 0x00_64_00),
    ("darkgrey", 0xA9_A9_A9),
    ("darkmagenta", 0x8B_00_8B),
    ("darkorange", 0xFF_8C_00),
    ("darkorchid", 0x99_32_CC),
    ("darkred", 0x8B_00_00),
    ("darksalmon", 0xE9_96_7A),
    ("darkviolet", 0x94_00_D3),
    ("dash", 0xFF_FF_00),       // PyMOL
    ("deepblue", 0x40_40_A6),   // PyMOL
    ("deepolive", 0x99_99_1A),  // PyMOL
    ("deeppurple", 0x99_1A_99), // PyMOL
    ("deepsalmon", 0xFF_80_80), // PyMOL
    ("deepskyblue", 0x00_BF_FF),
    ("deepteal", 0x1A_99_99), // PyMOL
    ("density", 0x1A_1A_99),  // PyMOL
    ("dimgray", 0x69_69_69),
    ("dimgrey", 0x69_69_69),
    ("dirtyviolet", 0xB3_80_80), // PyMOL
    ("dodgerblue", 0x1E_90_FF),
    ("firebrick", 0xB2_22_22),
    ("forest", 0x33_99_33), // PyMOL
    ("forestgreen", 0x22_8B_22),
    ("fuchsia", 0xFF_00_FF),
    ("gainsboro", 0xDC_DC_DC),
    ("gold", 0xFF_D7_00),
    ("goldenrod", 0xDA_A5_20),
    ("gray", 0x80_80_80),
    ("green", 0x00_80_00),
    ("greencyan", 0x40_FF_BF), // PyMOL
    ("grey", 0x80_80_80),
    ("hotpink", 0xFF_69_B4),
    ("hydrogen", 0xE6_E6_E6), // PyMOL
    ("indianred", 0xCD_5C_5C),
    ("indigo", 0x4B_00_82),
    ("ivory", 0xFF_FF_F0),
    ("khaki", 0xF0_E6_8C),
    ("lavender", 0xE6_E6_FA),
    ("lightblue", 0xAD_D8_E6),
    ("lightgray", 0xD3_D3_D3),
    ("lightgreen", 0x90_EE_90),
    ("lightgrey", 0xD3_D3_D3),
    ("lightmagenta", 0xFF_33_CC), // PyMOL
    ("lightorange", 0xFF_CC_80),  // PyMOL
    ("lightpink", 0xFF_B6_C1),
    ("lightsalmon", 0xFF_A0_7A),
    ("lightsteelblue", 0xB0_C4_DE),
    ("lightteal", 0x66_B3_B3), // PyMOL
    ("lightyellow", 0xFF_FF_E0),
    ("lime", 0x00_FF_00),
    ("limegreen", 0x32_CD_32),
    ("limon", 0xBF_FF_40), // PyMOL
    ("magenta", 0xFF_00_FF),
    ("marine", 0x00_80_FF), // PyMOL
    ("maroon", 0x80_00_00),
    ("mediumblue", 0x00_00_CD),
    ("mediumpurple", 0x93_70_DB),
    ("mediumseagreen", 0x3C_B3_71),
    ("midnightblue", 0x19_19_70),
    ("navy", 0x00_00_80),
    ("nitrogen", 0x33_33_FF), // PyMOL
    ("olive", 0x80_80_00),
    ("olivedrab", 0x6B_8E_23),
    ("orange", 0xFF_A5_00),
    ("orangered", 0xFF_45_00),
    ("orchid", 0xDA_70_D6),
    ("oxygen", 0xFF_4D_4D),   // PyMOL
    ("palecyan", 0xCC_FF_FF), // PyMOL
    ("palegreen", 0x98_FB_98),
    ("paleyellow", 0xFF_FF_80), // PyMOL
    ("peru", 0xCD_85_3F),
    ("pink", 0xFF_C0_CB),
    ("plum", 0xDD_A0_DD),
    ("powderblue", 0xB0_E0_E6),
    ("purple", 0x80_00_80),
    ("purpleblue", 0x80_00_FF), // PyMOL
    ("raspberry", 0xB3_4D_66),  // PyMOL
    ("red", 0xFF_00_00),
    ("rosybrown", 0xBC_8F_8F),
    ("royalblue", 0x41_69_E1),
    ("ruby", 0x99_33_33), // PyMOL
    ("salmon", 0xFA_80_72),
    ("sand", 0xB8_8C_4D), // PyMOL
    ("sandybrown", 0xF4_A4_60),
    ("seagreen", 0x2E_8B_57),
    ("sienna", 0xA0_52_2D),
    ("silver", 0xC0_C0_C0),
    ("skyblue", 0x87_CE_EB),
    ("slate", 0x80_80_FF), // PyMOL
    ("slateblue", 0x6A_5A_CD),
    ("slategray", 0x70_80_90),
    ("slategrey", 0x70_80_90),
    ("smudge", 0x8C_B3_66),   // PyMOL
    ("splitpea", 0x85_BF_00), // PyMOL
    ("springgreen", 0x00_FF_7F),
    ("steelblue", 0x46_82_B4),
    ("sulfur", 0xE6_C6_40), // PyMOL
    ("tan", 0xD2_B4_8C),
    ("teal", 0x00_80_80),
    ("thistle", 0xD8_BF_D8),
    ("tomato", 0xFF_63_47),
    ("turquoise", 0x40_E0_D0),
    ("tv_blue", 0x4D_4D_FF),   // PyMOL
    ("tv_green", 0x33_FF_33),  // PyMOL
    ("tv_orange", 0xFF_8C_26), // PyMOL
    ("tv_red", 0xFF_33_33),    // PyMOL
    ("tv_yellow", 0xFF_FF_33), // PyMOL
    ("violet", 0xEE_82_EE),
    ("violetpurple", 0x8C_40_99), // PyMOL
    ("warmpink", 0xD9_33_80),     // PyMOL
    ("wheat", 0xF5_DE_B3),
    ("white", 0xFF_FF_FF),
    ("whitesmoke", 0xF5_F5_F5),
    ("yellow", 0xFF_FF_00),
    ("yellowgreen", 0x9A_CD_32),
    ("yelloworange", 0xFF_DE_5E), // PyMOL
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_can_be_searched_and_names_no_colour_twice() {
        assert!(NAMED.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(NAMED.iter().all(|(name, _)| name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_')));
    }

    #[test]
    fn names_of_pymol_are_known_and_those_of_css_mean_what_css_says() {
        let of = |name| of(name).unwrap();
        assert_eq!(of("marine"), Srgb8::rgb(0, 128, 255));
        assert_eq!(of("slate"), Srgb8::rgb(128, 128, 255));
        assert_eq!(of("tv_red"), Srgb8::rgb(255, 51, 51));
        assert_eq!(of("green"), Srgb8::rgb(0, 128, 0));
        assert_eq!((of("grey00"), of("gray99")), (Srgb8::BLACK, Srgb8::WHITE));
        assert_eq!(of("grey50"), Srgb8::rgb(129, 129, 129));
        for name in ["grey", "grey5", "grey100", "grey+5", "Marine", ""] {
            assert!(super::of(name).is_none() || name == "grey", "{name}");
        }
    }

    #[test]
    fn a_slip_is_told_what_was_meant() {
        assert_eq!(likely("Marinne"), Some("marine"));
        assert_eq!(likely("stealblue"), Some("steelblue"));
        assert_eq!(likely("rde"), Some("red"));
        assert_eq!(likely("#12345"), None);
        assert_eq!(likely("reddish brown"), None);
    }
}
