//! What all HTML pages have in common: one file that needs nothing else, light and dark, printable, usable on a phone.
//!
//! A page loads nothing and runs nothing but what stands in it: its content security policy names our styles and
//! scripts by their hash. What comes off a bus goes through maud, which escapes markup, or through [`data`].

use crate::escape;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::io;

const STYLE: &str = include_str!("../assets/page.css");
const SCRIPT: &str = include_str!("../assets/page.js");
/// A magnifying glass, so that no browser asks a server for an icon.
const ICON: &str = "data:image/svg+xml,%3Csvg xmlns='http:%2F%2Fwww.w3.org/2000/svg' viewBox='0 0 16 16'%3E%3Cg fill='none' \
                    stroke='%232f6fd6' stroke-width='2' stroke-linecap='round'%3E%3Ccircle cx='6.5' cy='6.5' r='4.5'/%3E\
                    %3Cpath d='M10 10l4.5 4.5'/%3E%3C/g%3E%3C/svg%3E";

/// The parts of a page.
pub struct Page<'a> {
    /// What the window is called.
    pub title: &'a str,
    /// Styles beside those of all pages.
    pub styles: &'a [&'a str],
    /// Scripts beside those of all pages, run in this order at the end of the body.
    pub scripts: &'a [&'a str],
    /// Above the main part.
    pub header: Markup,
    /// Links to the sections: their ids and names.
    pub sections: &'a [(&'a str, &'a str)],
    /// The main part.
    pub main: Markup,
    /// Below the main part.
    pub footer: Markup,
}

/// The whole document.
pub fn render(page: &Page<'_>) -> Markup {
    let styles: Vec<&str> = std::iter::once(STYLE).chain(page.styles.iter().copied()).collect();
    let scripts: Vec<&str> = std::iter::once(SCRIPT).chain(page.scripts.iter().copied()).collect();
    let document = html! {
        (DOCTYPE)
        html lang="en" {
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
            body {
                a.skip href="#main" { "Skip to the result" }
                header.page { (page.header) (themes()) }
                @if !page.sections.is_empty() {
                    nav.sections aria-label="Sections" {
                        @for (id, name) in page.sections { a href={ "#" (id) } { (name) } }
                    }
                }
                main #main tabindex="-1" { (page.main) }
                footer.page { (page.footer) }
                @for script in &scripts { script { (PreEscaped(script)) } }
            }
        }
    };
    // Nothing of ours holds such characters: what does came from outside, and somebody has forgotten it.
    let document = document.into_string();
    let shown = match escape::document(&document) {
        // A page of megabytes is not copied.
        Cow::Borrowed(_) => None,
        Cow::Owned(shown) => Some(shown),
    };
    PreEscaped(shown.unwrap_or(document))
}

/// The switch between the system's colours, light and dark ones.
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

/// Nothing from outside; of what stands inside only our own styles and scripts.
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

/// Data for the scripts, as an element that nothing runs. Whatever strings it holds, none ends the element.
///
/// # Errors
/// If `value` can't be JSON.
pub fn data(id: &str, value: &impl Serialize) -> io::Result<Markup> {
    let mut json = Vec::new();
    serde_json::to_writer(escape::JsonText(NoMarkup(&mut json)), value).map_err(io::Error::other)?;
    let json = String::from_utf8(json).map_err(io::Error::other)?;
    Ok(html! { script type="application/json" id=(id) { (PreEscaped(json)) } })
}

/// JSON within a page. What could be markup stands in its strings only.
struct NoMarkup<'a>(&'a mut Vec<u8>);

impl io::Write for NoMarkup<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for &byte in bytes {
            match byte {
                b'<' => self.0.extend_from_slice(b"\\u003c"),
                b'>' => self.0.extend_from_slice(b"\\u003e"),
                b'&' => self.0.extend_from_slice(b"\\u0026"),
                _ => self.0.push(byte),
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
        let element = data("data", &hostile).unwrap().into_string();
        let inner = element.strip_prefix("<script type=\"application/json\" id=\"data\">").unwrap();
        let inner = inner.strip_suffix("</script>").unwrap();
        assert!(!inner.contains(['<', '>', '&', '\u{2028}', '\u{2029}', '\u{202e}']), "{inner}");
        assert_eq!(serde_json::from_str::<Vec<String>>(inner).unwrap(), hostile);
    }

    /// A hash that is not of what the browser sees would leave the page without styles and scripts.
    #[test]
    fn the_policy_names_what_stands_in_the_page() {
        assert!(policy(&["a"], &["b"]).contains("style-src 'sha256-ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs='"));
        for asset in [STYLE, SCRIPT] {
            assert!(!asset.contains("</") && !asset.contains('\r'), "the browser would see something else");
            assert_eq!(escape::document(asset), asset, "a hash would be of something else");
        }
    }
}
