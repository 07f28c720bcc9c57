//! Sessions that older versions wrote.
//!
//! The number in `ballstick_session` is that of the format:
//!
//! - 1: the first one. Its files may lack settings that came while it was in use, which a picture then had as [`SINCE_1`] says; lists, measures and colours that
//!   came later were empty or not chosen, which is what a missing one means in any version.
//! - 2: all settings that are in [`SINCE_1`] stand in the file.
//!
//! A setting that comes later gets its usual value where it is missing and needs no new version; one that changes its meaning does, and a line here that says what it
//! meant.

use super::VERSION;
use crate::error::{Error, Result};
use serde::de::IgnoredAny;
use std::borrow::Cow;
use std::collections::HashMap;

/// What files of version 1 may lack, and what their pictures were drawn with.
const SINCE_1: [(&str, &str); 5] = [
    // Lights came from the camera's upper left.
    ("light", "\"camera\""),
    ("ball_scale", "1"),
    ("stick_scale", "1"),
    // Only hydrogens and water could be left out.
    ("ions", "true"),
    // A frame of a file that lists its atoms had bonds of its own.
    ("bonds_per_frame", "\"auto\""),
];

/// The JSON of a session of a version as this one reads it. What is added stands in the line of the first brace, so that errors name the file's own
/// lines.
///
/// # Errors
/// [`Error::Unsupported`] for a version that is newer, or none; [`Error::Input`] for what is no JSON object.
pub(super) fn upgraded(bytes: &[u8], version: u32) -> Result<Cow<'_, [u8]>> {
    match version {
        VERSION => Ok(Cow::Borrowed(bytes)),
        1 => from_1(bytes).map(Cow::Owned),
        newer if newer > VERSION => Err(Error::Unsupported(format!(
            "the session is of version {newer}, and this program reads versions 1 to {VERSION}; a newer ballstick reads it"
        ))),
        none => Err(Error::Unsupported(format!(
            "the session is of version {none}, which there is none of; the first one is 1"
        ))),
    }
}

fn from_1(bytes: &[u8]) -> Result<Vec<u8>> {
    let no_object = || Error::input(None, "this is no session: expected a JSON object");
    let known: HashMap<String, IgnoredAny> = serde_json::from_slice(bytes).map_err(|_| no_object())?;
    let brace = bytes.iter().position(|&byte| byte == b'{').ok_or_else(no_object)?;
    let mut upgraded = bytes[..=brace].to_vec();
    for (field, value) in SINCE_1.iter().filter(|(field, _)| !known.contains_key(*field)) {
        upgraded.extend_from_slice(format!("\"{field}\":{value},").as_bytes());
    }
    upgraded.extend_from_slice(&bytes[brace + 1..]);
    Ok(upgraded)
}

#[cfg(test)]
mod tests {
    use super::super::{Session, Settings, VERSION};
    use crate::crystal::CrystalOptions;
    use crate::render::Quality;
    use crate::scene::{LightFrame, SceneOptions, Style};
    use std::path::Path;

    /// As the first version wrote it, before lights, outlines, selections, sizes, meshes and films.
    const FIRST: &str = r##"{
  "ballstick_session": 1,
  "files": [{"path": "caffeine.sdf", "frame": 2, "visible": true}],
  "style": "licorice",
  "color_by": "chain",
  "look": "soft",
  "background": "#102030",
  "ground": false,
  "projection": "orthographic",
  "camera": null,
  "fitted": true,
  "hydrogens": false,
  "water": true,
  "altloc": "B",
  "aromatic": "dashes",
  "haptic": false,
  "vectors": "none",
  "vector_scale": null,
  "axes": true,
  "label": ["element", "index"],
  "label_size": 1.5,
  "legend": true,
  "scale_bar": false,
  "bonds": "auto",
  "hbonds": true,
  "cell": "full",
  "supercell": [2, 1, 1],
  "cell_box": null,
  "quality": "high",
  "picked": [[1, 3]],
  "measurements": [[[1, 1], [1, 2]]]
}"##;

    #[test]
    fn a_session_of_the_first_version_means_what_it_meant() {
        let session = Session::parse(FIRST.as_bytes(), Path::new("/molecules")).unwrap();
        assert_eq!(session.ballstick_session, VERSION);
        assert_eq!(session.files[0].path, Path::new("/molecules/caffeine.sdf"));
        let settings = session.settings().unwrap();
        let scene = &settings.scene;
        assert_eq!(
            (scene.style, scene.ground, scene.hydrogens, scene.perspective),
            (Style::Licorice, false, false, false)
        );
        assert_eq!(
            (scene.light, scene.ball_scale, scene.stick_scale, scene.ions),
            (LightFrame::Camera, 1.0, 1.0, true)
        );
        assert!(scene.by_selection == Default::default() && scene.outline.is_none() && session.overlay.is_empty());
        assert_eq!(settings.crystal.supercell, [2, 1, 1]);
        // Written again it is of this version, and the same.
        let again = Session::parse(session.text(None).1.as_bytes(), Path::new("")).unwrap();
        assert_eq!(again.settings().unwrap(), settings);
    }

    #[test]
    fn errors_in_old_sessions_name_their_own_lines() {
        let wrong = FIRST.replace("\"ground\": false", "\"ground\": 7");
        let error = Session::parse(wrong.as_bytes(), Path::new("")).unwrap_err().to_string();
        assert!(error.starts_with("line 8: "), "{error}");
    }

    #[test]
    fn newer_sessions_are_refused_and_say_so() {
        for (number, says) in
            [("3", "a newer ballstick reads it"), ("4000000000", "newer"), ("0", "the first one is 1")]
        {
            let text = FIRST.replace("session\": 1", &format!("session\": {number}"));
            let error = Session::parse(text.as_bytes(), Path::new("")).unwrap_err().to_string();
            assert!(error.contains(says) && error.contains(number), "{error}");
        }
    }

    #[test]
    fn a_session_of_this_version_lacks_nothing() {
        let plain = Settings {
            scene: SceneOptions::default(),
            crystal: CrystalOptions::default(),
            cell_box: None,
            quality: Quality::default(),
            viewpoint: None,
        };
        let text = serde_json::to_value(Session::of(&plain)).unwrap();
        for (field, _) in super::SINCE_1 {
            let mut less = text.clone();
            less.as_object_mut().unwrap().remove(field).unwrap();
            let error = Session::parse(less.to_string().as_bytes(), Path::new("")).unwrap_err().to_string();
            assert!(error.contains(field), "{error}");
        }
    }
}
