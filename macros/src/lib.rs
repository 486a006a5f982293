//! The attributes `#[rule]` and `#[case]`: they register a rule of the diagnosis, or a conformance case, with all its
//! properties beside its code. `#[derive(Catalogue)]`: enums whose variants are entries of a list.

mod case;
mod catalogue;
mod doc;
mod keys;
mod rule;

use proc_macro::TokenStream;

/// Registers a rule of the diagnosis.
///
/// The attribute stands on the struct that holds the state of the rule. The struct's doc comment is the text in
/// `canvass explain` and on the reference page: the title as the first paragraph, then the exact condition of a
/// finding, then a section `# Why`, and a section `# What to do`.
///
/// Keys:
///
/// - `id`: stable and textual, such as `"nodes/heartbeat-missing"`;
/// - `severity`: `Error`, `Warning` or `Info`;
/// - `rank`: how grave the findings of the rule are for a machine, such as `Loss` or `Detail`;
/// - `services`: the services whose frames the rule gets, `[Sdo, Nmt]` or `all`;
/// - `also` (optional): frames that the rule gets in addition to those of `services`, such as `KnownTpdos`, or several
///   in brackets;
/// - `of` (optional): `capture` for a rule about whole captures, `nothing` for a rule whose findings other code
///   reports;
/// - `leads_to` (optional): the consequences of the rule's findings, a slice of `Effect`;
/// - `follows` (optional, for rules of device profiles): the ids of the rules whose findings cause findings of this
///   rule, each with the `Effect`.
///
/// Fields of the struct:
///
/// - `#[threshold(ms = 500)]`, with `us`, `percent` or `count` in place of `ms`: a limit that the user can set. The
///   field's doc comment is its meaning, its type is `Duration`, `Percent` or `u64`. `min` and `max` bound the values
///   that the user may set, and `unit` is the unit of a count.
/// - `#[from(path)]`: the field begins with the result of `path(&thresholds)`.
/// - All other fields begin with their default.
#[proc_macro_attribute]
pub fn rule(attribute: TokenStream, item: TokenStream) -> TokenStream {
    rule::rule(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Registers a conformance case.
///
/// The attribute stands on `fn name(bench: &mut Bench) -> Judged`. The doc comment is the requirement, in the words
/// that a user reads in reports and in `canvass explain`. Keys:
///
/// - `id`: stable and textual, such as `"301/sdo/download/read-only"`;
/// - `clause`: the standard and, if it is known, the section: `"CiA 301 7.2.8.2.3.1"`;
/// - `confidence`: how sure the number of the section is: `Cited`, `Attested`, `Derived`, `Known` or `Unknown`;
/// - `level`: `Must`, `Should` or `Open`;
/// - `catches`: at least one firmware fault that makes the case fail;
/// - `needs` (optional): features without which the case is not applicable: `VisibleState` is the static
///   `crate::needs::VISIBLE_STATE`;
/// - `touches` (optional): interventions that the user must allow first;
/// - `answers` (optional): rows of the table of allowed answers that functions name which the case calls; rows that the
///   case itself names need not be listed;
/// - `cct` (optional): the number of a comparable case of CiA's conformance test tool.
#[proc_macro_attribute]
pub fn case(attribute: TokenStream, item: TokenStream) -> TokenStream {
    case::case(attribute.into(), item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}

/// Makes the variants of an enum the entries of a catalogue.
///
/// `id()` is the name of a variant in lower case with hyphens, `summary()` its doc comment, and `ALL` has all variants
/// in their order. The enum's module defines a type `Row` with a constant `Row::USUAL`. `#[row(field = value, …)]` on a
/// variant changes fields of `Row::USUAL`; `row()` is the row of a variant.
#[proc_macro_derive(Catalogue, attributes(row))]
pub fn catalogue(item: TokenStream) -> TokenStream {
    catalogue::catalogue(item.into()).unwrap_or_else(|error| error.to_compile_error()).into()
}
