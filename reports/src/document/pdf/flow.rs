//! The pages while they are filled from top to bottom.

use super::fonts::{Fonts, Typeface};
use crate::document::Tone;
use crate::escape::printable;

/// A4 in points.
pub(super) const WIDTH: f32 = 595.28;
pub(super) const HEIGHT: f32 = 841.89;
/// The margins; head and foot are within them.
pub(super) const MARGIN: f32 = 48.0;
const TOP: f32 = 66.0;
const BOTTOM: f32 = HEIGHT - 54.0;
/// The height of a line as a multiple of the size of its letters.
const LEADING: f32 = 1.35;

/// Something on a page.
#[derive(Clone, Debug)]
pub(super) enum Mark {
    /// A text whose baseline begins here.
    Text { x: f32, y: f32, typeface: Typeface, size: f32, tone: Tone, text: String },
    /// A horizontal line.
    Line { x: f32, y: f32, width: f32 },
    /// A shaded box.
    Box { x: f32, y: f32, width: f32, height: f32 },
}

/// A style of text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    pub typeface: Typeface,
    pub size: f32,
    pub tone: Tone,
}

impl Style {
    pub const fn new(typeface: Typeface, size: f32) -> Self {
        Self { typeface, size, tone: Tone::Plain }
    }

    pub const fn tone(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }

    pub fn line(self) -> f32 {
        self.size * LEADING
    }
}

/// Body text.
pub(super) const BODY: Style = Style::new(Typeface::Regular, 9.0);

/// The pages, and where the next block begins.
pub(super) struct Flow<'f> {
    pub fonts: &'f Fonts,
    pages: Vec<Vec<Mark>>,
    pub y: f32,
    /// The left edge of the blocks.
    pub left: f32,
}

impl<'f> Flow<'f> {
    pub fn new(fonts: &'f Fonts) -> Self {
        Self { fonts, pages: vec![Vec::new()], y: TOP, left: MARGIN }
    }

    pub fn into_pages(self) -> Vec<Vec<Mark>> {
        self.pages
    }

    /// The width of the blocks.
    pub fn width(&self) -> f32 {
        WIDTH - MARGIN - self.left
    }

    pub fn new_page(&mut self) {
        self.pages.push(Vec::new());
        self.y = TOP;
    }

    /// Begins a new page if this height does not fit on the page; returns whether it did.
    pub fn need(&mut self, height: f32) -> bool {
        let is_full = self.y + height > BOTTOM && self.y > TOP;
        if is_full {
            self.new_page();
        }
        is_full
    }

    pub fn space(&mut self, height: f32) {
        self.y += height;
    }

    pub fn mark(&mut self, mark: Mark) {
        // There is always a page.
        if let Some(page) = self.pages.last_mut() {
            page.push(mark);
        }
    }

    /// A line of text with its baseline; `y` is the top of the line.
    pub fn text(&mut self, x: f32, y: f32, style: Style, text: &str) {
        let Style { typeface, size, tone } = style;
        let text = self.fonts.drawable(text, typeface);
        if !text.trim().is_empty() {
            self.mark(Mark::Text { x, y: y + size, typeface, size, tone, text });
        }
    }

    /// A paragraph from margin to margin.
    pub fn paragraph(&mut self, style: Style, text: &str) {
        let lines = self.fonts.lines(&printable(text), style.typeface, style.size, self.width());
        for line in lines {
            self.need(style.line());
            self.text(self.left, self.y, style, &line);
            self.y += style.line();
        }
    }

    /// Fills with blocks whose left edge is further right.
    pub fn indented(&mut self, by: f32, fill: impl FnOnce(&mut Self)) {
        self.left += by;
        fill(self);
        self.left -= by;
    }
}
