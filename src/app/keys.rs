//! What each key does.

use crate::scene::Style;
use winit::keyboard::{Key, NamedKey};

/// Something a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    /// Back to the first view (`R`, Home).
    Reset,
    /// Perspective or orthographic (`O`).
    ToggleProjection,
    /// Ground on or off (`G`).
    ToggleGround,
    /// Ball-and-stick, licorice, space-filling, wireframe (`1`–`4`).
    Style(Style),
    /// Save a picture (`S`).
    Screenshot,
    /// Close (`Q`, Escape).
    Quit,
}

/// The action of a key; a key that is held down repeats nothing.
pub(super) fn action_of(key: &Key, repeat: bool) -> Option<Action> {
    if repeat {
        return None;
    }
    match key.as_ref() {
        Key::Named(NamedKey::Home) => Some(Action::Reset),
        Key::Named(NamedKey::Escape) => Some(Action::Quit),
        Key::Character(text) => match text {
            "r" | "R" => Some(Action::Reset),
            "o" | "O" => Some(Action::ToggleProjection),
            "g" | "G" => Some(Action::ToggleGround),
            "s" | "S" => Some(Action::Screenshot),
            "q" | "Q" => Some(Action::Quit),
            "1" | "2" | "3" | "4" => {
                let index = text.parse::<usize>().ok()?.checked_sub(1)?;
                Style::ALL.get(index).copied().map(Action::Style)
            }
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(text: &str) -> Option<Action> {
        action_of(&Key::Character(text.into()), false)
    }

    #[test]
    fn keys_do_what_the_readme_says() {
        assert_eq!(typed("r"), Some(Action::Reset));
        assert_eq!(typed("O"), Some(Action::ToggleProjection));
        assert_eq!(typed("g"), Some(Action::ToggleGround));
        assert_eq!(typed("s"), Some(Action::Screenshot));
        let styles: Vec<_> = ["1", "2", "3", "4"].map(typed).into_iter().flatten().collect();
        assert_eq!(styles, Style::ALL.map(Action::Style));
        assert_eq!(typed("5"), None);
        assert_eq!(action_of(&Key::Named(NamedKey::Home), false), Some(Action::Reset));
    }

    #[test]
    fn a_held_key_acts_once() {
        assert_eq!(action_of(&Key::Character("s".into()), true), None);
    }
}
