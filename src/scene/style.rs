//! Representations: which radius an atom and a stick have.

use crate::element::Element;
use crate::structure::BondKind;

/// A representation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// Balls of a quarter of the van der Waals radius, sticks between them.
    #[default]
    BallAndStick,
    /// Thick sticks with rounded corners, no balls.
    Licorice,
    /// Balls of the full van der Waals radius.
    SpaceFilling,
    /// Thin sticks.
    Wireframe,
}

impl Style {
    /// All of them, in the order of the window's number keys.
    pub const ALL: [Style; 4] = [Style::BallAndStick, Style::Licorice, Style::SpaceFilling, Style::Wireframe];

    /// The name in flags and settings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Style::BallAndStick => "ball-and-stick",
            Style::Licorice => "licorice",
            Style::SpaceFilling => "space-filling",
            Style::Wireframe => "wireframe",
        }
    }

    /// The style of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Style> {
        Style::ALL.into_iter().find(|style| style.name() == name)
    }

    /// Radius of an atom in ångström; `bonded` says whether a stick of this style ends there.
    ///
    /// The proportions are ours, chosen by eye between those of other viewers (ball 0.25–0.3 of the van der Waals
    /// radius, stick 0.1–0.25 Å): a C–C bond shows about as much stick as ball.
    #[must_use]
    pub fn atom_radius(self, element: Element, bonded: bool) -> f32 {
        let vdw = element.vdw_radius();
        match self {
            Style::BallAndStick => 0.23 * vdw,
            Style::SpaceFilling => vdw,
            Style::Licorice if bonded => LICORICE_RADIUS,
            Style::Wireframe if bonded => WIRE_RADIUS,
            // An atom without bonds is never invisible.
            Style::Licorice => (0.23 * vdw).max(LICORICE_RADIUS),
            Style::Wireframe => 0.12 * vdw,
        }
    }

    /// Radius of a single bond's stick in ångström, `None` if the style has no sticks.
    #[must_use]
    pub fn stick_radius(self, kind: BondKind) -> Option<f32> {
        let full = match self {
            Style::BallAndStick => 0.13,
            Style::Licorice => LICORICE_RADIUS,
            Style::SpaceFilling => return None,
            Style::Wireframe => WIRE_RADIUS,
        };
        // What is no shared electron pair is drawn thin.
        Some(if kind == BondKind::Covalent { full } else { 0.5 * full })
    }

    /// Radius that the sticks of double and triple bonds are proportioned by, in ångström: of a single bond's stick, but
    /// in licorice so thin that three of them end inside the rounded corner.
    #[must_use]
    pub(super) fn multiple_radius(self) -> f32 {
        match self {
            Style::Licorice => LICORICE_RADIUS / 1.75,
            Style::BallAndStick | Style::SpaceFilling | Style::Wireframe => f32::INFINITY,
        }
    }
}

impl Style {
    /// Of two styles the one with the thinner sticks; one without sticks only if both are.
    pub(super) fn thinner(self, other: Style) -> Style {
        let radius = |style: Style| style.stick_radius(BondKind::Covalent).unwrap_or(f32::INFINITY);
        if radius(other) < radius(self) { other } else { self }
    }
}

/// How much larger than usual balls and sticks are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sizes {
    pub(super) ball: f32,
    pub(super) stick: f32,
}

impl Sizes {
    pub(super) const USUAL: Sizes = Sizes { ball: 1.0, stick: 1.0 };

    /// Radius of an atom in ångström. Where sticks meet without a ball, it is theirs.
    pub(super) fn ball(self, style: Style, element: Element, bonded: bool) -> f32 {
        let usual = style.atom_radius(element, bonded);
        match style {
            Style::Licorice | Style::Wireframe if bonded => usual * self.stick,
            _ => usual * self.ball,
        }
    }

    /// Radius of a single bond's stick in ångström.
    pub(super) fn stick(self, style: Style, kind: BondKind) -> Option<f32> {
        style.stick_radius(kind).map(|usual| usual * self.stick)
    }

    /// Radius that the sticks of multiple bonds are proportioned by, in ångström.
    pub(super) fn multiple(self, style: Style) -> f32 {
        style.multiple_radius() * self.stick
    }
}

const LICORICE_RADIUS: f32 = 0.22;
const WIRE_RADIUS: f32 = 0.035;
