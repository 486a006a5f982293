//! The attributes `#[rule]` and `#[case]`: all that there is to say of a rule of the diagnosis, or of a conformance case,
//! beside its code. `#[derive(Catalogue)]`: enums whose variants are entries of a list.

mod case;
mod catalogue;
mod doc;
mod keys;
mod rule;

use proc_macro::TokenStream;

/// Registers a rule of the diagnosis.
///
/// On the struct that is the rule's state. Its doc comment is what a user reads in `canvass explain` and on the reference page:
/// the title as the first paragraph, then what exactly is found, then a section `# Why`, and a section `# What to do`.
///
/// Keys:
///
/// - `id`: stable and textual, such as `"nodes/heartbeat-missing"`;
/// - `severity`: `Error`, `Warning` or `Info`;
/// - `rank`: how grave its findings are for a machine, such as `Loss` or `Detail`;
/// - `services`: those whose frames the rule is shown, `[Sdo, Nmt]` or `all`;
/// - `also` (optional): frames that it is shown beside these, such as `KnownTpdos`, or several in brackets;
/// - `of` (optional): `capture` for a rule about whole captures, `nothing` for one that other code reports;
/// - `leads_to` (optional): what follows from its findings, a slice of `Effect`.
///
/// Fields of the struct:
///
/// - `#[threshold(ms = 500)]`, with `us`, `percent` or `count` in place of `ms`: a limit that the user can set; the
///   field's doc comment says what it means, and its type is `Duration`, `Percent` or `u64`. `min` and `max` bound what
///   may be set, and `unit` is the unit of a count.
/// - `#[from(path)]`: what `path(&thresholds)` gives.
/// - all others begin with their default.
#[proc_macro_attribute]
pub fn rule(attribute: TokenStream, item: TokenStream) -> TokenStream {
    rule::rule(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Registers a conformance case.
///
/// On `fn name(bench: &mut Bench) -> Judged`; the doc comment is the requirement, in the words that a user reads in
/// reports and in `canvass explain`. Keys:
///
/// - `id`: stable and textual, such as `"301/sdo/download/read-only"`;
/// - `clause`: the standard and, where it is known, the section: `"CiA 301 7.2.8.2.3.1"`;
/// - `confidence`: `Cited`, `Attested`, `Derived`, `Known` or `Unknown`: how sure the section's number is;
/// - `level`: `Must`, `Should` or `Open`;
/// - `catches`: at least one firmware fault that makes the case fail;
/// - `needs` (optional): features without which the case is not applicable: `VisibleState` is the static
///   `crate::needs::VISIBLE_STATE`;
/// - `touches` (optional): what the user must allow first;
/// - `cct` (optional): the number of a comparable case of CiA's conformance test tool.
#[proc_macro_attribute]
pub fn case(attribute: TokenStream, item: TokenStream) -> TokenStream {
    case::case(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Makes the entries of a catalogue of the variants of an enum.
///
/// The name of a variant in lower case with hyphens is `id()`, its doc comment `summary()`; `ALL` has all in their order.
/// `#[row(field = value, …)]` on a variant gives fields of the type `Row`, which stands beside the enum, values other than
/// those of `Row::USUAL`; `row()` is the row of a variant.
#[proc_macro_derive(Catalogue, attributes(row))]
pub fn catalogue(item: TokenStream) -> TokenStream {
    catalogue::catalogue(item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}
