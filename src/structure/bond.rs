//! Bonds and where they come from.

/// Formal order of a bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(u8)]
pub enum BondOrder {
    /// Not known, or none in the sense of valence (coordination, hydrogen bonds); drawn as one stick.
    Unknown = 0,
    /// Single.
    #[default]
    Single = 1,
    /// Double.
    Double = 2,
    /// Triple.
    Triple = 3,
    /// Quadruple (metal–metal).
    Quadruple = 4,
}

impl BondOrder {
    /// From a number; anything but 1–4 is [`BondOrder::Unknown`].
    #[must_use]
    pub fn from_number(order: u32) -> BondOrder {
        match order {
            1 => BondOrder::Single,
            2 => BondOrder::Double,
            3 => BondOrder::Triple,
            4 => BondOrder::Quadruple,
            _ => BondOrder::Unknown,
        }
    }

    /// 0 (unknown) to 4.
    #[must_use]
    pub fn number(self) -> u8 {
        self as u8
    }
}

/// What holds the two atoms together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum BondKind {
    /// Shared electrons.
    #[default]
    Covalent,
    /// A metal and a donor.
    Coordination,
    /// Dative (one atom gives both electrons), as a file states it.
    Dative,
    /// Hydrogen bond.
    Hydrogen,
}

impl BondKind {
    /// The name in our JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            BondKind::Covalent => "covalent",
            BondKind::Coordination => "coordination",
            BondKind::Dative => "dative",
            BondKind::Hydrogen => "hydrogen",
        }
    }

    /// The kind of a name in our JSON.
    #[must_use]
    pub fn from_name(name: &str) -> Option<BondKind> {
        [BondKind::Covalent, BondKind::Coordination, BondKind::Dative, BondKind::Hydrogen]
            .into_iter()
            .find(|kind| kind.name() == name)
    }
}

/// Who says that there is a bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum BondSource {
    /// The file's bond list (bond block, CONECT, JSON).
    #[default]
    File,
    /// SSBOND, LINK or `_struct_conn` of the file.
    Link,
    /// The wwPDB Chemical Component Dictionary, or the polymer link between residues.
    Dictionary,
    /// The distance between the atoms.
    Distance,
}

impl BondSource {
    /// The name in our JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            BondSource::File => "file",
            BondSource::Link => "link",
            BondSource::Dictionary => "dictionary",
            BondSource::Distance => "distance",
        }
    }

    /// The source of a name in our JSON.
    #[must_use]
    pub fn from_name(name: &str) -> Option<BondSource> {
        [BondSource::File, BondSource::Link, BondSource::Dictionary, BondSource::Distance]
            .into_iter()
            .find(|source| source.name() == name)
    }
}

/// A bond between two atoms of one structure, or between an atom and a periodic image of another; 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Bond {
    /// Index of one atom; in [`crate::structure::Structure::bonds`] the smaller one.
    pub a: u32,
    /// Index of the other atom.
    pub b: u32,
    /// Formal order; an aromatic bond has the order of one Kekulé form, or `Unknown` where none is known.
    pub order: BondOrder,
    /// What it is.
    pub kind: BondKind,
    /// Who says so.
    pub source: BondSource,
    /// Part of an aromatic ring.
    pub aromatic: bool,
    /// Which periodic image of atom `b` it is bonded to: whole cell vectors added to the position that the file gives.
    /// All 0 for a bond inside what the file lists.
    pub image: [i8; 3],
}

impl Bond {
    /// A covalent bond that is not aromatic, its atoms in ascending order, both as the file lists them.
    #[must_use]
    pub fn new(a: u32, b: u32, order: BondOrder, source: BondSource) -> Bond {
        Bond { a: a.min(b), b: a.max(b), order, kind: BondKind::Covalent, source, aromatic: false, image: [0; 3] }
    }

    /// Whether it goes to a periodic image, not to the atom as it stands in the file.
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        self.image != [0; 3]
    }

    /// What tells it from the other bonds of a structure, and their order.
    #[must_use]
    pub fn key(&self) -> (u32, u32, [i8; 3]) {
        (self.a, self.b, self.image)
    }

    /// The same bond seen so that `a < b`, or, from an atom to its own image, so that the first shift that is not 0 is
    /// positive.
    #[must_use]
    pub fn turned(self) -> Bond {
        let back = self.image.map(i8::saturating_neg);
        let turn = self.a > self.b || (self.a == self.b && back > self.image);
        if turn { Bond { a: self.b, b: self.a, image: back, ..self } } else { self }
    }
}

/// What the bond list of a file means for the bonds it does not list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StatedBonds {
    /// The file has no bond list: all bonds are to be found.
    #[default]
    None,
    /// The file lists some bonds (CONECT, LINK, `_struct_conn`): the rest is to be found.
    Partial,
    /// The file's list, even an empty one, is exactly the bonds (SDF, MOL2, JSON).
    Complete,
}

/// Turned and sorted by [`Bond::key`], no duplicates (the first of a pair stays), no bonds of an atom to itself but to
/// its images, all atoms below `atom_count`.
pub(super) fn normalise(mut bonds: Vec<Bond>, atom_count: usize) -> Vec<Bond> {
    // Bonds that were found are as they should be.
    let is_sound = |bond: &Bond| bond.a < bond.b && (bond.b as usize) < atom_count;
    let are_in_order = |pair: &[Bond]| pair[0].key() < pair[1].key();
    if bonds.iter().all(is_sound) && bonds.windows(2).all(are_in_order) {
        return bonds;
    }
    for bond in &mut bonds {
        *bond = bond.turned();
    }
    bonds.retain(|bond| (bond.a != bond.b || bond.is_periodic()) && (bond.b as usize) < atom_count);
    bonds.sort_by_key(Bond::key); // stable: the first of a pair stays the first
    bonds.dedup_by_key(|bond| bond.key());
    bonds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bond_takes_16_bytes() {
        assert_eq!(size_of::<Bond>(), 16);
    }

    #[test]
    fn normalise_sorts_turns_and_drops_what_cannot_be() {
        let bond = |a, b, order| Bond { a, b, ..Bond::new(0, 1, order, BondSource::File) };
        let bonds = vec![
            bond(3, 1, BondOrder::Double),
            bond(1, 3, BondOrder::Single),
            bond(2, 2, BondOrder::Single),
            bond(0, 9, BondOrder::Single),
            bond(0, 2, BondOrder::Single),
        ];
        let got = normalise(bonds, 4);
        assert_eq!(got, vec![bond(0, 2, BondOrder::Single), bond(1, 3, BondOrder::Double)]);
    }

    #[test]
    fn bonds_to_images_are_told_apart() {
        let to = |a, b, image| Bond { a, b, image, ..Bond::new(0, 1, BondOrder::Single, BondSource::Distance) };
        // Two images of one pair, the second one given from its other end, and an atom with its own image both ways.
        let bonds = vec![to(0, 1, [1, 0, 0]), to(1, 0, [0, 0, 1]), to(2, 2, [0, -1, 0]), to(2, 2, [0, 1, 0])];
        let got = normalise(bonds, 3);
        assert_eq!(got, vec![to(0, 1, [0, 0, -1]), to(0, 1, [1, 0, 0]), to(2, 2, [0, 1, 0])]);
    }
}
