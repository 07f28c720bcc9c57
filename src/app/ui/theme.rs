//! How the interface looks: one typeface, quiet greys, one accent; light and dark.

use crate::app::preferences;
use egui::{Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke, TextStyle, Vec2};
use std::sync::Arc;

/// The accent: what is on, chosen, picked. Chosen for contrast with white and with nearly black.
pub(super) const ACCENT: Color32 = Color32::from_rgb(38, 104, 214);
/// The same before a dark ground.
pub(super) const ACCENT_ON_DARK: Color32 = Color32::from_rgb(98, 156, 255);
/// What is measured, as the marks in the scene.
pub(super) const MEASURE: Color32 = Color32::from_rgb(214, 120, 16);

/// Sets fonts and styles up.
pub(in crate::app) fn set_up(ctx: &Context) {
    let mut fonts = FontDefinitions::default();
    // The font of labels; egui's own stand behind it for what it does not have.
    let inter = FontData::from_static(include_bytes!("../../../data/font/Inter-Medium-subset.otf"));
    fonts.font_data.insert("Inter".to_owned(), Arc::new(inter));
    if let Some(family) = fonts.families.get_mut(&FontFamily::Proportional) {
        family.insert(0, "Inter".to_owned());
    }
    ctx.set_fonts(fonts);
    for theme in [egui::Theme::Light, egui::Theme::Dark] {
        ctx.style_mut_of(theme, |style| adjust(style, theme == egui::Theme::Dark));
    }
    // Ctrl + and − change the size of the interface in other programs; here + and − zoom.
    ctx.options_mut(|options| {
        options.zoom_with_keyboard = false;
        // Where the system does not say what it likes: pictures are white.
        options.fallback_theme = egui::Theme::Light;
    });
}

/// Takes the theme that is wished for.
pub(super) fn follow(ctx: &Context, theme: preferences::Theme) {
    let wanted = match theme {
        preferences::Theme::System => egui::ThemePreference::System,
        preferences::Theme::Light => egui::ThemePreference::Light,
        preferences::Theme::Dark => egui::ThemePreference::Dark,
    };
    if ctx.options(|options| options.theme_preference) != wanted {
        ctx.set_theme(wanted);
    }
}

fn adjust(style: &mut egui::Style, is_dark: bool) {
    for (text, size) in
        [(TextStyle::Small, 11.0), (TextStyle::Body, 13.0), (TextStyle::Button, 13.0), (TextStyle::Heading, 19.0)]
    {
        style.text_styles.insert(text, FontId::proportional(size));
    }
    style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.0));
    let spacing = &mut style.spacing;
    spacing.item_spacing = Vec2::new(6.0, 6.0);
    spacing.button_padding = Vec2::new(8.0, 4.0);
    spacing.interact_size.y = 24.0;
    spacing.slider_width = 150.0;
    spacing.combo_width = 130.0;
    spacing.icon_width = 16.0;
    spacing.icon_width_inner = 9.0;
    style.interaction.tooltip_delay = 0.4;
    style.animation_time = 0.08;
    let visuals = &mut style.visuals;
    let grey = |light: u8, dark: u8| Color32::from_gray(if is_dark { dark } else { light });
    visuals.panel_fill = grey(246, 30);
    visuals.window_fill = grey(252, 36);
    visuals.extreme_bg_color = grey(255, 20);
    visuals.faint_bg_color = grey(240, 38);
    visuals.window_stroke = Stroke::new(1.0, grey(205, 60));
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.menu_corner_radius = CornerRadius::same(6);
    // Soft shadows are many pixels for the CPU and say little.
    visuals.window_shadow = egui::Shadow { offset: [0, 2], blur: 10, spread: 0, color: Color32::from_black_alpha(40) };
    visuals.popup_shadow = egui::Shadow { offset: [0, 2], blur: 6, spread: 0, color: Color32::from_black_alpha(40) };
    visuals.hyperlink_color = if is_dark { ACCENT_ON_DARK } else { ACCENT };
    visuals.selection.bg_fill = if is_dark { Color32::from_rgb(40, 84, 160) } else { Color32::from_rgb(206, 224, 252) };
    visuals.selection.stroke = Stroke::new(1.0, if is_dark { Color32::WHITE } else { Color32::from_rgb(14, 50, 120) });
    visuals.indent_has_left_vline = false;
    visuals.slider_trailing_fill = true;
    let widgets = &mut visuals.widgets;
    let text = grey(34, 222);
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(5);
        widget.fg_stroke.color = text;
        widget.expansion = 0.0;
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, grey(222, 52));
    for (widget, light, dark) in [
        (&mut widgets.inactive, 228, 54),
        (&mut widgets.hovered, 218, 66),
        (&mut widgets.active, 206, 80),
        (&mut widgets.open, 222, 60),
    ] {
        widget.weak_bg_fill = grey(light, dark);
        widget.bg_fill = grey(light - 10, dark + 10);
        widget.bg_stroke = Stroke::NONE;
    }
    widgets.hovered.bg_stroke = Stroke::new(1.0, grey(190, 90));
}

/// What is wrong, in this theme.
pub(super) fn wrong(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(255, 128, 120) } else { Color32::from_rgb(190, 30, 30) }
}

/// The accent of this theme.
pub(super) fn accent(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { ACCENT_ON_DARK } else { ACCENT }
}
