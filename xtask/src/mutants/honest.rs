//! Evaluates conditions for a firmware without faults and liberties. Code for faulty firmware gets no mutants: a mutant
//! that only switches on a fault of the list, or a liberty, proves nothing.

use syn::{BinOp, Expr, ExprMethodCall, UnOp};

/// The value of a condition without any fault or liberty; `None` if it depends on anything else.
pub fn value(condition: &Expr) -> Option<bool> {
    match condition {
        Expr::MethodCall(call) => asks_firmware(call).then_some(false),
        Expr::Paren(inner) => value(&inner.expr),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => value(&unary.expr).map(|value| !value),
        Expr::Binary(binary) => {
            let sides = (value(&binary.left), value(&binary.right));
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

/// Whether a call asks for a fault or liberty: `….has(Fault::…)` or `….takes(Liberty::…)`.
fn asks_firmware(call: &ExprMethodCall) -> bool {
    let of = match call.method.to_string().as_str() {
        "has" => "Fault",
        "takes" => "Liberty",
        _ => return false,
    };
    let first = |argument: &Expr| matches!(argument, Expr::Path(path) if path.path.segments.first().is_some_and(|first| first.ident == of));
    call.args.first().is_some_and(first)
}

/// Whether a statement has no effect without any fault or liberty: `this |= firmware.has(Fault::…)`.
pub fn is_idle(statement: &Expr) -> bool {
    let Expr::Binary(binary) = statement else { return false };
    let neutral = match binary.op {
        BinOp::BitOrAssign(_) => false,
        BinOp::BitAndAssign(_) => true,
        _ => return false,
    };
    value(&binary.right) == Some(neutral)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(condition: &str) -> Option<bool> {
        value(&syn::parse_str(condition).unwrap())
    }

    #[test]
    fn a_firmware_without_fault_has_none() {
        assert_eq!(known("!firmware.has(Fault::Unchecked)"), Some(true));
        assert_eq!(known("self.firmware.has(Fault::Dies)"), Some(false));
        assert_eq!(known("!context.takes(Liberty::Waits)"), Some(true));
        assert_eq!(known("context.has(Fault::Dies) && open"), Some(false));
        assert_eq!(known("open || !objects.has(Fault::Dies)"), Some(true));
        assert_eq!(known("!firmware.has(Fault::Unchecked) && open"), None);
        assert_eq!(known("!firmware.has(Fault::Unchecked) && !(firmware.has(Fault::Dies))"), Some(true));
        assert_eq!(known("group.has(node)"), None);
    }
}
