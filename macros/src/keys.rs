//! What stands between the parentheses of both attributes: pairs of key and value, each key once.

use proc_macro2::Span;
use syn::parse::ParseStream;
use syn::punctuated::Punctuated;
use syn::{Error, Ident, Result, Token, bracketed};

/// The keys of an attribute while they are read.
pub trait Keys: Default {
    /// What the attribute stands on: `case`, `rule`.
    const ITEM: &str;
    /// All keys, for the message about an unknown one.
    const KNOWN: &str;

    /// Reads the value of a key and returns whether it had one already; `None` for a key that there is not.
    fn read(&mut self, key: &str, value: ParseStream) -> Result<Option<bool>>;

    /// The value of a key that has to be there; `example` is the key with a value.
    fn required<T>(value: Option<T>, example: &str, whole: Span) -> Result<T> {
        value.ok_or_else(|| Error::new(whole, format!("the {} lacks `{example}`", Self::ITEM)))
    }
}

/// Reads all pairs.
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

/// A list in brackets.
pub fn list(input: ParseStream, item: fn(ParseStream) -> Result<Ident>) -> Result<Vec<Ident>> {
    let content;
    bracketed!(content in input);
    Ok(Punctuated::<Ident, Token![,]>::parse_terminated_with(&content, item)?.into_iter().collect())
}

/// Whether a text can be a part of an id: ids are typed on command lines.
pub fn is_id_part(part: &str) -> bool {
    !part.is_empty() && part.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
}
