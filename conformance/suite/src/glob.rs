//! Patterns over the ids of cases.

/// Whether an id matches a pattern, in which `*` stands for any number of characters.
pub fn matches(pattern: &str, id: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| id.strip_prefix(first)) else { return false };
    let mut parts = parts.peekable();
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns() {
        assert!(matches("*", "a/b") && matches("a*", "a/b") && matches("*b", "a/b") && matches("a*/*b", "a/x/b"));
        assert!(!matches("a*c", "a/b") && !matches("a", "a/b") && !matches("*ab*", "ba"));
        assert!(matches("a/b", "a/b"));
    }
}
