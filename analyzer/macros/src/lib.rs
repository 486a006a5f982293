//! The `#[rule]` attribute: what a rule of the diagnosis says of itself, its thresholds and its state in one item.

mod attributes;
mod doc;
mod expand;
mod threshold;

use proc_macro::TokenStream;

/// Registers a rule of the diagnosis.
///
/// On the struct that is the rule's state. Its doc comment is what a user reads in `canvass explain` and `docs/rules.md`:
/// the title as the first paragraph, then what exactly is found, then a section `# Why`, and a section `# What to do`.
///
/// Keys:
///
/// - `id`: stable and textual, such as `"nodes/heartbeat-missing"`;
/// - `severity`: `Error`, `Warning` or `Info`;
/// - `services`: those whose frames the rule is shown, `[Sdo, Nmt]` or `all`;
/// - `also` (optional): frames that it is shown beside these, such as `KnownTpdos`, or several in brackets;
/// - `of` (optional): `capture` for a rule about whole captures, `nothing` for one that other code reports.
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
    expand::rule(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}
