//! Bonds inside residues, by the names of their atoms.

use super::BondOrder;

/// The bonds inside every residue of one name, as the file states them (`_chem_comp_bond` of an mmCIF file).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComponentBonds {
    /// Residue name (`HEM`).
    pub name: String,
    /// The bonds.
    pub bonds: Vec<ComponentBond>,
}

/// One of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComponentBond {
    /// Name of one atom (`CA`).
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// Its order.
    pub order: BondOrder,
    /// Whether the file calls it aromatic.
    pub aromatic: bool,
}
