//! Rewrites a file so that it contains all its mutants, of which one is chosen at run time.
//!
//! A point becomes `match mutant::at(FIRST, COUNT) { 1 => mutant, …, _ => original }`. Inside a mutant the original
//! text has no further choices: so the text grows with the depth of the points and not with their product.

use super::find::Findings;
use super::point::{Form, Point};
use std::ops::Range;

/// The text of a file with its mutants.
pub struct Rewritten {
    pub text: String,
    /// The range of each point in the new text, by its index in the findings.
    pub places: Vec<Range<usize>>,
}

/// Rewrites a file; the numbers of its mutants begin with `first`, point by point.
pub fn rewrite(source: &str, found: &Findings, first: u32) -> Rewritten {
    let mut numbers = Vec::with_capacity(found.points.len());
    let mut next = first;
    for point in &found.points {
        numbers.push(next);
        next += point.variants.len() as u32;
    }
    let mut order: Vec<usize> = (0..found.points.len()).collect();
    // Outer points come before inner points; of points with the same range, the point found first is the outer point.
    order.sort_by_key(|&at| (found.points[at].range.start, std::cmp::Reverse(found.points[at].range.end), at));
    let mut writer = Writer { source, found, numbers, text: String::new(), places: vec![0..0; found.points.len()] };
    writer.write(0..source.len(), &order);
    Rewritten { text: writer.text, places: writer.places }
}

struct Writer<'a> {
    source: &'a str,
    found: &'a Findings,
    numbers: Vec<u32>,
    text: String,
    places: Vec<Range<usize>>,
}

impl Writer<'_> {
    /// Writes a part of the source with its points, which are in order.
    fn write(&mut self, range: Range<usize>, points: &[usize]) {
        let (mut from, mut rest) = (range.start, points);
        while let Some((&outer, after)) = rest.split_first() {
            let point = &self.found.points[outer];
            let inside = after.iter().take_while(|&&at| self.found.points[at].range.start < point.range.end).count();
            // Points of length zero contain no others.
            let (inner, others) = after.split_at(if point.range.is_empty() { 0 } else { inside });
            self.copy(from..point.range.start);
            let begin = self.text.len();
            self.choice(outer, inner);
            self.places[outer] = begin..self.text.len();
            from = point.range.end;
            rest = others;
        }
        self.copy(from..range.end);
    }

    fn choice(&mut self, at: usize, inner: &[usize]) {
        let found = self.found;
        let Point { range, form, variants, .. } = &found.points[at];
        let switch = format!("crate::mutant::at({}, {})", self.numbers[at], variants.len());
        match form {
            Form::Expression | Form::Body => {
                let is_body = *form == Form::Body;
                self.text += if is_body { " match " } else { "(match " };
                self.text += &switch;
                self.text += " { ";
                for (n, variant) in variants.iter().enumerate() {
                    self.text += &format!("{} => {{ {} }} ", n + 1, variant.text);
                }
                self.text += "_ => { ";
                self.write(range.clone(), inner);
                self.text += if is_body { " } } " } else { " } })" };
            }
            Form::Statement => {
                self.text += &format!("if {switch} == 0 {{ ");
                self.write(range.clone(), inner);
                self.text += " }";
            }
            Form::Arm => {
                self.write(range.clone(), inner);
                self.text += &format!(" if {switch} == 0");
            }
        }
    }

    /// Copies a part of the source without points, omitting the deleted words.
    fn copy(&mut self, range: Range<usize>) {
        let mut from = range.start;
        for removed in
            self.found.removed.iter().filter(|removed| range.start <= removed.start && removed.end <= range.end)
        {
            self.text += &self.source[from..removed.start];
            from = removed.end;
        }
        self.text += &self.source[from..range.end];
    }
}

#[cfg(test)]
mod tests {
    use super::super::find::find;
    use super::*;
    use std::collections::BTreeSet;

    fn rewritten(source: &str) -> String {
        let found = find(source, &BTreeSet::new()).unwrap();
        let text = rewrite(source, &found, 1).text;
        syn::parse_file(&text).unwrap();
        text
    }

    #[test]
    fn an_operator_is_chosen_at_run_time() {
        assert_eq!(
            rewritten("fn f(a: u8, b: u8) -> bool { g(a < b) }").split_once("_ => {  } } ").unwrap().1,
            " g((match crate::mutant::at(3, 2) { 1 => { a <= b } 2 => { a >= b } _ => { a < b } })) }"
        );
    }

    #[test]
    fn a_mutant_has_no_others_in_it() {
        let text = rewritten("fn f(a: u8) -> char { if a + 1 == 7 { 'a' } else { 'b' } }");
        assert!(text.contains("1 => { a + 1 != 7 }"), "{text}");
        assert!(text.contains("1 => { a - 1 }"), "{text}");
    }

    #[test]
    fn statements_arms_and_constant_functions() {
        let text = rewritten("const fn f(a: u8) -> char { g(a); match a { 1 => 'a', _ => 'b' } }");
        assert!(text.starts_with(" fn f"), "{text}");
        assert!(text.contains("if crate::mutant::at(1, 1) == 0 { g(a); }"), "{text}");
        assert!(text.contains("1 if crate::mutant::at(2, 1) == 0 =>"), "{text}");
        assert!(text.contains("{ 1 => { 'b' } _ => { 'a' } }"), "{text}");
    }

    #[test]
    fn what_has_to_be_constant_stays() {
        let source = "const A: u8 = 1 + 2; fn f() -> [u8; 8] { [g(); 8] } #[cfg(test)] mod tests { fn g() { h(1) } }";
        assert!(!rewritten(source).contains("mutant"));
    }

    #[test]
    fn let_in_a_condition_stays_where_it_is() {
        let text = rewritten("fn f() -> char { if a < b && let Some(c) = d && !c { 'a' } else { 'b' } }");
        assert!(text.contains("&& let Some(c) = d &&"), "{text}");
        assert!(text.contains("{ a <= b }") && text.contains("1 => { c }"), "{text}");
    }
}
