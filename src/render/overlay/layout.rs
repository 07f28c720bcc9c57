//! What is written where. All places and lengths are in heights of the full picture, from its upper left corner.
//!
//! A label stands at the projected anchor and is left out where what it stands for is not seen, or where it would cover a
//! nearer label, the legend or the scale bar: text never lies on text.

use super::font::Font;
use crate::color::Srgb8;
use crate::render::{GBuffer, View};
use crate::scene::{Label, LegendRow, Overlay, PixelGrid};
use std::collections::HashMap;

/// Height of capitals at size 1.
const CAPITALS: f64 = 0.02;
/// In em: what is left free at the picture's edges, from row to row of the legend, the discs' radius, and the gap from a
/// disc to its name. All chosen by eye.
const MARGIN: f64 = 1.1;
const ROW: f64 = 1.32;
const DISC: f64 = 0.4;
const GAP: f64 = 0.38;
/// In em: free room around a label.
const ROOM: f64 = 0.14;
/// In em: thickness of the scale bar, height of the marks at its ends, and how far its text is above it.
const BAR: f64 = 0.11;
const MARK: f64 = 0.5;
const LIFT: f64 = 0.42;
/// Rows of the legend at most, names in a row, and characters in a label.
const MOST_ROWS: usize = 12;
const MOST_NAMES: usize = 8;
const MOST_CHARACTERS: usize = 40;
/// Part of the picture's height that a legend may have.
const LEGEND_HEIGHT: f64 = 0.6;
/// Ångström that something may be in front of an atom before it hides its label: a stick of its own that bulges
/// over a ball does not (0.13 Å, the radius of a stick).
const IN_FRONT: f32 = 0.13;

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    pub(super) text: String,
    /// Where it starts, and its base line.
    pub(super) at: [f64; 2],
    /// How long it is.
    pub(super) width: f64,
}

/// A disc of the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    pub(super) center: [f64; 2],
    pub(super) radius: f64,
    pub(super) color: Srgb8,
}

/// Left, upper, right and lower edge.
pub(super) type Rect = [f64; 4];

/// All that is written.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Layout {
    /// Size of the text.
    pub(super) em: f64,
    pub(super) lines: Vec<Line>,
    pub(super) discs: Vec<Disc>,
    /// Filled with ink: the scale bar.
    pub(super) bars: Vec<Rect>,
}

impl Layout {
    /// The layout for a view; `probe` is what is seen of the full picture, without it there are no labels.
    pub(super) fn new(overlay: &Overlay, view: &View, probe: Option<&GBuffer>) -> Layout {
        let Some(font) = Font::get() else { return Layout::default() };
        let size = if overlay.size.is_finite() { f64::from(overlay.size.clamp(0.1, 10.0)) } else { 1.0 };
        let em = CAPITALS * size / font.cap_height();
        let mut layout = Layout { em, ..Layout::default() };
        let mut taken = Taken::new(2.0 * em);
        let aspect = f64::from(view.width) / f64::from(view.height);
        layout.legend(font, &overlay.legend, &mut taken);
        if overlay.scale_bar {
            let angstrom = f64::from(view.camera.angstrom_per_px(view.height)) * f64::from(view.height);
            layout.scale_bar(font, angstrom, aspect, &mut taken);
        }
        if let Some(probe) = probe {
            layout.labels(font, &overlay.labels, view, (probe, aspect), &mut taken);
        }
        layout
    }

    /// Puts down a line whose capitals have their middle at a height.
    fn line(&mut self, font: &Font, text: String, left: f64, middle: f64) -> f64 {
        let width = font.width(&text) * self.em;
        let base = middle + 0.5 * font.cap_height() * self.em;
        self.lines.push(Line { text, at: [left, base], width });
        width
    }

    /// From the lower left corner upwards.
    fn legend(&mut self, font: &Font, rows: &[LegendRow], taken: &mut Taken) {
        let em = self.em;
        let fitting = ((LEGEND_HEIGHT / (ROW * em)) as usize).clamp(2, MOST_ROWS);
        let shown = if rows.len() > fitting { &rows[..fitting - 1] } else { rows };
        let left_out: usize = rows[shown.len()..].iter().map(|row| row.names.len()).sum();
        let count = shown.len() + usize::from(left_out > 0);
        let text_left = (MARGIN + 2.0 * DISC + GAP) * em;
        let mut right = 0.0f64;
        let middle = |row: usize| 1.0 - (MARGIN + DISC + (count - 1 - row) as f64 * ROW) * em;
        for (index, row) in shown.iter().enumerate() {
            let center = [(MARGIN + DISC) * em, middle(index)];
            self.discs.push(Disc { center, radius: DISC * em, color: row.color });
            right = right.max(self.line(font, names(&row.names), text_left, middle(index)));
        }
        if left_out > 0 {
            right = right.max(self.line(font, format!("+ {left_out} more"), text_left, middle(count - 1)));
        }
        if count > 0 {
            taken.take([0.0, middle(0) - 0.5 * ROW * em, text_left + right + ROOM * em, 1.0]);
        }
    }

    /// In the lower right corner; the full picture is `angstrom` high.
    fn scale_bar(&mut self, font: &Font, angstrom: f64, aspect: f64, taken: &mut Taken) {
        let em = self.em;
        let Some(length) = round_length(angstrom * aspect / 6.0) else { return };
        let width = length / angstrom;
        let (right, low) = (aspect - MARGIN * em, 1.0 - MARGIN * em);
        let left = right - width;
        let middle = low - 0.5 * MARK * em;
        let half = 0.5 * BAR * em;
        self.bars.push([left, middle - half, right, middle + half]);
        for x in [left, right - BAR * em] {
            self.bars.push([x, low - MARK * em, x + BAR * em, low]);
        }
        let text = format!("{length} Å");
        let text_width = font.width(&text) * em;
        let text_left = (0.5 * (left + right - text_width)).min(right - text_width);
        let text_middle = middle - (LIFT + 0.5 * font.cap_height()) * em;
        self.line(font, text, text_left, text_middle);
        taken.take([left.min(text_left) - ROOM * em, text_middle - em, aspect, 1.0]);
    }

    fn labels(&mut self, font: &Font, labels: &[Label], view: &View, probe: (&GBuffer, f64), taken: &mut Taken) {
        let mut seen: Vec<(f32, usize, [f64; 2])> = (labels.iter().enumerate())
            .filter(|(_, label)| !label.text.is_empty())
            .filter_map(|(index, label)| place(label, view, probe).map(|(depth, at)| (depth, index, at)))
            .collect();
        // Nearest first; a tie goes to the first of the list.
        seen.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index, [x, y]) in seen {
            let text = line_of(&labels[index].text);
            let (width, height) = (font.width(&text) * self.em, font.cap_height() * self.em);
            let (dx, dy) = (0.5 * width + ROOM * self.em, 0.5 * height + ROOM * self.em);
            if taken.take([x - dx, y - dy, x + dx, y + dy]) {
                self.line(font, text, x - 0.5 * width, y);
            }
        }
    }
}

/// The roundest length (1, 2 or 5 times a power of ten) near one; `None` where that has no meaning.
pub(super) fn round_length(near: f64) -> Option<f64> {
    if !(near.is_finite() && near > 1e-9 && near < 1e12) {
        return None;
    }
    let power = near.log10().floor() as i32;
    let candidates = [1.0, 2.0, 5.0, 10.0]
        .map(|digit| if power < 0 { digit / 10f64.powi(-power) } else { digit * 10f64.powi(power) });
    let off = |length: f64| (length / near).ln().abs();
    candidates.into_iter().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// The names of a row, the first of them.
fn names(all: &[String]) -> String {
    let shown: Vec<String> = all.iter().take(MOST_NAMES).map(|name| line_of(name)).collect();
    let text = shown.join(", ");
    let left_out = all.len() - shown.len();
    if left_out > 0 { format!("{text} + {left_out} more") } else { text }
}

/// A text as one line: no control characters, not too long.
fn line_of(text: &str) -> String {
    let mut line: String = text.chars().filter(|c| !c.is_control()).take(MOST_CHARACTERS + 1).collect();
    if line.chars().count() > MOST_CHARACTERS {
        line.pop();
        line.push('…');
    }
    line
}

/// Depth and place of a label whose object is seen.
fn place(label: &Label, view: &View, (probe, aspect): (&GBuffer, f64)) -> Option<(f32, [f64; 2])> {
    let p = view.camera.view_from_world().transform_point3(label.anchor);
    let depth = -p.z;
    // Written so that NaN is left out.
    if !(depth > view.camera.near && p.is_finite()) {
        return None;
    }
    let grid = view.pixel_grid();
    let scale = if grid.orthographic { 1.0 } else { 1.0 / f64::from(depth) };
    let plane = [f64::from(p.x) * scale, f64::from(p.y) * scale];
    let height = f64::from(grid.plane_per_px) * f64::from(view.height);
    let at = [0.5 * aspect + plane[0] / height, 0.5 - plane[1] / height];
    let pixel = pixel_of(plane, &view.camera.pixel_grid(probe.width, probe.height), probe)?;
    let id = *probe.id.get(pixel)?;
    let is_own = (label.ids[0]..=label.ids[1]).contains(&id);
    let front = depth - label.radius - IN_FRONT;
    (is_own || *probe.depth.get(pixel)? >= front).then_some((depth, at))
}

/// The pixel of a G-buffer at plane coordinates; `None` outside.
fn pixel_of([u, v]: [f64; 2], grid: &PixelGrid, probe: &GBuffer) -> Option<usize> {
    let step = f64::from(grid.plane_per_px);
    let (x, y) = ((f64::from(grid.center_px[0]) + u / step).floor(), (f64::from(grid.center_px[1]) - v / step).floor());
    let inside = x >= 0.0 && y >= 0.0 && x < f64::from(probe.width) && y < f64::from(probe.height);
    inside.then(|| y as usize * probe.width as usize + x as usize)
}

/// Which parts of the picture have text.
struct Taken {
    cell: f64,
    cells: HashMap<(i32, i32), Vec<Rect>>,
}

impl Taken {
    fn new(cell: f64) -> Taken {
        Taken { cell, cells: HashMap::new() }
    }

    /// Takes a place if all of it is free.
    fn take(&mut self, rect: Rect) -> bool {
        let index = |x: f64| (x / self.cell).floor() as i32;
        let [left, top, right, bottom] = rect.map(index);
        let all = || (top..=bottom).flat_map(move |y| (left..=right).map(move |x| (x, y)));
        let overlaps =
            |other: &Rect| rect[0] < other[2] && other[0] < rect[2] && rect[1] < other[3] && other[1] < rect[3];
        if all().any(|cell| self.cells.get(&cell).is_some_and(|rects| rects.iter().any(overlaps))) {
            return false;
        }
        for cell in all() {
            self.cells.entry(cell).or_default().push(rect);
        }
        true
    }
}
