//! Which inputs go into which picture.

use super::apart;
use super::report::Report;
use crate::export::picture::PictureFormat;
use crate::import::trajectory::{Input, inputs};
use std::collections::HashMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// What takes the place of the input's name in a pattern.
const STEM: &str = "{stem}";

/// The pictures to make.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Plan {
    pub(super) pictures: Vec<Picture>,
    /// Inputs whose picture would have the name of an earlier one.
    pub(super) clashes: Vec<Clash>,
    /// A folder to make first.
    pub(super) new_folder: Option<PathBuf>,
    /// Whether each input has a picture of its own.
    pub(super) is_each: bool,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Picture {
    pub(super) inputs: Vec<Input>,
    pub(super) output: PathBuf,
}

impl Plan {
    /// Leaves only the picture that is this process' own, if another one began it for that ([`super::apart`]). If this process is
    /// to begin others, hands out where each picture stands.
    pub(super) fn apart(&mut self) -> Option<HashMap<PathBuf, usize>> {
        if let Some(own) = apart::own_input() {
            let mut number = 0..;
            self.pictures.retain(|_| number.next() == Some(own));
            (self.clashes, self.new_folder) = (Vec::new(), None);
        }
        let places = || self.pictures.iter().map(|picture| picture.output.clone()).zip(0..).collect();
        apart::is_wanted().then(places)
    }
}

impl Picture {
    /// Has another process make it, of all those that stand at these `places`; `also` are files that it needs as well.
    pub(super) fn made_apart(
        &self,
        places: &HashMap<PathBuf, usize>,
        also: &[PathBuf],
        report: &Report,
    ) -> crate::Result<bool> {
        let files = self.inputs.iter().flat_map(|input| std::iter::once(&input.structure).chain(&input.trajectories));
        let files: Vec<&Path> = files.chain(also).map(PathBuf::as_path).collect();
        apart::run(places.get(&self.output).copied().unwrap_or(0), &files, Some(&self.output), report)
    }
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Clash {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    pub(super) earlier: PathBuf,
}

impl std::fmt::Display for Clash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [input, output, earlier] = [&self.input, &self.output, &self.earlier].map(|path| path.display());
        write!(
            f,
            "{input}: not drawn, as {output} is the picture of {earlier} already; choose another folder or pattern for one of them"
        )
    }
}

/// The plan for `render FILE… -o OUT`, and the format of its pictures; an error is one of usage.
pub(super) fn plan(files: &[PathBuf], output: &Path, to: Option<&str>) -> Result<(Plan, PictureFormat), String> {
    let to = to.map(|name| {
        PictureFormat::from_name(name)
            .ok_or_else(|| format!("--to {name}: use png, jpg, webp, ppm or npy, or gif, apng or mp4 for films"))
    });
    let is_nameless = crate::export::atomic::is_stdout(output) || output.starts_with("/dev") || is_folder(output);
    let format = match to.transpose()? {
        Some(format) => format,
        None if is_nameless => PictureFormat::Png,
        None => PictureFormat::from_path(output).map_err(|error| error.to_string())?,
    };
    Ok((outputs(files, output, format.extensions()[0])?, format))
}

/// Whether pictures go into a folder, under names of their own.
fn is_folder(output: &Path) -> bool {
    let text = output.to_string_lossy();
    !text.contains(STEM) && (output.is_dir() || text.ends_with(std::path::is_separator))
}

/// Which files are made of which; in a folder they have this extension.
pub(super) fn outputs(files: &[PathBuf], output: &Path, extension: &str) -> Result<Plan, String> {
    if files.iter().filter(|file| file.as_os_str() == "-").count() > 1 {
        return Err("- is given twice, but standard input can be read only once".to_owned());
    }
    let text = output.to_string_lossy();
    if text.contains(STEM) {
        return Ok(each(files, output, None));
    }
    if is_folder(output) {
        let pattern = output.join(format!("{STEM}.{extension}"));
        let new_folder = (!output.is_dir()).then(|| output.to_owned());
        return Ok(each(files, &pattern, new_folder));
    }
    let pictures = vec![Picture { inputs: inputs(files), output: output.to_owned() }];
    Ok(Plan { pictures, clashes: Vec::new(), new_folder: None, is_each: false })
}

fn each(files: &[PathBuf], pattern: &Path, new_folder: Option<PathBuf>) -> Plan {
    let mut plan = Plan { pictures: Vec::new(), clashes: Vec::new(), new_folder, is_each: true };
    let mut taken: HashMap<PathBuf, PathBuf> = HashMap::new();
    for input in inputs(files) {
        let output = filled(pattern, &stem(&input.structure));
        match taken.get(&output) {
            Some(earlier) => plan.clashes.push(Clash { input: input.structure, output, earlier: earlier.clone() }),
            None => {
                taken.insert(output.clone(), input.structure.clone());
                plan.pictures.push(Picture { inputs: vec![input], output });
            }
        }
    }
    plan
}

/// The pattern with the stem in its place, byte for byte: names need not be text.
#[cfg(unix)]
fn filled(pattern: &Path, stem: &OsStr) -> PathBuf {
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    let (mut rest, mut name) = (pattern.as_os_str().as_bytes(), Vec::new());
    while let Some(at) = memchr::memmem::find(rest, STEM.as_bytes()) {
        name.extend_from_slice(&rest[..at]);
        name.extend_from_slice(stem.as_bytes());
        rest = &rest[at + STEM.len()..];
    }
    name.extend_from_slice(rest);
    std::ffi::OsString::from_vec(name).into()
}

/// The pattern with the stem in its place.
#[cfg(not(unix))]
fn filled(pattern: &Path, stem: &OsStr) -> PathBuf {
    pattern.to_string_lossy().replace(STEM, &stem.to_string_lossy()).into()
}

/// The name of a file without folder and extension, `.gz` and `.zst` as well; `stdin` for `-`.
fn stem(path: &Path) -> OsString {
    if path.as_os_str() == "-" {
        return "stdin".into();
    }
    let name = path.file_name().unwrap_or_default();
    let name = Path::new(name);
    let packed = name.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz") || e.eq_ignore_ascii_case("zst"));
    let name = if packed { Path::new(name.file_stem().unwrap_or_default()) } else { name };
    name.file_stem().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trajectory_belongs_to_the_structure_before_it() {
        // By their names: none of them is there.
        let files = paths(&["a.pdb", "a.xtc", "b.gro", "b.trr"]);
        let (plan, _) = plan(&files, Path::new("o/"), None).unwrap();
        assert_eq!(outputs(&plan), ["o/a.png", "o/b.png"]);
        assert_eq!(plan.pictures[1].inputs[0].trajectories, paths(&["b.trr"]));
    }

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    fn outputs(plan: &Plan) -> Vec<&str> {
        plan.pictures.iter().map(|picture| picture.output.to_str().unwrap()).collect()
    }

    #[test]
    fn a_file_takes_all_inputs() {
        let (plan, format) = plan(&paths(&["a.sdf", "b.sdf"]), Path::new("fig.webp"), None).unwrap();
        assert_eq!((plan.pictures.len(), format), (1, PictureFormat::WebP));
        assert_eq!(plan.pictures[0].inputs, [Input::of("a.sdf".into()), Input::of("b.sdf".into())]);
    }

    #[test]
    fn a_folder_and_a_pattern_make_one_picture_each() {
        let folder = tempfile::tempdir().unwrap();
        let inputs = paths(&["x/1abc.cif.gz", "b.v2.sdf", "-"]);
        let (there, _) = plan(&inputs, folder.path(), None).unwrap();
        let names: Vec<_> = there.pictures.iter().map(|p| p.output.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!((names, there.new_folder), (vec!["1abc.png", "b.v2.png", "stdin.png"], None));
        let (new, _) = plan(&inputs, &folder.path().join("new/"), Some("jpg")).unwrap();
        assert!(new.new_folder.is_some() && new.pictures[0].output.ends_with("new/1abc.jpg"));
        let (pattern, _) = plan(&inputs, Path::new("out/{stem}-top.ppm"), None).unwrap();
        assert_eq!(outputs(&pattern), ["out/1abc-top.ppm", "out/b.v2-top.ppm", "out/stdin-top.ppm"]);
    }

    #[test]
    fn the_second_input_of_a_name_is_a_clash() {
        let (plan, _) = plan(&paths(&["a/x.sdf", "b/x.pdb", "y.sdf"]), Path::new("o/"), None).unwrap();
        assert_eq!(outputs(&plan), ["o/x.png", "o/y.png"]);
        assert_eq!(plan.clashes.len(), 1);
        assert_eq!(plan.clashes[0].input, PathBuf::from("b/x.pdb"));
        assert_eq!(plan.clashes[0].earlier, PathBuf::from("a/x.sdf"));
    }

    #[test]
    fn what_cannot_be_is_an_error_of_usage() {
        assert!(plan(&paths(&["a"]), Path::new("fig.tiff"), None).unwrap_err().contains(".tiff"));
        assert!(plan(&paths(&["a"]), Path::new("fig"), None).is_err());
        assert!(plan(&paths(&["a"]), Path::new("fig.png"), Some("tiff")).unwrap_err().contains("--to tiff"));
        assert!(plan(&paths(&["-", "-"]), Path::new("o/"), None).unwrap_err().contains("only once"));
    }

    #[test]
    fn standard_output_is_png_unless_said() {
        assert_eq!(plan(&paths(&["a"]), Path::new("-"), None).unwrap().1, PictureFormat::Png);
        assert_eq!(plan(&paths(&["a"]), Path::new("-"), Some("npy")).unwrap().1, PictureFormat::Npy);
        assert_eq!(plan(&paths(&["a"]), Path::new("/dev/null"), None).unwrap().1, PictureFormat::Png);
    }
}
