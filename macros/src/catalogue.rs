//! The expansion of `#[derive(Catalogue)]`.

use crate::doc;
use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::Parse;
use syn::punctuated::Punctuated;
use syn::{Attribute, Data, DeriveInput, Error, Expr, Ident, Result, Token, Variant};

/// A field of a row with a value other than in `Row::USUAL`: `model = "reference-406"`.
struct Pair {
    field: Ident,
    value: Expr,
}

impl Parse for Pair {
    fn parse(input: syn::parse::ParseStream) -> Result<Self> {
        let field = input.parse()?;
        input.parse::<Token![=]>()?;
        Ok(Self { field, value: input.parse()? })
    }
}

/// Expands to the list of the variants, the name and the text of each, and their rows if any variant has `#[row(…)]`.
pub fn catalogue(item: TokenStream) -> Result<TokenStream> {
    let DeriveInput { ident, data, .. } = syn::parse2(item)?;
    let Data::Enum(data) = data else {
        return Err(Error::new(ident.span(), "a catalogue is an enum: each variant is an entry"));
    };
    let variants: Vec<&Ident> = data.variants.iter().map(|variant| &variant.ident).collect();
    let ids = variants.iter().map(|variant| kebab_case(&variant.to_string()));
    let summaries = data.variants.iter().map(summary).collect::<Result<Vec<_>>>()?;
    let rows = data.variants.iter().map(|variant| row(&variant.attrs)).collect::<Result<Vec<_>>>()?;
    let row = rows.iter().any(|row| !row.is_empty()).then(|| {
        quote! {
            /// The properties of an entry besides its name and its summary.
            const fn row(self) -> &'static Row {
                const ROWS: &[Row] = &[#(Row { #(#rows,)* ..Row::USUAL }),*];
                &ROWS[self as usize]
            }
        }
    });
    Ok(quote! {
        #[allow(clippy::needless_update)]
        impl #ident {
            /// All entries, in the order of their definition.
            pub const ALL: &'static [Self] = &[#(Self::#variants),*];

            /// The name of the entry on the command line.
            pub const fn id(self) -> &'static str {
                const IDS: &[&str] = &[#(#ids),*];
                IDS[self as usize]
            }

            /// The description of the entry in one sentence.
            pub const fn summary(self) -> &'static str {
                const SUMMARIES: &[&str] = &[#(#summaries),*];
                SUMMARIES[self as usize]
            }

            #row
        }
    })
}

fn summary(variant: &Variant) -> Result<String> {
    match doc::text(&variant.attrs) {
        text if text.is_empty() => {
            Err(Error::new(variant.ident.span(), "an entry of a catalogue says in its doc comment what it is"))
        }
        text => Ok(text),
    }
}

/// The fields in `#[row(…)]`.
fn row(attributes: &[Attribute]) -> Result<Vec<TokenStream>> {
    let Some(row) = attributes.iter().find(|attribute| attribute.path().is_ident("row")) else { return Ok(Vec::new()) };
    let pairs = row.parse_args_with(Punctuated::<Pair, Token![,]>::parse_terminated)?;
    Ok(pairs.iter().map(|Pair { field, value }| quote!(#field: #value)).collect())
}

/// The name of a variant on the command line: `AnswersIn900Ms` is `answers-in-900-ms`.
fn kebab_case(name: &str) -> String {
    let mut id = String::new();
    let mut before = None;
    for c in name.chars() {
        let begins_number = c.is_ascii_digit() && before.is_some_and(|before: char| !before.is_ascii_digit());
        if before.is_some() && (c.is_ascii_uppercase() || begins_number) {
            id.push('-');
        }
        id.push(c.to_ascii_lowercase());
        before = Some(c);
    }
    id
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(item: &str) -> std::result::Result<String, String> {
        catalogue(item.parse().unwrap()).map(|tokens| tokens.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn names_are_typed_on_command_lines() {
        assert_eq!(kebab_case("BootUpMissing"), "boot-up-missing");
        assert_eq!(kebab_case("AnswersIn900Ms"), "answers-in-900-ms");
        assert_eq!(kebab_case("EdsLatin1"), "eds-latin-1");
    }

    #[test]
    fn an_entry_has_its_name_its_text_and_its_row() {
        let item = "enum Fault {
            /// No boot-up message
            /// after a reset.
            BootUpMissing,
            /// 6300h stays 0.
            #[row(model = \"reference-406\", fuzz = Never(Measured))]
            CamStuck,
        }";
        let tokens = expanded(item).unwrap();
        for part in [
            "[Self :: BootUpMissing , Self :: CamStuck]",
            r#"["boot-up-missing" , "cam-stuck"]"#,
            r#"["No boot-up message after a reset." , "6300h stays 0."]"#,
            r#"[Row { .. Row :: USUAL } , Row { model : "reference-406" , fuzz : Never (Measured) , .. Row :: USUAL }]"#,
        ] {
            assert!(tokens.contains(part), "{part} in {tokens}");
        }
        let plain = expanded("enum Reason { /// is open\n Open }").unwrap();
        assert!(!plain.contains("Row"), "{plain}");
    }

    #[test]
    fn what_is_missing_is_named() {
        assert!(expanded("enum Fault { CamStuck }").unwrap_err().contains("doc comment"));
        assert!(expanded("struct Fault;").unwrap_err().contains("enum"));
        assert!(expanded("enum Fault { /// x\n #[row(model)] CamStuck }").unwrap_err().contains('='));
    }
}
