use super::*;
use std::io::Read;
use std::path::PathBuf;

fn embedded() -> &'static Dictionary<'static> {
    EMBEDDED.as_ref().unwrap()
}

/// The text that `BALLSTICK_CCD` names, plain or as `.zst`.
fn text_of_the_dictionary() -> Option<String> {
    let Some(path) = std::env::var_os("BALLSTICK_CCD").map(PathBuf::from) else {
        println!("SKIP: BALLSTICK_CCD names no text of the dictionary");
        return None;
    };
    let bytes = std::fs::read(&path).unwrap();
    let is_packed = path.extension().is_some_and(|extension| extension == "zst");
    let text = if is_packed {
        let mut text = Vec::new();
        ruzstd::decoding::StreamingDecoder::new(bytes.as_slice()).unwrap().read_to_end(&mut text).unwrap();
        text
    } else {
        bytes
    };
    Some(String::from_utf8(text).unwrap())
}

fn all(dictionary: &Dictionary<'_>) -> Vec<(String, Component)> {
    let one = |(number, entry): (usize, &[u8; INDEX_BYTES])| {
        let id = String::from_utf8(id_of(entry).into_iter().filter(|&byte| byte != 0).collect()).unwrap();
        let component = dictionary.read(number);
        (id, component.unwrap_or_else(|| panic!("component {number} is damaged")))
    };
    dictionary.index.iter().enumerate().map(one).collect()
}

/// `BALLSTICK_CCD=ccd.txt cargo test --release make_the_dictionary -- --ignored` writes data/ccd.bin.
#[test]
#[ignore = "writes data/ccd.bin"]
fn make_the_dictionary() {
    let components = encode::parse(&text_of_the_dictionary().expect("BALLSTICK_CCD"));
    let packed = encode::pack(&components);
    assert_eq!(all(&Dictionary::open(&packed).unwrap()), components);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/ccd.bin");
    std::fs::write(path, &packed).unwrap();
    println!("{path}: {} components, {} bytes", components.len(), packed.len());
}

#[test]
fn every_component_is_as_in_the_text() {
    let Some(text) = text_of_the_dictionary() else { return };
    let (expected, got) = (encode::parse(&text), all(embedded()));
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(&expected) {
        assert_eq!(got, expected);
    }
}

#[test]
fn the_dictionary_holds_what_it_was_made_of() {
    let all = all(embedded());
    let atoms: usize = all.iter().map(|(_, component)| component.atoms.len()).sum();
    let bonds: usize = all.iter().map(|(_, component)| component.bonds.len()).sum();
    assert_eq!((all.len(), atoms, bonds), (embedded().index.len(), 2_315_717, 2_409_356));
    assert!(all.is_sorted_by(|a, b| a.0 < b.0));
    // FNV-1a over names, elements, charges and bonds.
    let mut sum = 0xcbf2_9ce4_8422_2325u64;
    let mut add = |bytes: &[u8]| {
        for &byte in bytes {
            sum = (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    for (id, component) in &all {
        add(id.as_bytes());
        for atom in &component.atoms {
            add(&atom.name);
            add(&[atom.element.z(), u8::from(atom.deuterium), atom.charge as u8]);
        }
        for bond in &component.bonds {
            add(&bond.a.to_le_bytes());
            add(&bond.b.to_le_bytes());
            add(&[bond.order.number(), u8::from(bond.aromatic)]);
        }
    }
    assert_eq!(sum, 0xf1c1_0846_7640_fc94);
}

fn names(component: &Component) -> Vec<&str> {
    component.atoms.iter().map(|atom| std::str::from_utf8(&atom.name).unwrap().trim_end_matches('\0')).collect()
}

#[test]
fn components_are_found_by_their_ids() {
    let water = component("HOH").unwrap();
    assert_eq!(names(&water), ["O", "H1", "H2"]);
    assert_eq!(water.bonds.len(), 2);
    let alanine = component("ALA").unwrap();
    assert_eq!(names(&alanine)[..5], ["N", "CA", "C", "O", "CB"]);
    let carbonyl = alanine.bonds.iter().find(|bond| (bond.a, bond.b) == (2, 3)).unwrap();
    assert_eq!((carbonyl.order, carbonyl.aromatic), (BondOrder::Double, false));
    assert_eq!(component("ZN").unwrap().atoms[0].charge, 2);
    assert!(component("UNL").unwrap().atoms.is_empty());
    // The first, the last, one of five letters, and one whose atom names hold a colon and a prime.
    assert!(component("000").is_some() && component("ZZZ").is_some());
    assert!(names(&component("Y7I").unwrap()).contains(&"H:A"));
    assert!(names(&component("DA").unwrap()).contains(&"C5'"));
    for absent in ["", "LIG", "POPC", "alanine", "ala", "\0", "ZZZZZ", "!"] {
        assert!(component(absent).is_none(), "{absent:?}");
    }
}

#[test]
fn damaged_bytes_are_no_dictionary_and_no_panic() {
    let all: Vec<_> = ["ALA", "GLY", "HEM", "HOH", "DA", "FES"]
        .map(|id| (id.to_owned(), Component::clone(&component(id).unwrap())))
        .to_vec();
    let packed = encode::pack(&encode_sorted(all));
    let read = |bytes: &[u8]| {
        let dictionary = Dictionary::open(bytes)?;
        ["ALA", "HOH", "ZZZ"].iter().filter_map(|id| dictionary.find(padded(id.as_bytes())?)).next()
    };
    assert!(read(&packed).is_some());
    for length in 0..packed.len() {
        let _ = read(&packed[..length]);
    }
    for at in 0..packed.len() {
        for flip in [1, 0x80, 0xff] {
            let mut bytes = packed.clone();
            bytes[at] ^= flip;
            let _ = read(&bytes);
        }
    }
}

fn encode_sorted(mut components: Vec<(String, Component)>) -> Vec<(String, Component)> {
    components.sort_by(|a, b| a.0.cmp(&b.0));
    components
}
