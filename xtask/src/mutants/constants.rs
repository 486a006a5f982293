//! The functions that must stay `const`.

use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeSet;
use syn::visit::{self, Visit};

/// Finds functions that are called in constant contexts.
pub fn called_in_constants(source: &str) -> syn::Result<BTreeSet<String>> {
    let mut calls = Calls::default();
    calls.visit_file(&syn::parse_file(source)?);
    Ok(calls.names)
}

#[derive(Default)]
struct Calls {
    names: BTreeSet<String>,
    inside: bool,
}

impl<'ast> Visit<'ast> for Calls {
    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.of(&item.expr);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.of(&item.expr);
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.of(&item.expr);
    }

    fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
        if self.inside
            && let Some(last) = path.path.segments.last()
        {
            self.names.insert(last.ident.to_string());
        }
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        if self.inside {
            self.names.insert(call.method.to_string());
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_expr_const(&mut self, block: &'ast syn::ExprConst) {
        let outer = std::mem::replace(&mut self.inside, true);
        visit::visit_expr_const(self, block);
        self.inside = outer;
    }

    // The expansion of a macro is unknown here: every word in its constant blocks may be a call.
    fn visit_macro(&mut self, invoked: &'ast syn::Macro) {
        self.of_tokens(invoked.tokens.clone(), false);
    }
}

impl Calls {
    fn of_tokens(&mut self, tokens: TokenStream, inside: bool) {
        let mut after_const = false;
        for token in tokens {
            match token {
                TokenTree::Group(group) => self.of_tokens(group.stream(), inside || after_const),
                TokenTree::Ident(word) => {
                    after_const = word == "const";
                    if inside {
                        self.names.insert(word.to_string());
                    }
                    continue;
                }
                _ => {}
            }
            after_const = false;
        }
    }

    fn of(&mut self, expression: &syn::Expr) {
        let outer = std::mem::replace(&mut self.inside, true);
        self.visit_expr(expression);
        self.inside = outer;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_macro_calls_in_a_constant_block_is_known() {
        let source =
            "macro_rules! rows { ($a:expr) => { match 1 { _ => const { &row($a) } } } } fn f() { const { g() } }";
        let called = called_in_constants(source).unwrap();
        assert!(called.contains("row") && called.contains("g") && !called.contains("macro_rules"), "{called:?}");
    }
}
