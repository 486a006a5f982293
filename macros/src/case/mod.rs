//! The expansion of `#[case]`.

mod attributes;

use crate::doc;
use attributes::Attributes;
use proc_macro2::{TokenStream, TokenTree};
use quote::{ToTokens, quote};
use std::collections::BTreeSet;
use syn::{Error, Ident, ItemFn, Result};

/// Expands `#[case]` to the unchanged function and its registration.
pub fn case(attribute: TokenStream, item: TokenStream) -> Result<TokenStream> {
    let attributes: Attributes = syn::parse2(attribute)?;
    let function: ItemFn = syn::parse2(item)?;
    let requirement = requirement(&function)?;
    let name = &function.sig.ident;
    let Attributes { id, standard, section, confidence, level, needs, touches, catches, answers, cct } = attributes;
    let answers = situations(function.block.to_token_stream(), answers);
    let of_module = needs.module.iter();
    let needs = needs.names.iter().map(static_of);
    let section = option(section);
    let cct = option(cct);
    Ok(quote! {
        #function

        ::inventory::submit! {
            ::canvass_suite::case::Case {
                id: #id,
                requirement: #requirement,
                clause: ::canvass_suite::clause::Clause {
                    standard: #standard,
                    section: #section,
                    confidence: ::canvass_suite::clause::Confidence::#confidence,
                },
                level: ::canvass_suite::clause::Level::#level,
                needs: {
                    #[allow(unused_imports)]
                    use ::canvass_suite::needs::*;
                    #(use #of_module::*;)*
                    &[#(&#needs),*]
                },
                touches: &[#(::canvass_suite::touch::Touch::#touches),*],
                catches: &[#(::canvass_suite::Fault::#catches),*],
                answers: &[#(::canvass_suite::situation::Situation::#answers),*],
                cct: #cct,
                run: #name,
            }
        }
    })
}

/// The rows of the table of allowed answers that a case uses: rows named in its body, and rows that the attribute adds
/// for the functions that the body calls.
fn situations(body: TokenStream, mut known: Vec<Ident>) -> Vec<Ident> {
    // Number of colons seen since `Situation`; the row follows the second colon.
    let mut after: Option<usize> = None;
    for token in body {
        match (&token, after) {
            (TokenTree::Ident(name), _) if name == "Situation" => after = Some(0),
            (TokenTree::Punct(punct), Some(colons @ 0..2)) if punct.as_char() == ':' => after = Some(colons + 1),
            (TokenTree::Ident(row), Some(2)) => {
                known.push(row.clone());
                after = None;
            }
            (TokenTree::Group(group), _) => {
                known = situations(group.stream(), known);
                after = None;
            }
            _ => after = None,
        }
    }
    let mut seen = BTreeSet::new();
    known.retain(|row| seen.insert(row.to_string()));
    known
}

/// The name of the static for a need: `VisibleState` -> `VISIBLE_STATE`.
fn static_of(need: &Ident) -> Ident {
    let mut name = String::new();
    for letter in need.to_string().chars() {
        if letter.is_ascii_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(letter.to_ascii_uppercase());
    }
    Ident::new(&name, need.span())
}

fn option(value: Option<impl quote::ToTokens>) -> TokenStream {
    match value {
        Some(value) => quote!(::core::option::Option::Some(#value)),
        None => quote!(::core::option::Option::None),
    }
}

/// The doc comment of the function as one text: lines joined by spaces, empty lines kept between paragraphs.
fn requirement(function: &ItemFn) -> Result<String> {
    let text = doc::text(&function.attrs);
    if text.is_empty() {
        let advice =
            "a case says its requirement in its doc comment: what the standard demands, in one or two sentences";
        return Err(Error::new(function.sig.ident.span(), advice));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FUNCTION: &str =
        "/// Every reset ends\n/// in a boot-up.\n///\n/// Why.\nfn f(bench: &mut Bench) -> Judged {}";
    const COMPLETE: &str = r#"id = "301/boot-up/reset", clause = "CiA 301 7.2", confidence = Known, level = Must,
        needs = [VisibleState], catches = [Fault::BootUpMissing], cct = "9.1""#;

    fn expanded(attribute: &str, item: &str) -> std::result::Result<String, String> {
        let parsed = (attribute.parse().unwrap(), item.parse().unwrap());
        case(parsed.0, parsed.1).map(|tokens| tokens.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_case_lists_the_situations_that_it_names_and_those_that_are_added() {
        let item = "/// All.\nfn f(b: &mut Bench) -> Judged { if x { a.refused(Situation::TooLong)? } g(Situation::TooShort, Situation::TooLong) }";
        let attribute = COMPLETE.to_owned() + ", answers = [ReadOnly]";
        let tokens = expanded(&attribute, item).unwrap().replace(' ', "");
        let row = |name| format!("::canvass_suite::situation::Situation::{name}");
        let list = [row("ReadOnly"), row("TooLong"), row("TooShort")].join(",");
        assert!(tokens.contains(&format!("answers:&[{list}]")), "{tokens}");
    }

    #[test]
    fn a_complete_case_is_registered_with_its_requirement() {
        let tokens = expanded(COMPLETE, FUNCTION).unwrap();
        assert!(tokens.contains(r#"requirement : "Every reset ends in a boot-up.\n\nWhy.""#), "{tokens}");
        assert!(tokens.contains("Fault :: BootUpMissing") && tokens.contains("& VISIBLE_STATE"), "{tokens}");
        assert!(tokens.contains(r#"section : :: core :: option :: Option :: Some ("7.2")"#), "{tokens}");
    }

    #[test]
    fn needs_of_a_module_are_in_scope() {
        let attribute = COMPLETE.replace("needs = [VisibleState]", "needs = super::needs[VisibleState]");
        let tokens = expanded(&attribute, FUNCTION).unwrap();
        assert!(tokens.contains("use super :: needs :: *") && tokens.contains("& VISIBLE_STATE"), "{tokens}");
        assert!(!expanded(COMPLETE, FUNCTION).unwrap().contains("use super"));
    }

    #[test]
    fn what_is_missing_is_named() {
        let without = |key: &str| {
            let kept: Vec<&str> = COMPLETE.split(", ").filter(|pair| !pair.trim().starts_with(key)).collect();
            expanded(&kept.join(", "), FUNCTION).unwrap_err()
        };
        for key in ["id", "clause", "confidence", "level", "catches"] {
            assert!(without(key).contains(&format!("`{key} =")), "{}", without(key));
        }
        assert!(expanded(COMPLETE, "fn f() {}").unwrap_err().contains("doc comment"));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let with = |from: &str, to: &str| expanded(&COMPLETE.replace(from, to), FUNCTION).unwrap_err();
        assert!(with("[Fault::BootUpMissing]", "[]").contains("proves nothing"));
        assert!(with("301/boot-up/reset", "301/Boot Up").contains("lower-case"));
        assert!(with("CiA 301 7.2", "7.2").contains("its standard"));
        assert!(with("Known", "Unknown").contains("no section"));
        assert!(with("cct", "cst").contains("`cst`"));
        assert!(with("cct =", "id =").contains("twice"));
    }
}
