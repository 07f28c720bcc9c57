//! What the window remembers from one time to the next: theme, mouse, recent files. One JSON file where the system keeps such things
//! (`$XDG_CONFIG_HOME/ballstick/window.json`).
//!
//! A file that cannot be read is as good as none: preferences are never worth an error.

use super::mouse::Preset;
use crate::export::atomic;
use std::path::{Path, PathBuf};

/// Recent files that are kept.
const MOST_RECENT: usize = 10;

/// Light or dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Theme {
    /// As the system has it.
    #[default]
    System,
    Light,
    Dark,
}

impl Theme {
    pub(super) const ALL: [Theme; 3] = [Theme::System, Theme::Light, Theme::Dark];

    pub(super) fn name(self) -> &'static str {
        match self {
            Theme::System => "system",
            Theme::Light => "light",
            Theme::Dark => "dark",
        }
    }
}

/// The preferences.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub(super) struct Preferences {
    pub(super) theme: Theme,
    pub(super) mouse: Preset,
    /// Whether files that change on the disk are read again.
    pub(super) reloads: bool,
    /// Whether the panel is open.
    pub(super) panel: bool,
    /// The newest first.
    pub(super) recent: Vec<PathBuf>,
    #[serde(skip)]
    file: Option<PathBuf>,
}

impl Default for Preferences {
    fn default() -> Self {
        let (theme, mouse) = (Theme::default(), Preset::default());
        Preferences { theme, mouse, reloads: true, panel: true, recent: Vec::new(), file: None }
    }
}

impl Preferences {
    /// Those of the user.
    pub(super) fn of_user() -> Preferences {
        folder().map_or_else(Preferences::default, |folder| Preferences::from_file(&folder.join("window.json")))
    }

    /// Those of a file, to which changes go.
    pub(super) fn from_file(file: &Path) -> Preferences {
        let read = std::fs::read(file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        Preferences { file: Some(file.to_owned()), ..read.unwrap_or_default() }
    }

    /// Puts a file on top of the recent ones.
    pub(super) fn opened(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
        self.save();
    }

    /// Writes them down, if there is a place.
    pub(super) fn save(&self) {
        let Some(file) = &self.file else { return };
        let Ok(text) = serde_json::to_vec_pretty(self) else { return };
        // A full or write-protected disk must not keep anybody from looking at molecules.
        if file.parent().is_some_and(|folder| std::fs::create_dir_all(folder).is_ok()) {
            let _ = atomic::write(file, |out| out.write_all(&text));
        }
    }
}

/// Where the system keeps what programs remember.
fn folder() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = if cfg!(target_os = "windows") {
        variable("APPDATA")?
    } else if cfg!(target_os = "macos") {
        variable("HOME")?.join("Library/Application Support")
    } else {
        // A relative path is to be ignored, by the XDG Base Directory Specification.
        variable("XDG_CONFIG_HOME").or_else(|| Some(variable("HOME")?.join(".config")))?
    };
    Some(base.join("ballstick"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_come_back_and_broken_ones_are_the_usual() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/window.json");
        let mut preferences = Preferences::from_file(&file);
        assert_eq!((preferences.theme, preferences.panel), (Theme::System, true));
        preferences.theme = Theme::Dark;
        for name in (0..12).map(|n| format!("/{n}.pdb")).chain(["/3.pdb".to_owned()]) {
            preferences.opened(Path::new(&name));
        }
        let again = Preferences::from_file(&file);
        assert_eq!(again, preferences);
        let names: Vec<_> = again.recent.iter().map(|path| path.display().to_string()).collect();
        assert_eq!((names.len(), names[0].as_str(), names[1].as_str()), (10, "/3.pdb", "/11.pdb"));
        std::fs::write(&file, "{\"theme\": \"mauve\"}").unwrap();
        assert_eq!(Preferences::from_file(&file).theme, Theme::System);
    }
}
