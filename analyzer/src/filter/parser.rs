//! The parser of filters. Its errors give the column.

use super::expression::{Expression, Flag, NumberField};
use crate::message::Service;
use nom::branch::alt;
use nom::bytes::complete::{tag, take_while, take_while1};
use nom::character::complete::{char, multispace0};
use nom::combinator::{cut, opt};
use nom::sequence::{delimited, preceded};
use nom::{IResult, Parser};
use std::ops::RangeInclusive;

/// Why a text is no filter.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("column {column}: expected {expected}{}\n  {text}\n  {:>column$}", found.as_deref().map(|found| format!(", found \"{found}\"")).unwrap_or_default(), "^")]
pub struct FilterError {
    /// The text of the filter.
    pub text: String,
    /// The column of the mistake, from 1, in characters.
    pub column: usize,
    /// The expected text.
    pub expected: String,
    /// The word at the column; `None` at the end of the text.
    pub found: Option<String>,
}

/// Maximum nesting of brackets and `not`.
const DEEPEST: usize = 50;

/// The input from the mistake on, and the expected text.
#[derive(Debug)]
struct Mistake<'a> {
    at: &'a str,
    expected: &'static str,
}

type Parsed<'a, T> = IResult<&'a str, T, Mistake<'a>>;

impl<'a> nom::error::ParseError<&'a str> for Mistake<'a> {
    fn from_error_kind(at: &'a str, _: nom::error::ErrorKind) -> Self {
        Self { at, expected: TEST }
    }

    fn append(_: &'a str, _: nom::error::ErrorKind, other: Self) -> Self {
        other
    }
}

const TEST: &str = "a test such as service=sdo, node in 1..8 or abort";

pub(super) fn parse(text: &str) -> Result<Expression, FilterError> {
    let ended = |(rest, expression): (&str, Expression)| match rest.trim_start() {
        "" => Ok(expression),
        at => Err(error(text, at, "\"and\", \"or\" or the end")),
    };
    match expression(text, DEEPEST) {
        Ok(parsed) => ended(parsed),
        Err(nom::Err::Error(mistake) | nom::Err::Failure(mistake)) => {
            Err(error(text, mistake.at.trim_start(), mistake.expected))
        }
        Err(nom::Err::Incomplete(_)) => Err(error(text, "", TEST)),
    }
}

fn error(text: &str, at: &str, expected: &str) -> FilterError {
    let position = text.len() - at.len();
    let word: String = at.chars().take_while(|c| !c.is_whitespace()).take(30).collect();
    FilterError {
        text: text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect(),
        column: text[..position].chars().count() + 1,
        expected: expected.to_owned(),
        found: (!word.is_empty()).then(|| word.escape_debug().to_string()),
    }
}

fn fail<'a, T>(at: &'a str, expected: &'static str) -> Parsed<'a, T> {
    Err(nom::Err::Failure(Mistake { at, expected }))
}

fn expression(input: &str, depth: usize) -> Parsed<'_, Expression> {
    let (rest, terms) = joined(input, keyword("or"), |input| conjunction(input, depth))?;
    Ok((rest, one_or(terms, Expression::Or)))
}

fn conjunction(input: &str, depth: usize) -> Parsed<'_, Expression> {
    let (rest, terms) = joined(input, keyword("and"), |input| factor(input, depth))?;
    Ok((rest, one_or(terms, Expression::And)))
}

/// Parses one or more items with separators; an item must follow each separator.
fn joined<'a, T>(
    input: &'a str,
    mut between: impl Parser<&'a str, Output = &'a str, Error = Mistake<'a>>,
    mut one: impl FnMut(&'a str) -> Parsed<'a, T>,
) -> Parsed<'a, Vec<T>> {
    let (mut rest, first) = one(input)?;
    let mut all = vec![first];
    while let Ok((after, _)) = between.parse(rest) {
        let (after, next) = cut(&mut one).parse(after)?;
        all.push(next);
        rest = after;
    }
    Ok((rest, all))
}

fn one_or(mut terms: Vec<Expression>, many: impl FnOnce(Vec<Expression>) -> Expression) -> Expression {
    match terms.pop() {
        Some(only) if terms.is_empty() => only,
        Some(last) => {
            terms.push(last);
            many(terms)
        }
        None => many(terms),
    }
}

fn factor(input: &str, depth: usize) -> Parsed<'_, Expression> {
    let Some(depth) = depth.checked_sub(1) else { return fail(input, "fewer brackets inside each other") };
    if let Ok((rest, _)) = keyword("not").parse(input) {
        return factor(rest, depth).map(|(rest, term)| (rest, Expression::Not(Box::new(term))));
    }
    if let Ok((rest, _)) = symbol("(").parse(input) {
        let (rest, inner) = expression(rest, depth)?;
        return match symbol(")").parse(rest) {
            Ok((rest, _)) => Ok((rest, inner)),
            Err(_) => fail(rest, "\")\""),
        };
    }
    test(input)
}

fn test(input: &str) -> Parsed<'_, Expression> {
    let (rest, name) = word(input)?;
    match name {
        "service" => service_test(rest),
        "channel" => channel_test(rest),
        _ => field_test(input, name, rest),
    }
}

fn field_test<'a>(input: &'a str, name: &str, rest: &'a str) -> Parsed<'a, Expression> {
    let named = |names: &[(&str, NumberField)]| names.iter().find(|row| row.0 == name).map(|row| row.1);
    if let Some(field) = named(&NumberField::NAMES)
        && let Some((rest, ranges, negated)) = comparison(rest)?
    {
        return Ok((rest, Expression::Number { field, ranges, negated }));
    }
    match Flag::NAMES.iter().find(|row| row.0 == name) {
        Some(flag) => Ok((rest, Expression::Flag(flag.1))),
        None if named(&NumberField::NAMES).is_some() => fail(rest, "=, !=, <, <=, >, >= or \"in\""),
        None => fail(input, TEST),
    }
}

type Ranges = Vec<RangeInclusive<u32>>;

/// Parses an operator and its numbers, as ranges; `None` if no operator follows.
fn comparison(input: &str) -> Result<Option<(&str, Ranges, bool)>, nom::Err<Mistake<'_>>> {
    if let Ok((rest, negated)) = is_in(input) {
        let (rest, ranges) = joined(rest, symbol(","), range)?;
        return Ok(Some((rest, ranges, negated)));
    }
    let operators = ["!=", "<=", ">=", "==", "=", "<", ">"];
    let Some((rest, operator)) = operators.iter().find_map(|operator| symbol(operator).parse(input).ok()) else {
        return Ok(None);
    };
    let (rest, value) = number(rest)?;
    // No number is below 0, so the range is empty.
    #[expect(clippy::reversed_empty_ranges, reason = "an empty range is what is meant")]
    let empty = 1..=0;
    let range = match operator {
        "<" => value.checked_sub(1).map_or(empty, |last| 0..=last),
        "<=" => 0..=value,
        ">" => value.checked_add(1).map_or(empty, |first| first..=u32::MAX),
        ">=" => value..=u32::MAX,
        _ => value..=value,
    };
    Ok(Some((rest, vec![range], operator == "!=")))
}

fn service_test(input: &str) -> Parsed<'_, Expression> {
    let expected = "a service: nmt, boot-up, heartbeat, guarding, sync, time, emcy, pdo, sdo, lss, lmt, srdo, \
                    flying-master, error-frame or unknown";
    let service = |input| {
        let (rest, name) = word(input)?;
        match Service::ALL.into_iter().find(|service| service.name() == name) {
            Some(service) => Ok((rest, service)),
            None => fail(input, expected),
        }
    };
    let (rest, (services, negated)) = names(input, service)?;
    Ok((rest, Expression::Service { services, negated }))
}

fn channel_test(input: &str) -> Parsed<'_, Expression> {
    let (rest, (names, negated)) = names(input, |input| word(input).map(|(rest, name)| (rest, name.to_owned())))?;
    Ok((rest, Expression::Channel { names, negated }))
}

/// Parses `= name`, `!= name`, `in name, name` or `not in name, name`.
fn names<'a, T>(input: &'a str, name: impl Fn(&'a str) -> Parsed<'a, T>) -> Parsed<'a, (Vec<T>, bool)> {
    if let Ok((rest, negated)) = is_in(input) {
        let (rest, names) = joined(rest, symbol(","), name)?;
        return Ok((rest, (names, negated)));
    }
    let Ok((rest, operator)) = alt((symbol("!="), symbol("=="), symbol("="))).parse(input) else {
        return fail(input, "=, != or \"in\"");
    };
    let (rest, name) = name(rest)?;
    Ok((rest, (vec![name], operator == "!=")))
}

/// Parses `in` or `not in`; returns whether it is `not in`.
fn is_in(input: &str) -> Parsed<'_, bool> {
    let (rest, negated) = opt(keyword("not")).parse(input)?;
    let (rest, _) = keyword("in").parse(rest)?;
    Ok((rest, negated.is_some()))
}

fn range(input: &str) -> Parsed<'_, RangeInclusive<u32>> {
    let (rest, first) = number(input)?;
    match symbol("..").parse(rest) {
        Ok((rest, _)) => number(rest).map(|(rest, last)| (rest, first..=last)),
        Err(_) => Ok((rest, first..=first)),
    }
}

/// Parses a number: decimal, or hexadecimal with the prefix `0x` or the suffix `h`.
fn number(input: &str) -> Parsed<'_, u32> {
    let expected = "a number such as 63, 0x3F or 3Fh";
    let (rest, digits) = match preceded(multispace0::<_, Mistake<'_>>, take_while1(alphanumeric)).parse(input) {
        Ok(parsed) => parsed,
        Err(_) => return fail(input, expected),
    };
    let hex =
        digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")).or_else(|| digits.strip_suffix(['h', 'H']));
    let value = match hex {
        Some(hex) => u32::from_str_radix(hex, 16),
        None => digits.parse(),
    };
    match value {
        Ok(value) => Ok((rest, value)),
        Err(_) => fail(input, expected),
    }
}

const fn alphanumeric(c: char) -> bool {
    c.is_ascii_alphanumeric()
}

/// Parses a name, possibly in quotes.
fn word(input: &str) -> Parsed<'_, &str> {
    let bare = take_while1(|c: char| c.is_alphanumeric() || "-_./:".contains(c));
    let quoted = delimited(char('"'), take_while(|c| c != '"'), char('"'));
    preceded(multispace0, alt((quoted, bare))).parse(input)
}

/// Parses the whole word `name`; the same word in quotes is no keyword.
fn keyword<'a>(name: &'static str) -> impl Parser<&'a str, Output = &'a str, Error = Mistake<'a>> {
    move |input: &'a str| match word(input) {
        Ok((rest, found)) if found == name && !input.trim_start().starts_with('"') => Ok((rest, found)),
        _ => Err(nom::Err::Error(Mistake { at: input, expected: TEST })),
    }
}

fn symbol<'a>(name: &'static str) -> impl Parser<&'a str, Output = &'a str, Error = Mistake<'a>> {
    preceded(multispace0, tag(name))
}
