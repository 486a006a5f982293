//! The keys of `#[case]`.

use crate::keys::{self, Keys, is_id_part, list};
use proc_macro2::Span;
use syn::parse::{Parse, ParseStream};
use syn::token::Bracket;
use syn::{Error, Ident, LitStr, Path, Result};

/// The values of the keys between the parentheses of `#[case(…)]`.
pub struct Attributes {
    pub id: LitStr,
    pub standard: String,
    pub section: Option<String>,
    pub confidence: Ident,
    pub level: Ident,
    pub needs: Needs,
    pub touches: Vec<Ident>,
    pub catches: Vec<Ident>,
    pub answers: Vec<Ident>,
    pub cct: Option<LitStr>,
}

/// The needs of a case: `[VisibleState]`, or `super::needs[Turning, VisibleState]` if that module defines some of them.
#[derive(Default)]
pub struct Needs {
    pub module: Option<Path>,
    pub names: Vec<Ident>,
}

impl Parse for Needs {
    fn parse(input: ParseStream) -> Result<Self> {
        let module = if input.peek(Bracket) { None } else { Some(input.call(Path::parse_mod_style)?) };
        Ok(Self { module, names: list(input, name)? })
    }
}

/// The keys of `#[case]` while they are read; `None` for a key that was not given yet.
#[derive(Default)]
struct CaseKeys {
    id: Option<LitStr>,
    clause: Option<LitStr>,
    confidence: Option<Ident>,
    level: Option<Ident>,
    needs: Option<Needs>,
    touches: Option<Vec<Ident>>,
    catches: Option<Vec<Ident>>,
    answers: Option<Vec<Ident>>,
    cct: Option<LitStr>,
}

impl Parse for Attributes {
    fn parse(input: ParseStream) -> Result<Self> {
        let whole = input.span();
        keys::read::<CaseKeys>(input)?.complete(whole)
    }
}

impl Keys for CaseKeys {
    const ITEM: &str = "case";
    const KNOWN: &str = "id, clause, confidence, level, needs, touches, catches, answers and cct";

    fn read(&mut self, key: &str, value: ParseStream) -> Result<Option<bool>> {
        Ok(Some(match key {
            "id" => self.id.replace(value.parse()?).is_some(),
            "clause" => self.clause.replace(value.parse()?).is_some(),
            "cct" => self.cct.replace(value.parse()?).is_some(),
            "confidence" => self.confidence.replace(name(value)?).is_some(),
            "level" => self.level.replace(name(value)?).is_some(),
            "needs" => self.needs.replace(value.parse()?).is_some(),
            "touches" => self.touches.replace(list(value, name)?).is_some(),
            "answers" => self.answers.replace(list(value, name)?).is_some(),
            "catches" => self.catches.replace(list(value, name)?).is_some(),
            _ => return Ok(None),
        }))
    }
}

impl CaseKeys {
    fn complete(self, whole: Span) -> Result<Attributes> {
        let id = Self::required(self.id, "id = \"301/…\"", whole)?;
        check_id(&id)?;
        let clause = Self::required(self.clause, "clause = \"CiA 301 …\"", whole)?;
        let confidence = Self::required(self.confidence, "confidence = Cited|Attested|Derived|Known|Unknown", whole)?;
        let (standard, section) = split_clause(&clause, &confidence)?;
        let catches = Self::required(self.catches, "catches = [a firmware fault]", whole)?;
        if catches.is_empty() {
            return Err(Error::new(whole, "a case that catches no fault proves nothing: name one in `catches`"));
        }
        Ok(Attributes {
            id,
            standard,
            section,
            confidence,
            level: Self::required(self.level, "level = Must|Should|Open", whole)?,
            needs: self.needs.unwrap_or_default(),
            touches: self.touches.unwrap_or_default(),
            catches,
            answers: self.answers.unwrap_or_default(),
            cct: self.cct,
        })
    }
}

/// The name of a variant, with or without the name of its enum before it.
fn name(input: ParseStream) -> Result<Ident> {
    let path: Path = input.parse()?;
    let last = path.segments.last().map(|segment| segment.ident.clone());
    last.ok_or_else(|| Error::new(input.span(), "expected a name"))
}

/// Checks that an id has at least two parts separated by slashes, each of lower-case letters, digits and hyphens.
fn check_id(id: &LitStr) -> Result<()> {
    let text = id.value();
    if text.contains('/') && text.split('/').all(is_id_part) {
        return Ok(());
    }
    Err(Error::new(id.span(), "an id is lower-case words in a path, such as \"301/sdo/download/read-only\""))
}

/// Splits a clause into its standard and its section: `CiA 301 7.2.8.2.3.1` -> `CiA 301` and `7.2.8.2.3.1`.
fn split_clause(clause: &LitStr, confidence: &Ident) -> Result<(String, Option<String>)> {
    let text = clause.value();
    let mut words = text.split(' ');
    let standard = match (words.next(), words.next()) {
        (Some(body @ "CiA"), Some(number)) if !number.is_empty() => format!("{body} {number}"),
        _ => return Err(Error::new(clause.span(), "a clause begins with its standard, such as \"CiA 301 7.2\"")),
    };
    let is_number = |text: &str| text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let is_letter = |text: &str| text.len() == 1 && text.bytes().all(|b| b.is_ascii_uppercase());
    let section = match *words.collect::<Vec<_>>() {
        [] => None,
        [number] if is_number(number) => Some(number.to_owned()),
        ["annex", letter] if is_letter(letter) => Some(format!("annex {letter}")),
        _ => {
            let text =
                "after the standard stands one section number, such as \"7.2.8\", or an annex, such as \"annex A\"";
            return Err(Error::new(clause.span(), text));
        }
    };
    match (&section, confidence == "Unknown") {
        (None, false) => Err(Error::new(clause.span(), "only a clause of confidence Unknown has no section")),
        (Some(_), true) => Err(Error::new(clause.span(), "a clause of confidence Unknown has no section")),
        _ => Ok((standard, section)),
    }
}
