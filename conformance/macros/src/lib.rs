//! The `#[case]` attribute: id, clause, requirement and check of a conformance case in one item.

mod attributes;
mod expand;

use proc_macro::TokenStream;

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
    expand::case(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}
