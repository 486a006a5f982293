//! Comparison of the names of sections and fields: ignores case and blanks.

use std::borrow::Cow;

/// The name in lower case and without blanks. Nearly all names of lists have this form already.
pub(in crate::dictionary) fn canonical(name: &str) -> Cow<'_, str> {
    if name.bytes().all(|byte| byte.is_ascii_graphic() && !byte.is_ascii_uppercase()) {
        return Cow::Borrowed(name);
    }
    let letters = name.chars().filter(|character| !character.is_whitespace());
    Cow::Owned(letters.flat_map(char::to_lowercase).collect())
}

/// Whether two names have the same [`canonical`] form. Nearly all names have neither blanks nor non-ASCII letters.
pub(super) fn is_same(one: &str, other: &str) -> bool {
    // Most names differ in their first letter.
    if let ([first, ..], [second, ..]) = (one.as_bytes(), other.as_bytes())
        && first.is_ascii_graphic()
        && second.is_ascii_graphic()
        && !first.eq_ignore_ascii_case(second)
    {
        return false;
    }
    let is_plain = |name: &str| name.bytes().all(|byte| byte.is_ascii_graphic());
    one.eq_ignore_ascii_case(other) || !(is_plain(one) && is_plain(other)) && canonical(one) == canonical(other)
}
