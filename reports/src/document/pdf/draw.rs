//! Draws the pages.

use super::flow::{HEIGHT, MARGIN, Mark, WIDTH};
use super::fonts::{Fonts, Typeface};
use crate::document::{Document, Tone};
use crate::escape::printable;

use krilla::SerializeSettings;
use krilla::color::rgb;
use krilla::configure::{Archival, ConfigurationBuilder};
use krilla::geom::{PathBuilder, Point, Rect};
use krilla::metadata::{DateTime, Metadata};
use krilla::page::PageSettings;
use krilla::paint::Fill;
use krilla::surface::Surface;
use krilla::text::TextDirection;
use std::fmt::Debug;
use std::io;

/// The version of canvass.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The size of head and foot.
const SIZE: f32 = 7.5;
/// The thickness of lines.
const HAIR: f32 = 0.4;

pub(super) fn draw(pages: &[Vec<Mark>], fonts: &Fonts, document: &Document) -> io::Result<Vec<u8>> {
    // PDF/A asks for a date. A result without one is a PDF of the same look.
    let builder = ConfigurationBuilder::new();
    let builder = match date(&document.date) {
        Some(_) => builder.with_archival_validator(Archival::A2_B),
        None => builder,
    };
    let configuration = builder.finish().map_err(|error| failed(&error))?;
    let mut pdf = krilla::Document::new_with(SerializeSettings { configuration, ..SerializeSettings::default() });
    pdf.set_metadata(metadata(document));
    let settings = PageSettings::from_wh(WIDTH, HEIGHT).ok_or_else(|| io::Error::other("a page of no size"))?;
    for (number, marks) in (1..).zip(pages) {
        let mut page = pdf.start_page_with(settings.clone());
        let mut surface = page.surface();
        frame(&mut surface, fonts, document, number, pages.len());
        marks.iter().for_each(|mark| put(&mut surface, fonts, mark));
        surface.finish();
        page.finish();
    }
    pdf.finish().map_err(|error| failed(&error))
}

fn failed(error: &dyn Debug) -> io::Error {
    io::Error::other(format!("the document can't be written as PDF/A: {error:?}"))
}

fn metadata(document: &Document) -> Metadata {
    let metadata = Metadata::new()
        .title(printable(&document.title).to_string())
        .creator(format!("canvass {VERSION}"))
        .language("en".to_owned());
    match date(&document.date) {
        Some(date) => metadata.creation_date(date),
        None => metadata,
    }
}

/// A date in the notation of RFC 3339; without it the document has none, so that its bytes stay the same.
fn date(text: &str) -> Option<DateTime> {
    let time: jiff::Timestamp = text.parse().ok()?;
    let time = time.to_zoned(jiff::tz::TimeZone::UTC);
    let small = |number: i8| u8::try_from(number).unwrap_or(0);
    let date = DateTime::new(u16::try_from(time.year()).ok()?).month(small(time.month())).day(small(time.day()));
    let date = date.hour(small(time.hour())).minute(small(time.minute())).second(small(time.second()));
    Some(date.utc_offset_hour(0).utc_offset_minute(0))
}

/// The head and the foot of a page.
fn frame(surface: &mut Surface<'_>, fonts: &Fonts, document: &Document, number: usize, of: usize) {
    let head = if document.head.is_empty() { &document.title } else { &document.head };
    let head = fonts.lines(&printable(head), Typeface::Regular, SIZE, WIDTH - 2.0 * MARGIN - 60.0).swap_remove(0);
    let page = format!("{number} / {of}");
    let right = WIDTH - MARGIN - fonts.width(&page, Typeface::Regular, SIZE);
    let (tone, typeface, size) = (Tone::Faint, Typeface::Regular, SIZE);
    let mut text = |x, y, text: &str| {
        let text = fonts.drawable(text, typeface);
        put(surface, fonts, &Mark::Text { x, y, typeface, size, tone, text });
    };
    text(MARGIN, 42.0, &head);
    text(right, 42.0, &page);
    text(MARGIN, HEIGHT - 30.0, &format!("canvass {VERSION}"));
    put(surface, fonts, &Mark::Line { x: MARGIN, y: 48.0, width: WIDTH - 2.0 * MARGIN });
}

fn put(surface: &mut Surface<'_>, fonts: &Fonts, mark: &Mark) {
    match mark {
        Mark::Text { x, y, typeface, size, tone, text } => {
            surface.set_fill(Some(filled(color(*tone))));
            let font = fonts.font(*typeface).clone();
            surface.draw_text(Point::from_xy(*x, *y), font, *size, text, false, TextDirection::LeftToRight);
        }
        Mark::Line { x, y, width } => fill(surface, rgb::Color::new(200, 205, 212), *x, *y, *width, HAIR),
        Mark::Box { x, y, width, height } => fill(surface, rgb::Color::new(238, 241, 245), *x, *y, *width, *height),
    }
}

fn fill(surface: &mut Surface<'_>, color: rgb::Color, x: f32, y: f32, width: f32, height: f32) {
    let mut path = PathBuilder::new();
    if let Some(rect) = Rect::from_xywh(x, y, width, height) {
        path.push_rect(rect);
    }
    if let Some(path) = path.finish() {
        surface.set_fill(Some(filled(color)));
        surface.draw_path(&path);
    }
}

fn filled(color: rgb::Color) -> Fill {
    Fill { paint: color.into(), ..Fill::default() }
}

fn color(tone: Tone) -> rgb::Color {
    match tone {
        Tone::Plain => rgb::Color::new(24, 28, 34),
        Tone::Good => rgb::Color::new(21, 110, 60),
        Tone::Doubt => rgb::Color::new(146, 84, 0),
        Tone::Bad => rgb::Color::new(176, 28, 28),
        Tone::Info => rgb::Color::new(16, 94, 150),
        Tone::Odd => rgb::Color::new(110, 60, 150),
        Tone::Faint => rgb::Color::new(104, 112, 122),
    }
}
