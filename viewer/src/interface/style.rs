//! How the interface looks: two themes that go with the pictures'.

use egui::{Color32, Context, CornerRadius, FontId, Frame, Margin, RichText, Stroke, TextStyle, Ui, Visuals};

use crate::palette::{Rgb, Theme};

/// Height of one row of a list, in points.
pub const ROW: f32 = 20.0;

/// The colours of a theme.
#[derive(Clone, Copy, Debug)]
pub struct Tones {
    /// Of panels.
    pub panel: Color32,
    /// Of fields in panels.
    pub field: Color32,
    /// Between panels.
    pub line: Color32,
    /// Of what is read.
    pub text: Color32,
    /// Of what stands beside it.
    pub faint: Color32,
    /// Of what is chosen.
    pub accent: Color32,
    /// Of text on the accent.
    pub on_accent: Color32,
    /// All is well.
    pub good: Color32,
    /// Look here.
    pub warn: Color32,
    /// Something is wrong.
    pub bad: Color32,
}

const fn hex(rgb: u32) -> Color32 {
    Color32::from_rgb((rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8)
}

/// A colour of the pictures.
pub fn of(colour: Rgb) -> Color32 {
    hex(colour.0)
}

/// The colours of a theme.
pub fn tones(theme: Theme) -> Tones {
    match theme {
        Theme::Dark => Tones {
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
        Theme::Light => Tones {
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

/// Makes all that is drawn from now on look so.
pub fn apply(context: &Context, theme: Theme) {
    let tones = tones(theme);
    let egui_theme = if theme == Theme::Dark { egui::Theme::Dark } else { egui::Theme::Light };
    context.set_theme(egui_theme);
    context.style_mut_of(egui_theme, |style| {
        style.visuals = visuals(theme, &tones);
        style.spacing.item_spacing = egui::vec2(8.0, 6.0);
        style.spacing.button_padding = egui::vec2(8.0, 3.0);
        style.spacing.slider_width = 130.0;
        style.interaction.selectable_labels = false;
        for (kind, size) in
            [(TextStyle::Body, 13.0), (TextStyle::Button, 13.0), (TextStyle::Small, 11.0), (TextStyle::Heading, 15.0)]
        {
            style.text_styles.insert(kind, FontId::proportional(size));
        }
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.0));
    });
}

fn visuals(theme: Theme, tones: &Tones) -> Visuals {
    let mut visuals = if theme == Theme::Dark { Visuals::dark() } else { Visuals::light() };
    let round = CornerRadius::same(5);
    visuals.panel_fill = tones.panel;
    visuals.window_fill = tones.panel;
    visuals.window_stroke = Stroke::new(1.0, tones.line);
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.extreme_bg_color = tones.field;
    visuals.faint_bg_color = tones.field;
    visuals.hyperlink_color = tones.accent;
    visuals.selection.bg_fill = tones.accent;
    visuals.selection.stroke = Stroke::new(1.0, tones.on_accent);
    visuals.slider_trailing_fill = true;
    visuals.warn_fg_color = tones.warn;
    visuals.error_fg_color = tones.bad;
    let widgets = &mut visuals.widgets;
    for (look, fill, text) in [
        (&mut widgets.noninteractive, tones.panel, tones.text),
        (&mut widgets.inactive, tones.field, tones.text),
        (&mut widgets.hovered, tones.line, tones.text),
        (&mut widgets.active, tones.line, tones.text),
        (&mut widgets.open, tones.line, tones.text),
    ] {
        (look.bg_fill, look.weak_bg_fill) = (fill, fill);
        look.fg_stroke = Stroke::new(1.0, text);
        look.bg_stroke = Stroke::new(1.0, tones.line);
        look.corner_radius = round;
        look.expansion = 0.0;
    }
    widgets.hovered.bg_stroke = Stroke::new(1.0, tones.accent);
    visuals
}

/// The frame of a panel.
pub fn panel(theme: Theme) -> Frame {
    Frame::new().fill(tones(theme).panel).inner_margin(Margin::symmetric(12, 8))
}

/// The frame of something that floats over the picture.
pub fn floating(theme: Theme) -> Frame {
    let tones = tones(theme);
    Frame::new()
        .fill(tones.panel.gamma_multiply(0.88))
        .stroke(Stroke::new(1.0, tones.line))
        .corner_radius(CornerRadius::same(6))
        .inner_margin(Margin::symmetric(10, 7))
}

/// Text that stands beside what counts.
pub fn faint(ui: &Ui, theme: Theme, text: impl Into<String>) -> RichText {
    let size = ui.style().text_styles.get(&TextStyle::Body).map_or(13.0, |font| font.size - 1.0);
    RichText::new(text).size(size).color(tones(theme).faint)
}

/// A line of a table: what, and how much, in figures of equal width.
pub fn line(ui: &mut Ui, theme: Theme, what: &str, value: impl Into<String>) {
    ui.horizontal(|ui| {
        ui.label(faint(ui, theme, what));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.label(RichText::new(value).monospace());
        });
    });
}

/// A heading within a panel.
pub fn heading(ui: &mut Ui, theme: Theme, text: &str) {
    ui.add_space(6.0);
    ui.label(RichText::new(text.to_uppercase()).size(10.5).color(tones(theme).faint).strong());
}

/// A number with a thin space at each thousand.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}
