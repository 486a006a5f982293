//! The expansion of `#[rule]`.

mod attributes;
mod doc;
mod threshold;

use attributes::{Attributes, Of, Services};
use doc::{Doc, doc};
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Fields, ItemStruct, Result};
use threshold::{Begin, begin};

/// Expands `#[rule]` to the unchanged struct, its constructor, and its registration.
pub fn rule(attribute: TokenStream, item: TokenStream) -> Result<TokenStream> {
    let attributes: Attributes = syn::parse2(attribute)?;
    let mut state: ItemStruct = syn::parse2(item)?;
    let Doc { title, what, why, advice } = doc(&state.attrs, state.ident.span())?;
    let name = state.ident.clone();
    let fields = begins(&mut state.fields)?;
    let Attributes { id, severity, rank, leads_to, follows, services, also, of } = attributes;
    let [leads_to, follows] = [leads_to, follows].map(|list| list.map_or_else(|| quote!(&[]), |list| quote!(#list)));
    let services = match services {
        Services::All => quote!(&crate::message::Service::ALL),
        Services::These(these) => quote!(&[#(crate::message::Service::#these),*]),
    };
    let make = match of {
        Of::Bus => quote!(Bus(|thresholds| ::std::boxed::Box::new(#name::new(thresholds)))),
        Of::Capture => quote!(Capture(|thresholds| ::std::boxed::Box::new(#name::new(thresholds)))),
        Of::Nothing => quote!(Nothing),
    };
    let new = (of != Of::Nothing).then(|| new(&fields));
    let thresholds = fields.thresholds;
    Ok(quote! {
        #state

        impl #name {
            /// The description of the rule.
            pub(crate) const METADATA: &'static crate::findings::Metadata = &crate::findings::Metadata {
                id: #id,
                severity: crate::findings::Severity::#severity,
                rank: crate::findings::Rank::#rank,
                leads_to: #leads_to,
                follows: #follows,
                title: #title,
                what: #what,
                why: #why,
                advice: #advice,
                thresholds: &[#(#thresholds),*],
            };

            #new
        }

        ::inventory::submit! {
            crate::findings::Definition {
                metadata: #name::METADATA,
                services: #services,
                also: &[#(crate::findings::Also::#also),*],
                make: crate::findings::Make::#make,
            }
        }
    })
}

/// The initial values of the fields of a rule's state.
struct Begins {
    /// The descriptions of the thresholds.
    thresholds: Vec<TokenStream>,
    fields: TokenStream,
    /// Whether the initial value of any field depends on the user's thresholds.
    is_limited: bool,
}

/// The constructor of a rule's state.
fn new(begins: &Begins) -> TokenStream {
    let parameter = if begins.is_limited { quote!(thresholds) } else { quote!(_) };
    let fields = &begins.fields;
    quote! {
        /// The state of the rule before the first frame.
        fn new(#parameter: &crate::findings::Thresholds) -> Self {
            Self #fields
        }
    }
}

fn begins(fields: &mut Fields) -> Result<Begins> {
    let (mut thresholds, mut begins, mut is_limited) = (Vec::new(), Vec::new(), false);
    for field in fields.iter_mut() {
        let begin = begin(field)?;
        is_limited |= !matches!(begin, Begin::Default);
        let value = match begin {
            Begin::Threshold(threshold) => {
                let value = threshold.value(thresholds.len());
                thresholds.push(threshold.metadata());
                value
            }
            Begin::From(path) => quote!(#path(thresholds)),
            Begin::Default => quote!(::core::default::Default::default()),
        };
        let name = &field.ident;
        begins.push(quote!(#name: #value));
    }
    let fields = if begins.is_empty() { TokenStream::new() } else { quote!({ #(#begins),* }) };
    Ok(Begins { thresholds, fields, is_limited })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATE: &str = r#"
        /// heartbeats are missing
        ///
        /// The next one comes
        /// too late.
        ///
        /// # Why
        /// Consumers react.
        ///
        /// # What to do
        /// Look for a boot-up.
        struct Missing {
            /// of the period
            #[threshold(percent = 180, min = 101)]
            percent: Percent,
            /// as counted
            #[threshold(count = 12, unit = "rpm")]
            top_speed: u64,
            #[from(other::wait)]
            wait: Duration,
            nodes: PerNode<Seen>,
        }"#;
    const COMPLETE: &str = r#"id = "nodes/heartbeat-missing", severity = Error, rank = State, services = [Heartbeat, Nmt], also = KnownTpdos"#;

    fn expanded(attribute: &str, item: &str) -> std::result::Result<String, String> {
        let parsed = (attribute.parse().unwrap(), item.parse().unwrap());
        rule(parsed.0, parsed.1).map(|tokens| tokens.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_complete_rule_is_registered_with_its_doc_and_its_thresholds() {
        let tokens = expanded(COMPLETE, STATE).unwrap();
        for part in [
            r#"title : "heartbeats are missing""#,
            r#"what : "The next one comes too late.""#,
            r#"why : "Consumers react.""#,
            r#"advice : "Look for a boot-up.""#,
            "Service :: Heartbeat , crate :: message :: Service :: Nmt",
            "Also :: KnownTpdos",
            "rank : crate :: findings :: Rank :: State , leads_to : & []",
            "percent : thresholds . percent (Self :: METADATA , 0usize)",
            "top_speed : thresholds . count (Self :: METADATA , 1usize)",
            "wait : other :: wait (thresholds)",
            "nodes : :: core :: default :: Default :: default ()",
            r#"name : "top-speed" , default : 12u64 , unit : crate :: findings :: Unit :: Count ("rpm")"#,
            "least : 101u64",
        ] {
            assert!(tokens.contains(part), "{part} in {tokens}");
        }
        assert!(!tokens.contains("# [threshold"), "{tokens}");
    }

    #[test]
    fn what_is_missing_is_named() {
        let without = |key: &str| {
            let kept: Vec<&str> = COMPLETE.split(", ").filter(|pair| !pair.trim().starts_with(key)).collect();
            expanded(&kept.join(", "), STATE).unwrap_err()
        };
        assert!(without("id").contains("`id ="), "{}", without("id"));
        assert!(without("severity").contains("`severity ="));
        assert!(without("rank").contains("lacks `rank ="));
        let docless = |line: &str| expanded(COMPLETE, &STATE.replace(line, "")).unwrap_err();
        assert!(docless("/// # Why").contains("lacks a section `# Why`"), "{}", docless("/// # Why"));
        assert!(docless("/// Look for a boot-up.").contains("`# What to do`"));
        assert!(docless("/// of the period").contains("what it means"));
        let blind = expanded(r#"id = "nodes/x", severity = Error"#, STATE).unwrap_err();
        assert!(blind.contains("is shown frames"), "{blind}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let with = |from: &str, to: &str| expanded(&COMPLETE.replace(from, to), STATE).unwrap_err();
        assert!(with("nodes/heartbeat-missing", "Nodes").contains("lower-case"));
        assert!(with("severity", "gravity").contains("`gravity`"));
        assert!(
            with("also =", "id =").contains("expected") || with("also = KnownTpdos", "id = \"a/b\"").contains("twice")
        );
        let state = |from: &str, to: &str| expanded(COMPLETE, &STATE.replace(from, to)).unwrap_err();
        assert!(state("percent = 180", "hours = 180").contains("counted in ms"));
        assert!(state("percent = 180, min = 101", "min = 101").contains("its default"));
        assert!(state("percent = 180, min", "percent = 180, unit = \"x\", min").contains("only a count"));
        assert!(state("# Why", "# Because").contains("no section"));
    }

    #[test]
    fn a_rule_about_captures_is_shown_no_frames() {
        let capture = expanded(r#"id = "capture/gaps", severity = Info, rank = Detail, of = capture"#, STATE).unwrap();
        assert!(capture.contains("Make :: Capture"));
        let both = expanded(r#"id = "capture/gaps", severity = Info, of = capture, services = all"#, STATE);
        assert!(both.is_err());
    }
}
