//! What buttons and modifiers do over the molecule, as people know it from other programs.

use super::navigate::Drag;

/// A way of using the mouse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Preset {
    /// Left turns, right and middle move, the wheel zooms.
    #[default]
    Ballstick,
    /// Left turns, middle moves, right zooms.
    Pymol,
    /// As the first, but Shift and left moves, and Ctrl with a click picks.
    Chimerax,
}

/// A mouse button.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Button {
    Left,
    Middle,
    Right,
}

impl Preset {
    pub(super) const ALL: [Preset; 3] = [Preset::Ballstick, Preset::Pymol, Preset::Chimerax];

    pub(super) fn name(self) -> &'static str {
        match self {
            Preset::Ballstick => "ballstick",
            Preset::Pymol => "PyMOL",
            Preset::Chimerax => "ChimeraX",
        }
    }

    /// What dragging with a button does.
    pub(super) fn drag(self, button: Button, shift: bool, ctrl: bool) -> Drag {
        match (self, button) {
            (Preset::Ballstick | Preset::Pymol, Button::Left) if ctrl && shift => Drag::Roll,
            (Preset::Ballstick | Preset::Pymol, Button::Left) if shift => Drag::Select,
            (Preset::Ballstick, Button::Left) if ctrl => Drag::Pan,
            // ChimeraX rolls at the edge of its window, where others turn: here with Ctrl.
            (Preset::Chimerax, Button::Right) if ctrl => Drag::Roll,
            (Preset::Chimerax, Button::Left) if ctrl => Drag::Select,
            (Preset::Chimerax, Button::Left) if shift => Drag::Pan,
            (_, Button::Left) => Drag::Orbit,
            (Preset::Pymol, Button::Right) => Drag::Zoom,
            (_, Button::Middle | Button::Right) => Drag::Pan,
        }
    }

    /// Whether a click with these modifiers picks; `Some(true)` if it adds to what is picked.
    pub(super) fn click(self, shift: bool, ctrl: bool) -> Option<bool> {
        match self {
            Preset::Ballstick | Preset::Pymol => Some(shift || ctrl),
            Preset::Chimerax => ctrl.then_some(shift),
        }
    }

    /// The lines of the help.
    pub(super) fn lines(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Preset::Ballstick => &[
                ("Left drag", "turn"),
                ("Right or middle drag, Ctrl + left drag", "move"),
                ("Ctrl + Shift + left drag", "roll"),
                ("Shift + left drag", "select in a rectangle"),
                ("Wheel, pinch", "zoom to the pointer"),
                ("Click", "pick an atom"),
                ("Shift or Ctrl + click", "pick more atoms"),
                ("Double click", "centre"),
            ],
            Preset::Pymol => &[
                ("Left drag", "turn"),
                ("Middle drag", "move"),
                ("Right drag", "zoom"),
                ("Ctrl + Shift + left drag", "roll"),
                ("Shift + left drag", "select in a rectangle"),
                ("Wheel, pinch", "zoom to the pointer"),
                ("Click", "pick an atom"),
                ("Shift or Ctrl + click", "pick more atoms"),
                ("Double click", "centre"),
            ],
            Preset::Chimerax => &[
                ("Left drag", "turn"),
                ("Right or middle drag, Shift + left drag", "move"),
                ("Ctrl + right drag", "roll"),
                ("Ctrl + left drag", "select in a rectangle"),
                ("Ctrl + Shift + left drag", "the same, beside what is selected"),
                ("Wheel, pinch", "zoom to the pointer"),
                ("Ctrl + click", "pick an atom"),
                ("Ctrl + Shift + click", "pick more atoms"),
                ("Double click", "centre"),
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_do_what_their_programs_do() {
        use {Button::*, Preset::*};
        for preset in Preset::ALL {
            assert_eq!(preset.drag(Left, false, false), Drag::Orbit);
            assert_eq!(preset.drag(Middle, false, false), Drag::Pan);
        }
        assert_eq!(
            [Ballstick, Pymol, Chimerax].map(|p| p.drag(Right, false, false)),
            [Drag::Pan, Drag::Zoom, Drag::Pan]
        );
        assert_eq!(Chimerax.drag(Left, true, false), Drag::Pan);
        assert_eq!(Preset::ALL.map(|preset| preset.drag(Left, true, true)), [Drag::Roll, Drag::Roll, Drag::Select]);
        assert_eq!([Ballstick, Pymol].map(|preset| preset.drag(Left, true, false)), [Drag::Select; 2]);
        assert_eq!(Chimerax.drag(Right, false, true), Drag::Roll);
        assert_eq!([Ballstick.click(false, false), Ballstick.click(true, false)], [Some(false), Some(true)]);
        assert_eq!([Chimerax.click(false, false), Chimerax.click(false, true)], [None, Some(false)]);
    }
}
