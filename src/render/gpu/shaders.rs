//! Shader sources: the `.wgsl` files of `shaders/`, embedded, and their `#import`s resolved.
//!
//! A line `#import "name.wgsl"` is replaced by that file the first time it is met and by nothing after that
//! (paste-once), so that diamonds of imports are fine and cycles end. Everything lives in one namespace.

use crate::error::{Error, Result};
use std::collections::HashSet;

macro_rules! embed {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name)))),*]
    };
}

/// Every shader file: name and text. A test compares the list with the folder.
pub const FILES: &[(&str, &str)] = embed![
    "bounds.wgsl",
    "color.wgsl",
    "common.wgsl",
    "cone.wgsl",
    "cone_hit.wgsl",
    "cull.wgsl",
    "cylinder.wgsl",
    "cylinder_listed.wgsl",
    "cylinder_small.wgsl",
    "distance.wgsl",
    "field.wgsl",
    "footprint.wgsl",
    "fullscreen.wgsl",
    "geometry.wgsl",
    "ground_map.wgsl",
    "hidden.wgsl",
    "intersect.wgsl",
    "members.wgsl",
    "normal.wgsl",
    "opacity.wgsl",
    "outline.wgsl",
    "owner.wgsl",
    "placed.wgsl",
    "pyramid.wgsl",
    "resolve.wgsl",
    "shade.wgsl",
    "shade_pass.wgsl",
    "sky.wgsl",
    "small.wgsl",
    "sphere.wgsl",
    "sphere_listed.wgsl",
    "sphere_small.wgsl",
    "torus.wgsl",
    "torus_hit.wgsl",
    "trapezoid.wgsl",
    "triangle.wgsl",
    "triangle_hit.wgsl",
    "tubes.wgsl",
    "unpack.wgsl",
];

/// The files that hold entry points, each of them a module.
pub const MODULES: &[&str] = &[
    "sphere.wgsl",
    "cylinder.wgsl",
    "cone.wgsl",
    "torus.wgsl",
    "triangle.wgsl",
    "ground_map.wgsl",
    "shade_pass.wgsl",
    "resolve.wgsl",
    "sphere_listed.wgsl",
    "cylinder_listed.wgsl",
    "sphere_small.wgsl",
    "cylinder_small.wgsl",
    "pyramid.wgsl",
    "cull.wgsl",
];

/// The text of an embedded file with its imports pasted in.
///
/// # Errors
/// [`Error::Gpu`] for a file that does not exist and for a malformed import.
pub fn source(name: &str) -> Result<String> {
    resolve(name, &|file| FILES.iter().find(|(known, _)| *known == file).map(|(_, text)| *text))
}

fn resolve<'a>(name: &str, file: &impl Fn(&str) -> Option<&'a str>) -> Result<String> {
    let mut text = String::new();
    paste(name, file, &mut HashSet::new(), &mut text)?;
    Ok(text)
}

fn paste<'a>(
    name: &str,
    file: &impl Fn(&str) -> Option<&'a str>,
    pasted: &mut HashSet<String>,
    text: &mut String,
) -> Result<()> {
    if !pasted.insert(name.to_owned()) {
        return Ok(());
    }
    let body = file(name).ok_or_else(|| Error::Gpu(format!("there is no shader file \"{name}\"")))?;
    for (index, line) in body.lines().enumerate() {
        if let Some(import) = line.trim_start().strip_prefix("#import") {
            let quoted = import.trim().strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
            let wanted = quoted.filter(|wanted| !wanted.is_empty() && !wanted.contains('"')).ok_or_else(|| {
                let line = index + 1;
                Error::Gpu(format!("{name}, line {line}: expected #import \"file.wgsl\", found #import{import}"))
            })?;
            paste(wanted, file, pasted, text)?;
        } else {
            text.push_str(line);
            text.push('\n');
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[(&str, &'static str)], name: &str) -> Result<String> {
        let files: Vec<(String, &'static str)> = files.iter().map(|&(name, text)| (name.to_owned(), text)).collect();
        resolve(name, &|wanted| files.iter().find(|(name, _)| name == wanted).map(|(_, text)| *text))
    }

    #[test]
    fn imports_are_pasted_once_where_they_are_first_met() {
        let files = [
            ("top", "#import \"left\"\n  #import \"right\"\ntop"),
            ("left", "#import \"base\"\nleft"),
            ("right", "#import \"base\"\nright"),
            ("base", "base"),
        ];
        assert_eq!(of(&files, "top").unwrap(), "base\nleft\nright\ntop\n");
    }

    #[test]
    fn cycles_end() {
        assert_eq!(of(&[("a", "#import \"b\"\na"), ("b", "#import \"a\"\nb")], "a").unwrap(), "b\na\n");
    }

    #[test]
    fn missing_and_malformed_imports_say_where() {
        let message = |files: &[(&str, &'static str)]| of(files, "a").unwrap_err().to_string();
        assert!(message(&[("a", "#import \"b\"")]).contains("no shader file \"b\""));
        assert!(message(&[("a", "\n#import b")]).contains("a, line 2"));
        for bad in ["#import", "#import \"\"", "#import \"b\" \"c\"", "#import \"b"] {
            let bad: &'static str = bad;
            assert!(message(&[("a", bad), ("b", "")]).contains("expected #import"), "{bad}");
        }
    }

    #[test]
    fn every_module_resolves() {
        for module in MODULES {
            assert!(!source(module).unwrap().contains("#import"));
        }
    }
}
