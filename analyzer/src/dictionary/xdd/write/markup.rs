//! Elements with their attributes, each in a line of its own.

use quick_xml::escape::escape;

/// The XML text written so far. Attributes without a value are left out.
pub(super) struct Markup {
    text: String,
    open: Vec<&'static str>,
}

pub(super) type Attributes<'a> = &'a [(&'static str, Option<String>)];

impl Markup {
    pub fn new() -> Self {
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(), open: Vec::new() }
    }

    /// Begins an element with nested elements.
    pub fn open(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.start(name, attributes, ">\n");
        self.open.push(name);
    }

    /// Writes an element without content.
    pub fn empty(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.start(name, attributes, "/>\n");
    }

    /// Writes an element with a text, or nothing if there is no text.
    pub(crate) fn leaf(&mut self, name: &'static str, attributes: Attributes<'_>, text: Option<&str>) {
        if let Some(text) = text {
            self.start(name, attributes, ">");
            self.text.push_str(&escape(text));
            self.end(name);
        }
    }

    /// Ends the innermost open element.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.end(name);
        }
    }

    pub(crate) fn into_text(self) -> String {
        self.text
    }

    fn start(&mut self, name: &str, attributes: Attributes<'_>, end: &str) {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        for (attribute, value) in attributes {
            if let Some(value) = value {
                self.text.extend([" ", attribute, "=\"", &escape(value), "\""]);
            }
        }
        self.text.push_str(end);
    }

    fn end(&mut self, name: &str) {
        self.text.extend(["</", name, ">\n"]);
    }

    fn indent(&mut self) {
        self.text.extend(std::iter::repeat_n("  ", self.open.len()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_stand_in_lines_and_texts_do_not_act() {
        let mut markup = Markup::new();
        markup.open("a", &[("x", Some("1<2 & \"3\"".to_owned())), ("y", None)]);
        markup.leaf("b", &[], Some("<c>"));
        markup.leaf("d", &[], None);
        markup.empty("e", &[]);
        markup.close();
        let expected = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<a x=\"1&lt;2 &amp; &quot;3&quot;\">\n  \
                        <b>&lt;c&gt;</b>\n  <e/>\n</a>\n";
        assert_eq!(markup.into_text(), expected);
    }
}
