//! The style of the interface: two themes that match those of the picture.

use std::sync::Arc;

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Color32, ComboBox, Context, CornerRadius, FontId, Frame, Galley, Layout, Margin,
    Response, RichText, Role, Sense, Stroke, TextStyle, Ui, Visuals, WidgetInfo, vec2,
};
use regatta_plugin::activity::Activity;
use regatta_scene::palette::{Rgb, Theme};

use crate::text::NO_BREAK_SPACE;

/// The height of one row of a list, in points.
pub const ROW: f32 = 20.0;

/// The space between the contents of a panel and its upper and lower end, in points.
pub const PANEL_MARGIN: f32 = 8.0;

/// The colours of a theme.
#[derive(Clone, Copy, Debug)]
pub struct ThemeColours {
    /// The background of panels.
    pub panel: Color32,
    /// The background of input fields and buttons.
    pub field: Color32,
    /// Borders and separators.
    pub line: Color32,
    /// Text.
    pub text: Color32,
    /// Secondary text.
    pub faint: Color32,
    /// Selected elements.
    pub accent: Color32,
    /// Text on the accent colour.
    pub on_accent: Color32,
    /// A normal state.
    pub good: Color32,
    /// A warning.
    pub warn: Color32,
    /// An error.
    pub bad: Color32,
}

const fn hex(rgb: u32) -> Color32 {
    Color32::from_rgb((rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8)
}

/// Converts a colour of the picture.
pub fn color32(colour: Rgb) -> Color32 {
    hex(colour.0)
}

/// Returns the colour of a robot's activity: that of the picture.
pub fn activity_colour(activity: Activity, theme: Theme) -> Color32 {
    color32(theme.activity_colour(activity))
}

/// Returns the colours of a theme.
pub fn colours(theme: Theme) -> ThemeColours {
    match theme {
        Theme::Dark => ThemeColours {
            panel: hex(0x10151b),
            field: hex(0x1b232c),
            line: hex(0x242e38),
            text: hex(0xd9e1e8),
            faint: hex(0x8593a0),
            accent: hex(0x56b4e9),
            on_accent: hex(0x08131c),
            good: hex(0x2fbf8f),
            warn: hex(0xe6b422),
            bad: hex(0xf0743e),
        },
        Theme::Light => ThemeColours {
            panel: hex(0xffffff),
            field: hex(0xeef2f5),
            line: hex(0xd8dfe5),
            text: hex(0x1b2530),
            faint: hex(0x5d6b78),
            accent: hex(0x0072b2),
            on_accent: hex(0xffffff),
            good: hex(0x00805c),
            warn: hex(0x9a6a00),
            bad: hex(0xc24a00),
        },
    }
}

/// Applies a theme to everything that the context draws from now on.
pub fn apply(context: &Context, theme: Theme) {
    let colours = colours(theme);
    let egui_theme = if theme == Theme::Dark { egui::Theme::Dark } else { egui::Theme::Light };
    context.set_theme(egui_theme);
    context.style_mut_of(egui_theme, |style| {
        style.visuals = visuals(theme, &colours);
        style.spacing.item_spacing = vec2(8.0, 6.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.slider_width = 130.0;
        // The bar lies beside what is scrolled, not over the ends of its lines.
        style.spacing.scroll.floating_allocated_width = 8.0;
        // Lists of states and of kinds are shown whole where the window is high enough.
        style.spacing.combo_height = 400.0;
        style.interaction.selectable_labels = false;
        for (kind, size) in [
            (TextStyle::Body, 13.0),
            (TextStyle::Button, 13.0),
            (TextStyle::Small, 11.0),
            (TextStyle::Heading, 15.0),
        ] {
            style.text_styles.insert(kind, FontId::proportional(size));
        }
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.0));
    });
}

fn visuals(theme: Theme, colours: &ThemeColours) -> Visuals {
    let mut visuals = if theme == Theme::Dark { Visuals::dark() } else { Visuals::light() };
    let round = CornerRadius::same(5);
    visuals.panel_fill = colours.panel;
    visuals.window_fill = colours.panel;
    visuals.window_stroke = Stroke::new(1.0, colours.line);
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.extreme_bg_color = colours.field;
    visuals.faint_bg_color = colours.field;
    visuals.hyperlink_color = colours.accent;
    visuals.selection.bg_fill = colours.accent;
    visuals.selection.stroke = Stroke::new(1.0, colours.on_accent);
    visuals.slider_trailing_fill = true;
    visuals.warn_fg_color = colours.warn;
    visuals.error_fg_color = colours.bad;
    let widgets = &mut visuals.widgets;
    for (widget, fill, text) in [
        (&mut widgets.noninteractive, colours.panel, colours.text),
        (&mut widgets.inactive, colours.field, colours.text),
        (&mut widgets.hovered, colours.line, colours.text),
        (&mut widgets.active, colours.line, colours.text),
        (&mut widgets.open, colours.line, colours.text),
    ] {
        (widget.bg_fill, widget.weak_bg_fill) = (fill, fill);
        widget.fg_stroke = Stroke::new(1.0, text);
        widget.bg_stroke = Stroke::new(1.0, colours.line);
        widget.corner_radius = round;
        widget.expansion = 0.0;
    }
    widgets.hovered.bg_stroke = Stroke::new(1.0, colours.accent);
    visuals
}

/// Returns the frame of a panel.
pub fn panel(theme: Theme) -> Frame {
    Frame::new().fill(colours(theme).panel).inner_margin(Margin::symmetric(12, PANEL_MARGIN as i8))
}

/// Returns the frame of an element that floats over the picture.
pub fn floating(theme: Theme) -> Frame {
    let colours = colours(theme);
    Frame::new()
        // Opaque: ids of nodes would shine through.
        .fill(colours.panel)
        .stroke(Stroke::new(1.0, colours.line))
        .corner_radius(CornerRadius::same(6))
        .inner_margin(Margin::symmetric(10, 7))
}

/// Returns the colours of the theme of a context.
pub fn colours_of(ctx: &Context) -> ThemeColours {
    colours(match ctx.theme() {
        egui::Theme::Dark => Theme::Dark,
        egui::Theme::Light => Theme::Light,
    })
}

/// Shows a row that is filled from its right end.
pub fn row_from_right(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), add);
}

/// Shows the button that copies a list to the clipboard.
pub fn copy_button(ui: &mut Ui, what: &str) -> Response {
    let response = ui.button("copy").on_hover_text(format!("Copy {what}"));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("copy {what}")));
    response
}

/// Returns secondary text, in which no line ends between a number and the next word.
pub fn faint(ui: &Ui, text: impl Into<String>) -> RichText {
    let size = ui.style().text_styles.get(&TextStyle::Body).map_or(13.0, |font| font.size - 1.0);
    RichText::new(unbroken(&text.into())).size(size).color(colours_of(ui.ctx()).faint)
}

/// Returns a text in which no line ends between a number and its unit.
pub fn unbroken(text: &str) -> String {
    let mut after_digit = false;
    let mut unbroken = String::with_capacity(text.len());
    for letter in text.chars() {
        unbroken.push(if letter == ' ' && after_digit { NO_BREAK_SPACE } else { letter });
        after_digit = letter.is_ascii_digit();
    }
    unbroken
}

/// Shows a line of a table: a name on the left and a value in a monospaced font on the right.
pub fn line(ui: &mut Ui, name: &str, value: impl Into<String>) {
    ui.horizontal(|ui| {
        ui.label(faint(ui, name));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.label(RichText::new(value).monospace());
        });
    });
}

/// Shows a heading within a panel.
pub fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    let faint = colours_of(ui.ctx()).faint;
    ui.label(RichText::new(text.to_uppercase()).size(10.5).color(faint).strong());
}

/// Shows a choice by a combo box; `name` is its accessible name.
pub fn choice(ui: &mut Ui, name: &str, choice: ComboBox, contents: impl FnOnce(&mut Ui)) {
    let shown = choice.show_ui(ui, contents);
    shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, name));
}

/// Shows a coloured dot and a text, which is truncated if there is no room for it.
pub fn status_dot(ui: &mut Ui, colour: Color32, text: RichText) -> egui::Response {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
        ui.painter().circle_filled(rect.center(), 4.0, colour);
        ui.add(egui::Label::new(text).truncate())
    })
    .inner
}

/// Lays out a text in a line of some width, with an ellipsis if it is longer.
pub fn one_line(ui: &Ui, text: &str, width: f32, font: FontId, colour: Color32) -> Arc<Galley> {
    let mut job = LayoutJob::simple_singleline(text.to_owned(), font, colour);
    job.wrap = TextWrapping::truncate_at_width(width.max(0.0));
    ui.painter().layout_job(job)
}
