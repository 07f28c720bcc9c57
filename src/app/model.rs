//! What the window shows: the files, the scene made of them, the camera.

use super::Options;
use super::navigate::{self, Drag};
use crate::crystal::Drawn;
use crate::error::Result;
use crate::export::{atomic, picture};
use crate::render::{Choice, Settings, View, select};
use crate::scene::{Background, Camera, Item, Scene, SceneOptions, Style, fit};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files, scene, camera.
pub(super) struct Model {
    files: Vec<PathBuf>,
    drawn: Vec<Drawn>,
    cell_box: Option<bool>,
    options: SceneOptions,
    scene: Arc<Scene>,
    camera: Camera,
    /// Whether the view is still the fitted one: then a resize fits it anew.
    fitted: bool,
    size_px: [u32; 2],
}

impl Model {
    /// Shows what is drawn; `files` are where they come from.
    pub(super) fn new(files: Vec<PathBuf>, drawn: Vec<Drawn>, options: &Options) -> Model {
        let scene = build(&drawn, options.cell_box, &options.scene);
        let camera = scene.fitted_camera(1.6);
        let (cell_box, options) = (options.cell_box, options.scene);
        Model { files, drawn, cell_box, options, scene, camera, fitted: true, size_px: [1, 1] }
    }

    pub(super) fn first_file(&self) -> &Path {
        self.files.first().map_or(Path::new("FILE"), PathBuf::as_path)
    }

    pub(super) fn title(&self) -> String {
        let name = |file: &Path| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let names: Vec<_> = self.files.iter().map(|file| name(file)).collect();
        format!("{} – ballstick", names.join(", "))
    }

    pub(super) fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The view that fills the window.
    pub(super) fn view(&self) -> View {
        View::new(self.camera, self.size_px[0], self.size_px[1])
    }

    pub(super) fn resize(&mut self, size_px: [u32; 2]) {
        self.size_px = size_px.map(|side| side.max(1));
        if self.fitted {
            self.reset_view();
        }
    }

    pub(super) fn reset_view(&mut self) {
        self.camera = self.scene.fitted_camera(self.size_px[0] as f32 / self.size_px[1] as f32);
        self.fitted = true;
    }

    pub(super) fn drag(&mut self, drag: Drag, dx_px: f32, dy_px: f32) {
        self.fitted = false;
        let [width, height] = self.size_px;
        match drag {
            Drag::Orbit => {
                let upright = self.scene.ground.is_some();
                navigate::orbit(&mut self.camera, dx_px, dy_px, width.min(height) as f32, upright);
            }
            Drag::Pan => navigate::pan(&mut self.camera, dx_px, dy_px, height),
        }
    }

    /// Zooms by notches of the wheel about a point of the window.
    pub(super) fn zoom(&mut self, notches: f32, x_px: f32, y_px: f32) {
        self.fitted = false;
        let [width, height] = self.size_px;
        let pointer = [x_px - width as f32 * 0.5, height as f32 * 0.5 - y_px];
        navigate::zoom(&mut self.camera, notches, pointer, height, 0.5);
    }

    pub(super) fn toggle_projection(&mut self) {
        self.camera = self.camera.with_toggled_projection(fit::FOV_Y_RAD);
        self.options.perspective = !self.options.perspective;
        self.scene_mut().perspective ^= true;
        if self.fitted {
            self.reset_view();
        }
    }

    pub(super) fn toggle_ground(&mut self) {
        self.options.ground = !self.options.ground;
        let on = self.options.ground;
        self.scene_mut().set_ground(on);
    }

    pub(super) fn set_style(&mut self, style: Style) {
        if style != self.options.style {
            self.options.style = style;
            self.scene = build(&self.drawn, self.cell_box, &self.options);
            if self.fitted {
                self.reset_view();
            }
        }
    }

    fn scene_mut(&mut self) -> &mut Scene {
        Arc::make_mut(&mut self.scene)
    }

    /// Saves the picture that `render` would make of this view at the window's size, next to no other file of that name.
    pub(super) fn screenshot(&self, renderer: Choice, settings: &Settings) -> Result<PathBuf> {
        let mut renderer = select(renderer)?.renderer;
        renderer.load(Arc::clone(&self.scene))?;
        let image = renderer.image(&self.view(), settings)?;
        let stem = self.first_file().file_stem().map_or("ballstick".into(), |stem| stem.to_string_lossy());
        let path = (1..).map(|n| PathBuf::from(format!("{stem}-{n}.png"))).find(|path| !path.exists());
        let path = path.unwrap_or_else(|| PathBuf::from("ballstick.png"));
        let alpha = self.scene.background == Background::Transparent;
        let options = picture::PictureOptions { alpha, ..picture::PictureOptions::default() };
        let content = picture::Content::Color(&image);
        atomic::write(&path, |out| picture::write(content, picture::PictureFormat::Png, &options, out))?;
        Ok(path)
    }
}

fn build(drawn: &[Drawn], cell_box: Option<bool>, options: &SceneOptions) -> Arc<Scene> {
    let items: Vec<Item<'_>> = drawn.iter().map(|drawn| Item::drawn(drawn, cell_box)).collect();
    Arc::new(Scene::new(&items, options))
}
