//! Replacements for operators, constants, methods and results.

use super::point::Variant;
use syn::{BinOp, Expr, Lit};

/// Other operators between the same operands; for two conditions also each of them alone.
pub fn of_operator(operator: &BinOp, left: &str, right: &str) -> Vec<Variant> {
    let others: &[&str] = match operator {
        BinOp::Add(_) => &["-"],
        BinOp::Sub(_) => &["+"],
        BinOp::Mul(_) => &["/", "+"],
        BinOp::Div(_) => &["*"],
        BinOp::Rem(_) => &["/"],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::BitAnd(_) => &["|", "^"],
        BinOp::BitOr(_) => &["&", "^"],
        BinOp::BitXor(_) => &["|", "&"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::Lt(_) => &["<=", ">="],
        BinOp::Le(_) => &["<", ">"],
        BinOp::Gt(_) => &[">=", "<="],
        BinOp::Ge(_) => &[">", "<"],
        BinOp::AddAssign(_) => &["-="],
        BinOp::SubAssign(_) => &["+="],
        BinOp::BitOrAssign(_) => &["&=", "="],
        BinOp::BitAndAssign(_) => &["|=", "="],
        BinOp::BitXorAssign(_) => &["|=", "="],
        BinOp::ShlAssign(_) => &[">>="],
        BinOp::ShrAssign(_) => &["<<="],
        _ => &[],
    };
    let mut variants: Vec<Variant> = others
        .iter()
        .map(|other| Variant::new(format!("{other} between"), format!("{left} {other} {right}")))
        .collect();
    if matches!(operator, BinOp::And(_) | BinOp::Or(_)) {
        variants.push(Variant::new("left one only", left));
        variants.push(Variant::new("right one only", right));
    }
    variants
}

/// The replacements of a literal: the number plus one, minus one, and 0, or the other truth value.
pub fn of_literal(literal: &Lit) -> Vec<Variant> {
    match literal {
        Lit::Int(number) => {
            let Ok(value) = number.base10_parse::<u128>() else { return Vec::new() };
            let mut values = vec![value + 1];
            values.extend(value.checked_sub(1));
            values.extend((value > 1).then_some(0));
            let suffix = number.suffix();
            values.iter().map(|value| Variant::new(value.to_string(), format!("{value}{suffix}"))).collect()
        }
        Lit::Bool(truth) => {
            let other = !truth.value;
            vec![Variant::new(other.to_string(), other.to_string())]
        }
        _ => Vec::new(),
    }
}

/// Values that a function can return at once.
pub fn results(output: &syn::ReturnType) -> Vec<Variant> {
    let at_once = |value: &str| Variant::new(format!("returns {value} at once"), format!("return {value}"));
    let syn::ReturnType::Type(_, declared) = output else { return vec![at_once("()")] };
    let syn::Type::Path(path) = &**declared else { return Vec::new() };
    let Some(last) = path.path.segments.last() else { return Vec::new() };
    match last.ident.to_string().as_str() {
        "bool" => vec![at_once("true"), at_once("false")],
        "Option" => vec![at_once("None")],
        "Vec" => vec![at_once("Vec::new()")],
        "u8" | "u16" | "u32" | "u64" | "i32" | "i64" | "usize" => vec![at_once("0"), at_once("1")],
        "Result" if is_unit_result(&last.arguments) => vec![at_once("Ok(())")],
        _ => Vec::new(),
    }
}

fn is_unit_result(arguments: &syn::PathArguments) -> bool {
    let syn::PathArguments::AngleBracketed(arguments) = arguments else { return false };
    let first = arguments.args.first();
    matches!(first, Some(syn::GenericArgument::Type(syn::Type::Tuple(tuple))) if tuple.elems.is_empty())
}

/// The counterpart of a method with the same types.
pub fn other_method(name: &str) -> Option<&'static str> {
    const PAIRS: [(&str, &str); 12] = [
        ("min", "max"),
        ("any", "all"),
        ("is_some", "is_none"),
        ("is_ok", "is_err"),
        ("is_some_and", "is_none_or"),
        ("push_back", "push_front"),
        ("pop_back", "pop_front"),
        ("wrapping_add", "wrapping_sub"),
        ("saturating_add", "saturating_sub"),
        ("checked_add", "checked_sub"),
        ("take", "skip"),
        ("first", "last"),
    ];
    let other = |&(one, other): &(&'static str, &'static str)| {
        if name == one {
            Some(other)
        } else if name == other {
            Some(one)
        } else {
            None
        }
    };
    PAIRS.iter().find_map(other)
}

/// Whether [`of_operator`] or the mutants of a negation change this condition already.
pub fn is_operation(condition: &Expr) -> bool {
    matches!(condition, Expr::Binary(_) | Expr::Unary(_) | Expr::Macro(_))
}

/// Whether a statement can be left out and the rest still compiles.
pub fn is_deletable(expression: &Expr) -> bool {
    match expression {
        Expr::MethodCall(_) | Expr::Call(_) | Expr::Assign(_) | Expr::Try(_) => true,
        Expr::Binary(binary) => matches!(
            binary.op,
            BinOp::AddAssign(_)
                | BinOp::SubAssign(_)
                | BinOp::BitOrAssign(_)
                | BinOp::BitAndAssign(_)
                | BinOp::BitXorAssign(_)
        ),
        _ => false,
    }
}
