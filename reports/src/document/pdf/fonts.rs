//! The fonts, and the widths of texts in them.

use krilla::text::Font;
use ttf_parser::Face;

/// A font of the document.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Typeface {
    Regular,
    Bold,
    Mono,
}

/// The fonts.
pub(super) struct Fonts {
    fonts: [Loaded; 3],
}

struct Loaded {
    font: Font,
    face: Face<'static>,
}

/// Stands for a character that no font has.
const UNKNOWN: char = '?';

impl Fonts {
    /// Reads the fonts that the program holds.
    pub fn new() -> Option<Self> {
        let [regular, bold, mono] =
            [dejavu::sans_condensed::regular(), dejavu::sans_condensed::bold(), dejavu::sans_mono::regular()]
                .map(Loaded::new);
        Some(Self { fonts: [regular?, bold?, mono?] })
    }

    fn loaded(&self, typeface: Typeface) -> &Loaded {
        let [regular, bold, mono] = &self.fonts;
        match typeface {
            Typeface::Regular => regular,
            Typeface::Bold => bold,
            Typeface::Mono => mono,
        }
    }

    /// The font to draw with.
    pub fn font(&self, typeface: Typeface) -> &Font {
        &self.loaded(typeface).font
    }

    /// The text with a mark for each character that the font lacks: PDF/A allows no missing glyphs.
    pub fn drawable(&self, text: &str, typeface: Typeface) -> String {
        let face = &self.loaded(typeface).face;
        let known = |c: char| if c.is_control() || face.glyph_index(c).is_none() { UNKNOWN } else { c };
        text.chars().map(known).collect()
    }

    /// The width of a text in points.
    pub fn width(&self, text: &str, typeface: Typeface, size: f32) -> f32 {
        let face = &self.loaded(typeface).face;
        let advance = |c: char| {
            let glyph = face.glyph_index(c).or_else(|| face.glyph_index(UNKNOWN));
            glyph.and_then(|glyph| face.glyph_hor_advance(glyph)).map_or(0.0, f32::from)
        };
        text.chars().map(advance).sum::<f32>() * size / f32::from(face.units_per_em())
    }

    /// The text in lines of at most this width. Words that are longer are cut.
    pub fn lines(&self, text: &str, typeface: Typeface, size: f32, width: f32) -> Vec<String> {
        let mut lines = Vec::new();
        for paragraph in text.lines() {
            let mut line = String::new();
            for word in paragraph.split_inclusive(' ') {
                let fits = |line: &str| self.width(line.trim_end(), typeface, size) <= width;
                if fits(&format!("{line}{word}")) {
                    line.push_str(word);
                    continue;
                }
                if !line.trim_end().is_empty() {
                    lines.push(std::mem::take(&mut line).trim_end().to_owned());
                }
                for c in word.chars() {
                    line.push(c);
                    if !fits(&line) && line.chars().count() > 1 {
                        line.pop();
                        lines.push(std::mem::replace(&mut line, c.to_string()).trim_end().to_owned());
                    }
                }
            }
            lines.push(line.trim_end().to_owned());
        }
        if lines.is_empty() {
            lines.push(String::new());
        }
        lines
    }
}

impl Loaded {
    fn new(data: &'static [u8]) -> Option<Self> {
        let font = Font::new(data.to_vec().into(), 0)?;
        Some(Self { font, face: Face::parse(data, 0).ok()? })
    }
}
