//! Kinds of changes, and their consequence in the field.

use std::fmt;

/// The consequence of a change for users of the old description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Everything that worked with the old description works with the new one.
    Harmless,
    /// The device behaves, or a tool shows something, differently; nothing is refused.
    Notable,
    /// A configuration tool, a DCF or another device that relies on the old description fails.
    Breaking,
}

impl Class {
    /// All classes, the most serious first.
    pub const ALL: [Self; 3] = [Self::Breaking, Self::Notable, Self::Harmless];

    /// The name, in text and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Harmless => "harmless",
            Self::Notable => "notable",
            Self::Breaking => "breaking",
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A kind of change.
pub struct ChangeKind {
    /// A stable textual id, such as `entry/data-type`.
    pub id: &'static str,
    /// The consequence of such a change.
    pub class: Class,
    doc: &'static str,
}

impl ChangeKind {
    #[doc(hidden)]
    pub const fn new(id: &'static str, class: Class, doc: &'static str) -> Self {
        Self { id, class, doc }
    }

    /// The title: the change in one line, without full stop.
    pub fn title(&self) -> &'static str {
        self.doc.split("\n\n").next().unwrap_or_default().trim()
    }

    /// The consequence of the change in the field.
    pub fn why(&self) -> String {
        let why = self.doc.split_once("\n\n").map_or("", |(_, why)| why);
        why.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

impl fmt::Debug for ChangeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

/// Kinds with the same id are equal.
impl PartialEq for ChangeKind {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for ChangeKind {}

/// Declares the kinds of a family, and their list: title and reason are the documentation.
macro_rules! kinds {
    ($($(#[doc = $doc:literal])+ $name:ident: $class:ident $id:literal;)+) => {
        $($(#[doc = $doc])+
        pub static $name: $crate::dictionary::difference::ChangeKind = $crate::dictionary::difference::ChangeKind::new(
            $id,
            $crate::dictionary::difference::Class::$class,
            concat!($($doc, "\n"),+),
        );)+

        pub(super) static KINDS: &[&$crate::dictionary::difference::ChangeKind] = &[$(&$name),+];
    };
}

pub(super) use kinds;
