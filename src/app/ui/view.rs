//! The molecule's place in the window: what the mouse does there, and what is drawn over the picture by the interface (rings about picked
//! atoms, what is being measured, what is under the pointer).

use super::{theme, tip};
use crate::app::action::Action;
use crate::app::mouse::Button;
use crate::app::navigate::{self, Drag};
use crate::app::picking::{self, Target};
use crate::app::selecting::{self, How};
use crate::app::state::{NEAREST, State};
use crate::app::work::AtomKey;
use crate::color::Srgb8;
use crate::scene::Camera;
use egui::{Color32, Event, MouseWheelUnit, Painter, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};
use glam::Vec3;
use std::time::Instant;

/// What the view keeps from frame to frame.
#[derive(Default)]
pub(super) struct Memory {
    /// Where the pointer was last, since when it is there, and what is under it.
    pointer: Option<(Pos2, Instant, Option<Target>)>,
    version: u64,
    /// Whether a drag moves the picture.
    pub(super) dragging: bool,
    /// Where a rectangle begins that is being drawn, and whether what is in it is selected beside what is.
    rectangle: Option<(Pos2, bool)>,
}

/// Points that two-finger scrolling sends for what a notch of a wheel is.
const POINTS_PER_NOTCH: f32 = 50.0;
/// Rings that are drawn about picked atoms; more of them cost more than they say.
const MOST_RINGS: usize = 2000;
/// A ring is at least so large, points.
const LEAST_RING: f32 = 5.0;
/// The least and the most that its line is wide, points (chosen: seen about wires, no more than a line about large balls).
const RING_WIDTH: (f32, f32) = (1.5, 3.0);

/// Shows the view and turns what the mouse does into actions.
pub(super) fn show(ui: &mut Ui, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Canvas, true, "Molecule"));
    let scale = ui.ctx().pixels_per_point();
    let view = View { rect, scale, state };
    drag(ui, &view, &response, memory, actions);
    memory.dragging = response.dragged() && memory.rectangle.is_none();
    wheel(ui, &view, &response, actions);
    let under = view.under_pointer(&response, memory);
    click(ui, &view, &response, under, actions);
    let painter = ui.painter_at(rect);
    picked_rings(&painter, &view, theme::accent(ui));
    measuring(&painter, &view);
    rectangle(&painter, &response, memory, theme::accent(ui));
    if let (Some(target), false) = (under, response.dragged()) {
        hover(ui, &painter, &view, memory, target);
    }
    if state.measuring {
        hint(&painter, rect, "Measuring: click 2, 3 or 4 atoms. M keeps the number, Esc leaves.");
    }
}

/// From points of the window to the picture and back.
struct View<'a> {
    rect: Rect,
    scale: f32,
    state: &'a State,
}

impl View<'_> {
    fn px(&self, at: Pos2) -> [f32; 2] {
        [(at.x - self.rect.left()) * self.scale, (at.y - self.rect.top()) * self.scale]
    }

    /// A point of the world and how large an ångström is there, in points of the window; `None` behind the camera.
    fn on_screen(&self, point: Vec3) -> Option<(Pos2, f32)> {
        let view = self.state.view();
        let p = view.camera.view_from_world().transform_point3(point);
        let grid = view.pixel_grid();
        let depth = if grid.orthographic { 1.0 } else { -p.z };
        if -p.z <= view.camera.near {
            return None;
        }
        let per_angstrom = 1.0 / (depth * grid.plane_per_px * self.scale);
        let center = Vec2::new(grid.center_px[0], grid.center_px[1]) / self.scale;
        Some((self.rect.min + center + Vec2::new(p.x, -p.y) * per_angstrom, per_angstrom))
    }

    fn under_pointer(&self, response: &Response, memory: &mut Memory) -> Option<Target> {
        let Some(at) = response.hover_pos() else {
            memory.pointer = None;
            return None;
        };
        match memory.pointer {
            Some((old, _, target)) if old == at && memory.version == self.state.version => target,
            old => {
                let hit = self.state.built.picker.pick(&self.state.view(), self.px(at));
                let target = hit.and_then(|hit| picking::target(self.state, hit.id));
                // Small moves over the same thing do not begin the wait for the tip anew.
                let since =
                    old.filter(|(_, _, before)| *before == target).map_or_else(Instant::now, |(_, since, _)| since);
                memory.pointer = Some((at, since, target));
                memory.version = self.state.version;
                target
            }
        }
    }
}

fn drag(ui: &Ui, view: &View<'_>, response: &Response, memory: &mut Memory, actions: &mut Vec<Action>) {
    if let Some((from, adds)) = memory.rectangle {
        if response.drag_stopped() {
            memory.rectangle = None;
            if let Some(to) = response.interact_pointer_pos() {
                let area = Rect::from_two_pos(from, to);
                let keys = selecting::in_rectangle(view.state, [view.px(area.min), view.px(area.max)]);
                let how = if adds { How::Also(keys) } else { How::These(keys) };
                actions.push(Action::Choose(how));
            }
        }
        if !response.dragged() {
            memory.rectangle = None;
        }
        return;
    }
    let buttons = [
        (PointerButton::Primary, Button::Left),
        (PointerButton::Middle, Button::Middle),
        (PointerButton::Secondary, Button::Right),
    ];
    let dragged = buttons.into_iter().find(|(button, _)| response.dragged_by(*button));
    let moved = match dragged {
        Some((_, button)) => Some((button, response.drag_delta())),
        None => flick(ui, response).and_then(|(with, delta)| {
            buttons.into_iter().find(|(button, _)| *button == with).map(|(_, button)| (button, delta))
        }),
    };
    let Some((button, delta)) = moved.map(|(button, delta)| (button, delta * view.scale)) else { return };
    if delta == Vec2::ZERO {
        return;
    }
    let modifiers = ui.input(|input| input.modifiers);
    let what = view.state.preferences.mouse.drag(button, modifiers.shift, modifiers.command);
    let [width, height] = view.state.view_px;
    let shorter = width.min(height) as f32;
    let mut camera: Camera = view.state.work.camera;
    match what {
        Drag::Orbit => {
            navigate::orbit(&mut camera, delta.x, delta.y, shorter, view.state.scene().ground.is_some());
        }
        Drag::Pan => navigate::pan(&mut camera, delta.x, delta.y, height),
        // A drag over half the window is eight notches of the wheel.
        Drag::Zoom => navigate::zoom(&mut camera, delta.y * 16.0 / height as f32, [0.0; 2], height, NEAREST),
        Drag::Roll => navigate::roll(&mut camera, delta.x, shorter),
        // It is over already.
        Drag::Select if dragged.is_none() => return,
        Drag::Select => {
            // With Shift as clicks do: beside what is selected.
            let from = ui.input(|input| input.pointer.press_origin());
            memory.rectangle = from.map(|from| (from, modifiers.shift));
            return;
        }
    }
    actions.push(Action::Camera(camera));
}

/// A button that was pressed and let go between two frames, and how far it was moved meanwhile: egui sees no drag in it.
fn flick(ui: &Ui, response: &Response) -> Option<(PointerButton, Vec2)> {
    if !response.contains_pointer() {
        return None;
    }
    ui.input(|input| {
        let mut start = None;
        for event in &input.events {
            match *event {
                Event::PointerButton { pos, button, pressed: true, .. } if response.rect.contains(pos) => {
                    start = Some((button, pos));
                }
                Event::PointerButton { pos, button, pressed: false, .. } => {
                    let moved = start.take().filter(|(with, _)| *with == button).map(|(_, from)| pos - from);
                    // What is less is a click.
                    if let Some(delta) = moved.filter(|delta| delta.length() > MOST_OF_CLICK) {
                        return Some((button, delta));
                    }
                }
                _ => {}
            }
        }
        None
    })
}

/// Points that the pointer may move in a click: egui's own (`InputOptions::max_click_dist`).
const MOST_OF_CLICK: f32 = 6.0;

/// The rectangle that is being drawn.
fn rectangle(painter: &Painter, response: &Response, memory: &Memory, accent: Color32) {
    let (Some((from, _)), Some(to)) = (memory.rectangle, response.interact_pointer_pos()) else { return };
    let area = Rect::from_two_pos(from, to);
    painter.rect_filled(area, 0.0, accent.gamma_multiply(0.12));
    painter.rect_stroke(area, 0.0, Stroke::new(1.0, accent), egui::StrokeKind::Inside);
}

fn wheel(ui: &Ui, view: &View<'_>, response: &Response, actions: &mut Vec<Action>) {
    let Some(at) = response.hover_pos() else { return };
    let notches = ui.input(|input| {
        let of_event = |event: &Event| match *event {
            Event::MouseWheel { unit: MouseWheelUnit::Point, delta, .. } => delta.y / POINTS_PER_NOTCH,
            Event::MouseWheel { unit: MouseWheelUnit::Line, delta, .. } => delta.y,
            Event::MouseWheel { unit: MouseWheelUnit::Page, delta, .. } => delta.y * 5.0,
            // A factor.
            Event::Zoom(factor) if factor > 0.0 => factor.ln() / navigate::ZOOM_PER_NOTCH.ln(),
            _ => 0.0,
        };
        input.events.iter().map(of_event).sum::<f32>()
    });
    if notches == 0.0 {
        return;
    }
    let [width, height] = view.state.view_px;
    let [x, y] = view.px(at);
    let pointer = [x - width as f32 * 0.5, height as f32 * 0.5 - y];
    let mut camera = view.state.work.camera;
    navigate::zoom(&mut camera, notches, pointer, height, NEAREST);
    actions.push(Action::Camera(camera));
}

fn click(ui: &Ui, view: &View<'_>, response: &Response, under: Option<Target>, actions: &mut Vec<Action>) {
    if response.double_clicked() {
        let hit = response
            .interact_pointer_pos()
            .and_then(|at| view.state.built.picker.pick(&view.state.view(), view.px(at)));
        // The middle of a ball, not the point of its surface.
        let point = match (under, hit) {
            (Some(Target::Atom(key)), _) => picking::ball(view.state, key).map(|(center, _)| center),
            (_, hit) => hit.map(|hit| hit.point),
        };
        if let Some(point) = point {
            actions.push(Action::CenterOn(point));
        }
    } else if response.clicked() {
        let modifiers = ui.input(|input| input.modifiers);
        let Some(adds) = view.state.preferences.mouse.click(modifiers.shift, modifiers.command) else { return };
        match under {
            Some(Target::Atom(key)) if adds => actions.push(Action::PickAlso(key)),
            Some(Target::Atom(key)) => actions.push(Action::Pick(Some(key))),
            Some(Target::Bond(layer, bond)) => {
                let both =
                    picking::drawn(view.state, layer).and_then(|drawn| drawn.structure.bonds().get(bond as usize));
                if let Some(bond) = both {
                    actions.push(Action::Pick(Some(AtomKey { layer, atom: bond.a })));
                    actions.push(Action::PickAlso(AtomKey { layer, atom: bond.b }));
                }
            }
            None if !adds => actions.push(Action::Pick(None)),
            None => {}
        }
    }
}

/// Rings about atoms, as [`crate::scene::Scene::halos`] has them; faint about those that something is in front of.
fn rings(painter: &Painter, view: &View<'_>, keys: impl Iterator<Item = AtomKey>, accent: Color32) {
    let scene = &view.state.built.scene;
    let camera = view.state.view();
    let ids: Vec<u32> = keys.filter_map(|key| picking::id_of(view.state, key)).collect();
    for halo in scene.halos(&ids, camera.camera.forward(), Srgb8::WHITE) {
        let Some((at, per_angstrom)) = view.on_screen(halo.center.into()) else { continue };
        let radius = (halo.ring_radius * per_angstrom).max(LEAST_RING);
        let width = (2.0 * halo.tube_radius * per_angstrom).clamp(RING_WIDTH.0, RING_WIDTH.1);
        // Its own ball, or a stick that ends in it.
        let hit = view.state.built.picker.pick(&camera, view.px(at));
        let is_seen = hit.is_some_and(|hit| hit.point.distance(halo.center.into()) < halo.ring_radius);
        let strength = if is_seen { 1.0 } else { 0.35 };
        // Seen on light and on dark.
        let light = Color32::from_white_alpha(150).gamma_multiply(strength);
        painter.circle_stroke(at, radius, Stroke::new(width + 2.0, light));
        painter.circle_stroke(at, radius, Stroke::new(width, accent.gamma_multiply(strength)));
    }
}

/// Rings about what is picked; of very many atoms about some of them, all over.
fn picked_rings(painter: &Painter, view: &View<'_>, accent: Color32) {
    let picked = &view.state.work.picked;
    let step = picked.len().div_ceil(MOST_RINGS).max(1);
    rings(painter, view, picked.iter().copied().step_by(step), accent);
}

/// The number that the picked atoms would give, before it is kept.
fn measuring(painter: &Painter, view: &View<'_>) {
    let picked = &view.state.work.picked;
    let Some(text) = picking::measure(view.state, picked) else { return };
    let centers = picked.iter().filter_map(|&key| picking::ball(view.state, key).map(|(center, _)| center));
    let points: Vec<Pos2> = centers.filter_map(|center| Some(view.on_screen(center)?.0)).collect();
    if points.len() != picked.len() {
        return;
    }
    painter.extend(egui::Shape::dashed_line(&points, Stroke::new(2.0, theme::MEASURE), 6.0, 4.0));
    let at = match points[..] {
        [a, b] => a.lerp(b, 0.5),
        [a, b, c] => b.lerp(a.lerp(c, 0.5), 0.3),
        [_, b, c, _] => b.lerp(c, 0.5),
        _ => return,
    };
    badge(painter, at, &text, theme::MEASURE);
}

/// A text on a small plate.
fn badge(painter: &Painter, at: Pos2, text: &str, fill: Color32) {
    let galley = painter.layout_no_wrap(text.to_owned(), egui::FontId::proportional(14.0), Color32::WHITE);
    let plate = Rect::from_center_size(at, galley.size() + Vec2::new(12.0, 6.0));
    painter.rect_filled(plate, 5.0, fill);
    painter.galley(plate.center() - galley.size() * 0.5, galley, Color32::WHITE);
}

/// What can be done now, at the top of the view.
fn hint(painter: &Painter, rect: Rect, text: &str) {
    badge(painter, rect.center_top() + Vec2::new(0.0, 22.0), text, Color32::from_rgb(60, 62, 68));
}

/// What the pointer is on, and after a while what that is.
fn hover(ui: &Ui, painter: &Painter, view: &View<'_>, memory: &Memory, target: Target) {
    let Some((at, since, _)) = memory.pointer else { return };
    if view.state.shown.is_before() {
        return; // a tip would lie over it
    }
    if let Target::Atom(key) = target {
        rings(painter, view, std::iter::once(key), theme::accent(ui).gamma_multiply(0.7));
    }
    let waited = since.elapsed().as_secs_f32();
    if waited < tip::DELAY {
        ui.ctx().request_repaint_after_secs(tip::DELAY - waited);
    } else {
        tip::show(ui.ctx(), view.state, target, at, view.rect);
    }
}
