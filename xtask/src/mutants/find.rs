//! Finds the points of a source file: operators, conditions, constants, statements, match arms and results.

use super::honest;
use super::point::{Form, Point, Variant};
use super::variants;
use std::collections::BTreeSet;
use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// The points of a file.
pub struct Findings {
    pub points: Vec<Point>,
    /// Ranges of `const` to be deleted: a `const` function could not choose a mutant at run time.
    pub removed: Vec<Range<usize>>,
}

/// Finds the points of a file. `constants` are the names of functions that must stay `const`; code that only a fault or
/// a liberty switches on is left out.
pub fn find(source: &str, constants: &BTreeSet<String>) -> syn::Result<Findings> {
    let file = syn::parse_file(source)?;
    let found = Findings { points: Vec::new(), removed: Vec::new() };
    let mut finder = Finder { source, constants, function: String::new(), found };
    finder.visit_file(&file);
    Ok(finder.found)
}

struct Finder<'a> {
    source: &'a str,
    constants: &'a BTreeSet<String>,
    function: String,
    found: Findings,
}

impl Finder<'_> {
    fn text(&self, node: &impl Spanned) -> &str {
        self.source.get(node.span().byte_range()).unwrap_or_default()
    }

    fn add(&mut self, range: Range<usize>, form: Form, variants: Vec<Variant>) {
        if !variants.is_empty() {
            let line = self.source.get(..range.start).unwrap_or_default().matches('\n').count() + 1;
            self.found.points.push(Point { range, form, variants, function: self.function.clone(), line });
        }
    }

    fn expression(&mut self, node: &impl Spanned, variants: Vec<Variant>) {
        self.add(node.span().byte_range(), Form::Expression, variants);
    }

    /// The signature and the body of a function.
    fn function(&mut self, attributes: &[syn::Attribute], signature: &syn::Signature, body: &syn::Block) {
        let name = signature.ident.to_string();
        if is_test(attributes) || signature.constness.is_some() && self.constants.contains(&name) {
            return;
        }
        if let Some(constness) = &signature.constness {
            self.found.removed.push(constness.span().byte_range());
        }
        let outer = std::mem::replace(&mut self.function, name);
        if !body.stmts.is_empty() {
            let begin = body.brace_token.span.open().byte_range().end;
            self.add(begin..begin, Form::Body, variants::results(&signature.output));
        }
        self.visit_block(body);
        self.function = outer;
    }

    fn condition(&mut self, condition: &syn::Expr) {
        if !has_let(condition) && !variants::is_operation(condition) {
            let negated = format!("!({})", self.text(condition));
            self.expression(condition, vec![Variant::new("negated", negated)]);
        }
    }

    /// Adds mutants in which an arm has the body of the next arm, for neighbouring arms which bind nothing.
    fn swap_arms(&mut self, arms: &[syn::Arm]) {
        for pair in arms.windows(2) {
            let [one, other] = pair else { continue };
            let is_dead =
                |arm: &syn::Arm| arm.guard.as_ref().is_some_and(|(_, guard)| honest::value(guard) == Some(false));
            let is_block = |arm: &syn::Arm| matches!(*arm.body, syn::Expr::Block(_));
            let plain = |arm: &syn::Arm| !binds(&arm.pat) && !is_block(arm) && !is_dead(arm);
            let (own, next) = (self.text(&one.body), self.text(&other.body));
            if plain(one) && plain(other) && own != next && !next.is_empty() {
                let variant = Variant::new("the next arm's", next.to_owned());
                self.expression(&*one.body, vec![variant]);
            }
        }
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(body) = &item.default {
            self.function(&item.attrs, &item.sig, body);
        }
    }

    // Code that must be constant, and code that is no expression, is skipped.
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_item_enum(&mut self, _: &'ast syn::ItemEnum) {}
    fn visit_item_struct(&mut self, _: &'ast syn::ItemStruct) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}

    fn visit_expr_repeat(&mut self, repeat: &'ast syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_stmt(&mut self, statement: &'ast syn::Stmt) {
        if let syn::Stmt::Expr(expression, Some(_)) = statement
            && variants::is_deletable(expression)
            && !honest::is_idle(expression)
        {
            let what = "left out";
            self.add(statement.span().byte_range(), Form::Statement, vec![Variant::new(what, "")]);
        }
        visit::visit_stmt(self, statement);
    }

    fn visit_expr(&mut self, expression: &'ast syn::Expr) {
        if honest::value(expression).is_none() {
            visit::visit_expr(self, expression);
        }
    }

    fn visit_expr_if(&mut self, expression: &'ast syn::ExprIf) {
        let known = honest::value(&expression.cond);
        if known.is_none() {
            self.condition(&expression.cond);
            self.visit_expr(&expression.cond);
        }
        if known != Some(false) {
            self.visit_block(&expression.then_branch);
        }
        if let Some((_, otherwise)) = expression.else_branch.as_ref().filter(|_| known != Some(true)) {
            self.visit_expr(otherwise);
        }
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        // A condition on a fault or liberty is no choice for mutants: `firmware.has(…) && this` counts as `this`.
        let is_plain = [&binary.left, &binary.right].iter().all(|side| honest::value(side).is_none() && !has_let(side));
        if is_plain {
            let (left, right) = (self.text(&binary.left).to_owned(), self.text(&binary.right).to_owned());
            self.expression(binary, variants::of_operator(&binary.op, &left, &right));
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'ast syn::ExprUnary) {
        if matches!(unary.op, syn::UnOp::Not(_)) {
            let variant = Variant::new("not negated", self.text(&unary.expr).to_owned());
            self.expression(unary, vec![variant]);
        }
        visit::visit_expr_unary(self, unary);
    }

    fn visit_expr_lit(&mut self, literal: &'ast syn::ExprLit) {
        self.expression(literal, variants::of_literal(&literal.lit));
    }

    fn visit_expr_macro(&mut self, expression: &'ast syn::ExprMacro) {
        if expression.mac.path.is_ident("matches") {
            let negated = format!("!{}", self.text(expression));
            self.expression(expression, vec![Variant::new("negated", negated)]);
        }
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if let Some(other) = variants::other_method(&call.method.to_string()) {
            let whole = call.span().byte_range();
            let name = call.method.span().byte_range();
            let text = |range: Range<usize>| self.source.get(range).unwrap_or_default();
            let changed = format!("{}{other}{}", text(whole.start..name.start), text(name.end..whole.end));
            let what = format!("{other} for {}", call.method);
            self.expression(call, vec![Variant::new(what, changed)]);
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_expr_match(&mut self, expression: &'ast syn::ExprMatch) {
        let is_last = |arm: &syn::Arm| matches!(arm.pat, syn::Pat::Wild(_)) && arm.guard.is_none();
        let has_wildcard = expression.arms.last().is_some_and(is_last);
        self.visit_expr(&expression.expr);
        for arm in &expression.arms {
            let known = arm.guard.as_ref().and_then(|(_, guard)| honest::value(guard));
            if known == Some(false) {
                continue;
            }
            match &arm.guard {
                Some(_) if known.is_some() => {}
                Some((_, guard)) if !has_let(guard) => {
                    let negated = format!("!({})", self.text(guard));
                    self.expression(
                        &**guard,
                        vec![Variant::new("negated", negated), Variant::new("always", "true".to_owned())],
                    );
                }
                None if has_wildcard && !is_last(arm) => {
                    self.add(arm.pat.span().byte_range(), Form::Arm, vec![Variant::new("arm left out", "")]);
                }
                _ => {}
            }
            if let Some((_, guard)) = &arm.guard {
                self.visit_expr(guard);
            }
            self.visit_expr(&arm.body);
        }
        self.swap_arms(&expression.arms);
    }
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| attribute.path().is_ident("cfg") || attribute.path().is_ident("test"))
}

/// Whether a condition contains a `let`, which can't be moved.
fn has_let(expression: &syn::Expr) -> bool {
    match expression {
        syn::Expr::Let(_) => true,
        syn::Expr::Binary(binary) => has_let(&binary.left) || has_let(&binary.right),
        syn::Expr::Paren(inner) => has_let(&inner.expr),
        _ => false,
    }
}

/// Whether a pattern binds a name.
fn binds(pattern: &syn::Pat) -> bool {
    struct Names(bool);
    impl<'ast> Visit<'ast> for Names {
        fn visit_pat_ident(&mut self, _: &'ast syn::PatIdent) {
            self.0 = true;
        }
        // The short form of `field: field` binds a name, too.
        fn visit_field_pat(&mut self, field: &'ast syn::FieldPat) {
            self.0 |= field.colon_token.is_none();
            visit::visit_field_pat(self, field);
        }
    }
    let mut names = Names(false);
    names.visit_pat(pattern);
    names.0
}
