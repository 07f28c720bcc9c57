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
    ("aqua", 0x00FFFF),
    ("aquamarine", 0x7FFFD4),
    ("beige", 0xF5F5DC),
    ("black", 0x000000),
    ("blue", 0x0000FF),
    ("bluewhite", 0xD9D9FF),    // PyMOL
    ("brightorange", 0xFFB333), // PyMOL
    ("brown", 0xA52A2A),
    ("cadetblue", 0x5F9EA0),
    ("carbon", 0x33FF33), // PyMOL
    ("chartreuse", 0x7FFF00),
    ("chocolate", 0xD2691E),
    ("coral", 0xFF7F50),
    ("cornflowerblue", 0x6495ED),
    ("crimson", 0xDC143C),
    ("cyan", 0x00FFFF),
    ("darkblue", 0x00008B),
    ("darkcyan", 0x008B8B),
    ("darkgray", 0xA9A9A9),
    ("darkgreen", 0x006400),
    ("darkgrey", 0xA9A9A9),
    ("darkmagenta", 0x8B008B),
    ("darkorange", 0xFF8C00),
    ("darkorchid", 0x9932CC),
    ("darkred", 0x8B0000),
    ("darksalmon", 0xE9967A),
    ("darkviolet", 0x9400D3),
    ("dash", 0xFFFF00),       // PyMOL
    ("deepblue", 0x4040A6),   // PyMOL
    ("deepolive", 0x99991A),  // PyMOL
    ("deeppurple", 0x991A99), // PyMOL
    ("deepsalmon", 0xFF8080), // PyMOL
    ("deepskyblue", 0x00BFFF),
    ("deepteal", 0x1A9999), // PyMOL
    ("density", 0x1A1A99),  // PyMOL
    ("dimgray", 0x696969),
    ("dimgrey", 0x696969),
    ("dirtyviolet", 0xB38080), // PyMOL
    ("dodgerblue", 0x1E90FF),
    ("firebrick", 0xB22222),
    ("forest", 0x339933), // PyMOL
    ("forestgreen", 0x228B22),
    ("fuchsia", 0xFF00FF),
    ("gainsboro", 0xDCDCDC),
    ("gold", 0xFFD700),
    ("goldenrod", 0xDAA520),
    ("gray", 0x808080),
    ("green", 0x008000),
    ("greencyan", 0x40FFBF), // PyMOL
    ("grey", 0x808080),
    ("hotpink", 0xFF69B4),
    ("hydrogen", 0xE6E6E6), // PyMOL
    ("indianred", 0xCD5C5C),
    ("indigo", 0x4B0082),
    ("ivory", 0xFFFFF0),
    ("khaki", 0xF0E68C),
    ("lavender", 0xE6E6FA),
    ("lightblue", 0xADD8E6),
    ("lightgray", 0xD3D3D3),
    ("lightgreen", 0x90EE90),
    ("lightgrey", 0xD3D3D3),
    ("lightmagenta", 0xFF33CC), // PyMOL
    ("lightorange", 0xFFCC80),  // PyMOL
    ("lightpink", 0xFFB6C1),
    ("lightsalmon", 0xFFA07A),
    ("lightsteelblue", 0xB0C4DE),
    ("lightteal", 0x66B3B3), // PyMOL
    ("lightyellow", 0xFFFFE0),
    ("lime", 0x00FF00),
    ("limegreen", 0x32CD32),
    ("limon", 0xBFFF40), // PyMOL
    ("magenta", 0xFF00FF),
    ("marine", 0x0080FF), // PyMOL
    ("maroon", 0x800000),
    ("mediumblue", 0x0000CD),
    ("mediumpurple", 0x9370DB),
    ("mediumseagreen", 0x3CB371),
    ("midnightblue", 0x191970),
    ("navy", 0x000080),
    ("nitrogen", 0x3333FF), // PyMOL
    ("olive", 0x808000),
    ("olivedrab", 0x6B8E23),
    ("orange", 0xFFA500),
    ("orangered", 0xFF4500),
    ("orchid", 0xDA70D6),
    ("oxygen", 0xFF4D4D),   // PyMOL
    ("palecyan", 0xCCFFFF), // PyMOL
    ("palegreen", 0x98FB98),
    ("paleyellow", 0xFFFF80), // PyMOL
    ("peru", 0xCD853F),
    ("pink", 0xFFC0CB),
    ("plum", 0xDDA0DD),
    ("powderblue", 0xB0E0E6),
    ("purple", 0x800080),
    ("purpleblue", 0x8000FF), // PyMOL
    ("raspberry", 0xB34D66),  // PyMOL
    ("red", 0xFF0000),
    ("rosybrown", 0xBC8F8F),
    ("royalblue", 0x4169E1),
    ("ruby", 0x993333), // PyMOL
    ("salmon", 0xFA8072),
    ("sand", 0xB88C4D), // PyMOL
    ("sandybrown", 0xF4A460),
    ("seagreen", 0x2E8B57),
    ("sienna", 0xA0522D),
    ("silver", 0xC0C0C0),
    ("skyblue", 0x87CEEB),
    ("slate", 0x8080FF), // PyMOL
    ("slateblue", 0x6A5ACD),
    ("slategray", 0x708090),
    ("slategrey", 0x708090),
    ("smudge", 0x8CB366),   // PyMOL
    ("splitpea", 0x85BF00), // PyMOL
    ("springgreen", 0x00FF7F),
    ("steelblue", 0x4682B4),
    ("sulfur", 0xE6C640), // PyMOL
    ("tan", 0xD2B48C),
    ("teal", 0x008080),
    ("thistle", 0xD8BFD8),
    ("tomato", 0xFF6347),
    ("turquoise", 0x40E0D0),
    ("tv_blue", 0x4D4DFF),   // PyMOL
    ("tv_green", 0x33FF33),  // PyMOL
    ("tv_orange", 0xFF8C26), // PyMOL
    ("tv_red", 0xFF3333),    // PyMOL
    ("tv_yellow", 0xFFFF33), // PyMOL
    ("violet", 0xEE82EE),
    ("violetpurple", 0x8C4099), // PyMOL
    ("warmpink", 0xD93380),     // PyMOL
    ("wheat", 0xF5DEB3),
    ("white", 0xFFFFFF),
    ("whitesmoke", 0xF5F5F5),
    ("yellow", 0xFFFF00),
    ("yellowgreen", 0x9ACD32),
    ("yelloworange", 0xFFDE5E), // PyMOL
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
