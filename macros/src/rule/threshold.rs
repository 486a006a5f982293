//! The fields of a rule that are thresholds, which the user can set.

use crate::doc;
use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{Attribute, Error, Field, Ident, LitInt, LitStr, Path, Result};

/// The initial value of a field of a rule's state.
pub enum Begin {
    /// The value that the user has set, or the default of the threshold.
    Threshold(Threshold),
    /// The result of this function for the thresholds.
    From(Path),
    /// The default of the field's type.
    Default,
}

/// A threshold: a limit that the user can set.
pub struct Threshold {
    name: String,
    meaning: String,
    default: u64,
    unit: Unit,
    min: u64,
    max: u64,
}

/// The unit of a threshold.
enum Unit {
    Milliseconds,
    Microseconds,
    Percent,
    Count(String),
}

/// Removes the attributes `#[threshold]` and `#[from]` from a field and returns the initial value that they give.
pub fn begin(field: &mut Field) -> Result<Begin> {
    let mut begin = Begin::Default;
    let mut kept = Vec::new();
    for attribute in std::mem::take(&mut field.attrs) {
        if attribute.path().is_ident("threshold") {
            begin = Begin::Threshold(Threshold::read(&attribute)?);
        } else if attribute.path().is_ident("from") {
            begin = Begin::From(attribute.parse_args()?);
        } else {
            kept.push(attribute);
        }
    }
    if let (Begin::Threshold(threshold), Some(name)) = (&mut begin, &field.ident) {
        threshold.meaning = doc::text(&kept);
        if threshold.meaning.is_empty() {
            return Err(Error::new(name.span(), "a threshold says in its doc comment what it means"));
        }
        threshold.name = name.to_string().replace('_', "-");
    }
    field.attrs = kept;
    Ok(begin)
}

impl Threshold {
    fn read(attribute: &Attribute) -> Result<Self> {
        let mut read = Self {
            name: String::new(),
            meaning: String::new(),
            default: 0,
            unit: Unit::Count(String::new()),
            min: 0,
            max: u64::MAX,
        };
        let (mut is_counted, mut unit) = (false, None);
        attribute.parse_nested_meta(|meta| {
            let key = meta.path.require_ident()?.to_string();
            if key == "unit" {
                unit = Some(meta.value()?.parse::<LitStr>()?.value());
                return Ok(());
            }
            let number: u64 = meta.value()?.parse::<LitInt>()?.base10_parse()?;
            match key.as_str() {
                "min" => read.min = number,
                "max" => read.max = number,
                _ => {
                    is_counted = true;
                    read.default = number;
                    read.unit = Unit::of(&key).ok_or_else(|| {
                        meta.error("a threshold is counted in ms, us, percent or count; it may have min, max and unit")
                    })?;
                }
            }
            Ok(())
        })?;
        if !is_counted {
            return Err(Error::new_spanned(attribute, "a threshold has its default: ms, us, percent or count"));
        }
        match (&mut read.unit, unit) {
            (Unit::Count(own), Some(unit)) => *own = unit,
            (_, Some(_)) => return Err(Error::new_spanned(attribute, "only a count has a unit of its own")),
            _ => {}
        }
        Ok(read)
    }

    /// The description of the threshold.
    pub fn metadata(&self) -> TokenStream {
        let Self { name, meaning, default, unit, min, max } = self;
        let unit = unit.value();
        quote! {
            crate::findings::Threshold {
                name: #name, default: #default, unit: #unit, least: #min, most: #max, meaning: #meaning,
            }
        }
    }

    /// The value of the threshold, in the type of its unit; `at` is its position among the thresholds of the rule.
    pub fn value(&self, at: usize) -> TokenStream {
        let method = self.unit.method();
        quote!(thresholds.#method(Self::METADATA, #at))
    }
}

impl Unit {
    fn of(key: &str) -> Option<Self> {
        match key {
            "ms" => Some(Self::Milliseconds),
            "us" => Some(Self::Microseconds),
            "percent" => Some(Self::Percent),
            "count" => Some(Self::Count(String::new())),
            _ => None,
        }
    }

    fn value(&self) -> TokenStream {
        match self {
            Self::Milliseconds => quote!(crate::findings::Unit::Milliseconds),
            Self::Microseconds => quote!(crate::findings::Unit::Microseconds),
            Self::Percent => quote!(crate::findings::Unit::Percent),
            Self::Count(of) => quote!(crate::findings::Unit::Count(#of)),
        }
    }

    fn method(&self) -> Ident {
        format_ident!(
            "{}",
            match self {
                Self::Milliseconds => "milliseconds",
                Self::Microseconds => "microseconds",
                Self::Percent => "percent",
                Self::Count(_) => "count",
            }
        )
    }
}
