//! The syntax that both attributes share: pairs of key and value, each key at most once.

use proc_macro2::Span;
use syn::parse::ParseStream;
use syn::punctuated::Punctuated;
use syn::{Error, Ident, Result, Token, bracketed};

/// The keys of an attribute while they are read.
pub trait Keys: Default {
    /// The item that the attribute describes: `case` or `rule`.
    const ITEM: &str;
    /// All keys, for the message about an unknown key.
    const KNOWN: &str;

    /// Reads the value of a key and returns whether the key had a value already; `None` if the key is unknown.
    fn read(&mut self, key: &str, value: ParseStream) -> Result<Option<bool>>;

    /// The value of a required key; `example` is the key with a value, for the error message.
    fn required<T>(value: Option<T>, example: &str, whole: Span) -> Result<T> {
        value.ok_or_else(|| Error::new(whole, format!("the {} lacks `{example}`", Self::ITEM)))
    }
}

/// Reads all pairs of an attribute.
pub fn read<K: Keys>(input: ParseStream) -> Result<K> {
    let mut keys = K::default();
    while !input.is_empty() {
        let key: Ident = input.parse()?;
        input.parse::<Token![=]>()?;
        let problem = match keys.read(&key.to_string(), input)? {
            Some(false) => None,
            Some(true) => Some(format!("`{key}` is given twice")),
            None => Some(format!("no key of a {} is called `{key}`: there are {}", K::ITEM, K::KNOWN)),
        };
        if let Some(problem) = problem {
            return Err(Error::new(key.span(), problem));
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(keys)
}

/// Reads a list in brackets.
pub fn list(input: ParseStream, item: fn(ParseStream) -> Result<Ident>) -> Result<Vec<Ident>> {
    let content;
    bracketed!(content in input);
    Ok(Punctuated::<Ident, Token![,]>::parse_terminated_with(&content, item)?.into_iter().collect())
}

/// Whether a text can be a part of an id. Ids are typed on command lines, so only lower-case letters, digits and
/// hyphens are allowed.
pub fn is_id_part(part: &str) -> bool {
    !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
}
