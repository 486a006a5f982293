//! The common parts of all HTML pages: each is one self-contained file, light and dark, printable, and usable on a
//! phone.
//!
//! A page loads nothing and runs only its own scripts: the content security policy names our styles and scripts by
//! their hash. Texts from a bus go through maud, which escapes markup, or through [`put_data`].

use crate::escape::{self, Visible};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::io::{self, Write};

const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
const UPLOT_LICENSE: &str = include_str!("../assets/uplot/LICENSE");
/// A magnifying glass as the icon of a page, so that no browser asks a server for an icon.
const ICON: &str = "data:image/svg+xml,%3Csvg xmlns='http:%2F%2Fwww.w3.org/2000/svg' viewBox='0 0 16 16'%3E%3Cg fill='none' \
                    stroke='%232f6fd6' stroke-width='2' stroke-linecap='round'%3E%3Ccircle cx='6.5' cy='6.5' r='4.5'/%3E\
                    %3Cpath d='M10 10l4.5 4.5'/%3E%3C/g%3E%3C/svg%3E";

/// The parts of a page.
pub struct Page<'a> {
    /// The title of the window.
    pub title: &'a str,
    /// Additional styles of this page.
    pub styles: &'a [&'a str],
    /// Additional scripts of this page, run in this order at the end of the body.
    pub scripts: &'a [&'a str],
    /// The markup above the main part.
    pub header: Markup,
    /// Links to the sections: their ids and names.
    pub sections: &'a [(&'a str, &'a str)],
    /// The markup below the main part.
    pub footer: Markup,
}

/// Writes the whole document. `main` writes the main part, piece by piece if it is large, so that memory never holds a
/// page of many megabytes.
///
/// # Errors
/// The errors of `out`.
pub fn write(
    page: &Page<'_>,
    out: &mut dyn Write,
    main: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    // Our own texts contain no characters that act. If such a character appears here, it came from outside and, by
    // mistake, was not escaped.
    let mut out = Visible::new(out, false);
    let styles: Vec<&str> = std::iter::once(STYLE).chain(page.styles.iter().copied()).collect();
    let scripts: Vec<&str> = std::iter::once(SCRIPT).chain(page.scripts.iter().copied()).collect();
    put(
        &mut out,
        html! {
            (DOCTYPE)
            (PreEscaped("<html lang=\"en\">"))
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy(&styles, &scripts));
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="referrer" content="no-referrer";
                link rel="icon" href=(ICON);
                title { (page.title) }
                @for style in &styles { style { (PreEscaped(style)) } }
            }
            (PreEscaped("<body>"))
            a.skip href="#main" { "Skip to the result" }
            header.page { (page.header) (themes()) }
            @if !page.sections.is_empty() {
                nav.sections aria-label="Sections" {
                    @for (id, name) in page.sections { a href={ "#" (id) } { (name) } }
                }
            }
            (PreEscaped("<main id=\"main\" tabindex=\"-1\">"))
        },
    )?;
    main(&mut out)?;
    put(
        &mut out,
        html! {
            (PreEscaped("</main>"))
            footer.page { (page.footer) }
            @for script in &scripts { script { (PreEscaped(script)) } }
            (PreEscaped("</body></html>\n"))
        },
    )?;
    out.flush()
}

/// A name and its value in a list of facts.
pub fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (escape::printable(value)) } } }
}

/// The licence of the library that draws plots.
pub(crate) fn plot_licence() -> Markup {
    html! { details { summary { "Plots are drawn by µPlot, under this licence" } pre { (UPLOT_LICENSE) } } }
}

/// Writes a part of a page.
///
/// # Errors
/// The errors of `out`.
pub fn put(out: &mut dyn Write, part: Markup) -> io::Result<()> {
    out.write_all(part.into_string().as_bytes())
}

/// The switch between light, dark and the system's colours.
fn themes() -> Markup {
    html! {
        fieldset.themes {
            legend.unseen { "Colours" }
            @for (value, name) in [("", "Auto"), ("light", "Light"), ("dark", "Dark")] {
                label { input type="radio" name="theme" value=(value) checked[value.is_empty()]; span { (name) } }
            }
        }
    }
}

/// The content security policy: nothing from outside, and only our own styles and scripts.
fn policy(styles: &[&str], scripts: &[&str]) -> String {
    let hashes = |parts: &[&str]| {
        let hashes = parts.iter().map(|part| format!("'sha256-{}'", BASE64.encode(Sha256::digest(part.as_bytes()))));
        hashes.collect::<Vec<_>>().join(" ")
    };
    format!(
        "default-src 'none'; style-src {}; script-src {}; img-src data:; base-uri 'none'; form-action 'none'; \
         require-trusted-types-for 'script'; trusted-types 'none'",
        hashes(styles),
        hashes(scripts)
    )
}

/// Writes data for the scripts in an element that is not run. No string in the data can end the element.
///
/// # Errors
/// The errors of `out`, or an error if `value` can't be expressed in JSON.
pub fn put_data(out: &mut dyn Write, id: &str, value: &impl Serialize) -> io::Result<()> {
    put(out, html! { (PreEscaped("<script type=\"application/json\" id=\"")) (id) (PreEscaped("\">")) })?;
    let mut json = io::BufWriter::new(NoMarkup(out));
    serde_json::to_writer(escape::JsonText(&mut json), value).map_err(io::Error::other)?;
    json.flush()?;
    drop(json);
    out.write_all(b"</script>")
}

/// Writes JSON within a page. Only strings can contain markup characters, which are escaped.
struct NoMarkup<'a>(&'a mut dyn Write);

impl Write for NoMarkup<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for part in bytes.split_inclusive(|byte| matches!(byte, b'<' | b'>' | b'&')) {
            match part.split_last() {
                Some((&last @ (b'<' | b'>' | b'&'), before)) => {
                    self.0.write_all(before)?;
                    write!(self.0, "\\u{last:04x}")?;
                }
                _ => self.0.write_all(part)?,
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_string_leaves_the_data() {
        let hostile = ["</script><script>alert(1)</script>", "<!--<script>", "]]>", "\u{2028}\u{2029}\u{202e}", "&lt;"];
        let mut element = Vec::new();
        put_data(&mut element, "data", &hostile).unwrap();
        let element = String::from_utf8(element).unwrap();
        let inner = element.strip_prefix("<script type=\"application/json\" id=\"data\">").unwrap();
        let inner = inner.strip_suffix("</script>").unwrap();
        assert!(!inner.contains(['<', '>', '&', '\u{2028}', '\u{2029}', '\u{202e}']), "{inner}");
        assert_eq!(serde_json::from_str::<Vec<String>>(inner).unwrap(), hostile);
    }

    /// With a wrong hash the browser would ignore the page's styles and scripts.
    #[test]
    fn the_policy_names_what_stands_in_the_page() {
        assert!(policy(&["a"], &["b"]).contains("style-src 'sha256-ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs='"));
        for asset in [STYLE, SCRIPT] {
            assert!(!asset.contains("</") && !asset.contains('\r'), "the browser would see something else");
            assert_eq!(escape::document(asset), asset, "a hash would be of something else");
        }
    }
}
