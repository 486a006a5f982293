//! What a firmware without fault and liberty answers where it is asked for them: the code for faulty firmware is no matter of
//! mutants, and a mutant that only switches a fault of the list on, or a liberty, is no news.

use std::collections::BTreeMap;
use syn::{BinOp, Expr, UnOp};

/// The hooks of the firmware, each with what it is without any fault or liberty.
#[derive(Default)]
pub struct Hooks(BTreeMap<String, bool>);

impl Hooks {
    /// Adds the rows of `hooks!` in a file: `NAME with FAULT`, `NAME unless FAULT`, `NAME by LIBERTY`, `NAME but LIBERTY`.
    pub fn add(&mut self, source: &str) {
        let Some((_, rows)) = source.split_once("hooks! {\n") else { return };
        for row in rows.lines().take_while(|row| *row != "}") {
            let mut words = row.split_whitespace();
            if let (Some(name), Some(how)) = (words.next(), words.next()) {
                self.0.insert(name.to_owned(), matches!(how, "unless" | "but"));
            }
        }
    }

    /// What a condition is without any fault or liberty, where hooks alone decide it.
    pub fn value(&self, condition: &Expr) -> Option<bool> {
        match condition {
            Expr::MethodCall(call) if call.args.is_empty() => self.0.get(&call.method.to_string()).copied(),
            Expr::Paren(inner) => self.value(&inner.expr),
            Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => self.value(&unary.expr).map(|value| !value),
            Expr::Binary(binary) => {
                let sides = (self.value(&binary.left), self.value(&binary.right));
                match (binary.op, sides) {
                    (BinOp::And(_), (Some(false), _) | (_, Some(false))) => Some(false),
                    (BinOp::Or(_), (Some(true), _) | (_, Some(true))) => Some(true),
                    (BinOp::And(_) | BinOp::Or(_), (Some(one), Some(_))) => Some(one),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Whether a statement does nothing without any fault or liberty: `this |= hook`.
    pub fn is_idle(&self, statement: &Expr) -> bool {
        let Expr::Binary(binary) = statement else { return false };
        let neutral = match binary.op {
            BinOp::BitOrAssign(_) => false,
            BinOp::BitAndAssign(_) => true,
            _ => return false,
        };
        self.value(&binary.right) == Some(neutral)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(condition: &str) -> Option<bool> {
        let mut hooks = Hooks::default();
        hooks.add("hooks! {\n    checks unless Fault,\n    dies with Fault or Liberty,\n    waits by Liberty,\n}\n");
        hooks.value(&syn::parse_str(condition).unwrap())
    }

    #[test]
    fn hooks_are_what_they_are_without_fault() {
        assert_eq!(value("firmware.checks()"), Some(true));
        assert_eq!(value("self.firmware.dies()"), Some(false));
        assert_eq!(value("!firmware.waits()"), Some(true));
        assert_eq!(value("firmware.dies() && open"), Some(false));
        assert_eq!(value("open || !firmware.dies()"), Some(true));
        assert_eq!(value("firmware.checks() && open"), None);
        assert_eq!(value("firmware.checks() && !(firmware.dies())"), Some(true));
    }
}
