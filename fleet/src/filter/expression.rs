//! Converts SQL expressions to tests. The query engine evaluates all expressions that are no conjunction of tests.

use super::{Condition, Test};
use datafusion::arrow::datatypes::{DataType, Schema, TimeUnit};
use datafusion::common::ScalarValue;
use datafusion::logical_expr::expr::InList;
use datafusion::logical_expr::{BinaryExpr, Expr, Operator};

/// The tests that together are equivalent to the expression; `None` if the expression is no conjunction of tests.
pub fn tests_of(expression: &Expr, schema: &Schema) -> Option<Vec<Test>> {
    if let Expr::BinaryExpr(BinaryExpr { left, op: Operator::And, right }) = expression {
        let mut tests = tests_of(left, schema)?;
        tests.extend(tests_of(right, schema)?);
        return Some(tests);
    }
    single(expression, schema).map(|test| vec![test])
}

fn single(expression: &Expr, schema: &Schema) -> Option<Test> {
    match expression {
        Expr::BinaryExpr(BinaryExpr { left, op, right }) => {
            compare(left, *op, right, schema).or_else(|| compare(right, op.swap()?, left, schema))
        }
        Expr::InList(InList { expr, list, negated }) => among(expr, list, *negated, schema),
        Expr::Between(between) => {
            let (column, kind) = column(&between.expr, schema)?;
            let (Value::Number(low), Value::Number(high)) = (value(&between.low, kind)?, value(&between.high, kind)?)
            else {
                return None;
            };
            (!between.negated).then_some(Test { column, condition: Condition::Between(Some(low), Some(high)) })
        }
        Expr::IsNull(inner) => Some(Test { column: column(inner, schema)?.0, condition: Condition::Null }),
        Expr::IsNotNull(inner) => Some(Test { column: column(inner, schema)?.0, condition: Condition::NotNull }),
        Expr::Not(inner) => flag(inner, 0, schema),
        Expr::IsTrue(inner) => flag(inner, 1, schema),
        Expr::IsFalse(inner) => flag(inner, 0, schema),
        Expr::Column(_) => flag(expression, 1, schema),
        _ => None,
    }
}

/// The type as which a column's values are compared.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    Time,
    Flag,
    Text,
}

enum Value {
    Number(i128),
    Text(String),
}

/// The column that an expression names, if tests can compare its values.
fn column(expression: &Expr, schema: &Schema) -> Option<(String, Kind)> {
    let (column, cast) = match expression {
        Expr::Column(column) => (column, None),
        // A cast of a text changes only its representation.
        Expr::Cast(cast) => match &*cast.expr {
            Expr::Column(column) => (column, Some(cast.field.data_type())),
            _ => return None,
        },
        _ => return None,
    };
    let field = schema.field_with_name(&column.name).ok()?;
    let kind = match field.data_type() {
        DataType::UInt8
        | DataType::UInt16
        | DataType::UInt32
        | DataType::UInt64
        | DataType::Int64
        | DataType::Date32 => Kind::Number,
        DataType::Timestamp(TimeUnit::Nanosecond, _) => Kind::Time,
        DataType::Boolean => Kind::Flag,
        DataType::Utf8 | DataType::Dictionary(..) => Kind::Text,
        _ => return None,
    };
    let keeps = |to: &DataType| match kind {
        Kind::Text => {
            matches!(to, DataType::Utf8 | DataType::Utf8View | DataType::LargeUtf8 | DataType::Dictionary(..))
        }
        // A cast to 64 signed bits keeps all numbers but those of 64 unsigned bits.
        Kind::Number => matches!(to, DataType::Int64) && !matches!(field.data_type(), DataType::UInt64),
        Kind::Time | Kind::Flag => false,
    };
    cast.is_none_or(keeps).then(|| (column.name.clone(), kind))
}

/// A literal, as the values of this kind are compared.
fn value(expression: &Expr, kind: Kind) -> Option<Value> {
    let Expr::Literal(scalar, _) = expression else { return None };
    let mut scalar = scalar;
    while let ScalarValue::Dictionary(_, inner) = scalar {
        scalar = inner;
    }
    Some(match (kind, scalar) {
        (Kind::Number, ScalarValue::Int8(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::Int16(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::Int32(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::Int64(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::UInt8(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::UInt16(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::UInt32(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::UInt64(Some(value))) => Value::Number(i128::from(*value)),
        (Kind::Number, ScalarValue::Date32(Some(days))) => Value::Number(i128::from(*days)),
        (Kind::Time, ScalarValue::TimestampNanosecond(Some(value), _)) => Value::Number(i128::from(*value)),
        (Kind::Flag, ScalarValue::Boolean(Some(value))) => Value::Number(i128::from(*value)),
        (
            Kind::Text,
            ScalarValue::Utf8(Some(text)) | ScalarValue::Utf8View(Some(text)) | ScalarValue::LargeUtf8(Some(text)),
        ) => Value::Text(text.clone()),
        _ => return None,
    })
}

fn compare(left: &Expr, operator: Operator, right: &Expr, schema: &Schema) -> Option<Test> {
    let (column, kind) = column(left, schema)?;
    let condition = match (operator, value(right, kind)?) {
        (Operator::Eq, Value::Number(value)) => Condition::OneOf(vec![value]),
        (Operator::NotEq, Value::Number(value)) => Condition::NoneOf(vec![value]),
        (Operator::Eq, Value::Text(text)) => Condition::OneOfTexts(vec![text]),
        (Operator::NotEq, Value::Text(text)) => Condition::NoneOfTexts(vec![text]),
        (Operator::Lt, Value::Number(value)) => Condition::Between(None, Some(value - 1)),
        (Operator::LtEq, Value::Number(value)) => Condition::Between(None, Some(value)),
        (Operator::Gt, Value::Number(value)) => Condition::Between(Some(value + 1), None),
        (Operator::GtEq, Value::Number(value)) => Condition::Between(Some(value), None),
        _ => return None,
    };
    Some(Test { column, condition })
}

fn among(expression: &Expr, list: &[Expr], negated: bool, schema: &Schema) -> Option<Test> {
    let (column, kind) = column(expression, schema)?;
    let (mut numbers, mut texts) = (Vec::new(), Vec::new());
    for item in list {
        match value(item, kind)? {
            Value::Number(number) => numbers.push(number),
            Value::Text(text) => texts.push(text),
        }
    }
    let condition = match (kind, negated) {
        (Kind::Text, false) => Condition::OneOfTexts(texts),
        (Kind::Text, true) => Condition::NoneOfTexts(texts),
        (_, false) => Condition::OneOf(numbers),
        (_, true) => Condition::NoneOf(numbers),
    };
    Some(Test { column, condition })
}

fn flag(expression: &Expr, value: i128, schema: &Schema) -> Option<Test> {
    let (column, kind) = column(expression, schema)?;
    (kind == Kind::Flag).then(|| Test { column, condition: Condition::OneOf(vec![value]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;
    use datafusion::prelude::{col, lit};

    fn tests(expression: &Expr) -> Option<Vec<Test>> {
        tests_of(expression, &Table::Messages.schema())
    }

    fn one(column: &str, condition: Condition) -> Option<Vec<Test>> {
        Some(vec![Test { column: column.to_owned(), condition }])
    }

    #[test]
    fn comparisons() {
        assert_eq!(tests(&col("node").eq(lit(5_u8))), one("node", Condition::OneOf(vec![5])));
        assert_eq!(tests(&lit(5_u8).lt(col("node"))), one("node", Condition::Between(Some(6), None)));
        assert_eq!(tests(&col("service").eq(lit("sdo"))), one("service", Condition::OneOfTexts(vec!["sdo".into()])));
        assert_eq!(tests(&col("remote")), one("remote", Condition::OneOf(vec![1])));
        assert_eq!(tests(&!col("remote")), one("remote", Condition::OneOf(vec![0])));
        assert_eq!(tests(&col("index").is_null()), one("index", Condition::Null));
        assert_eq!(
            tests(&col("node").in_list(vec![lit(1_u8), lit(2_u8)], true)),
            one("node", Condition::NoneOf(vec![1, 2]))
        );
        let both = col("node").eq(lit(5_u8)).and(col("index").gt_eq(lit(0x6000_u16)));
        assert_eq!(tests(&both).map(|tests| tests.len()), Some(2));
    }

    #[test]
    fn what_is_no_test_stays() {
        assert_eq!(tests(&col("node").eq(lit(5_u8)).or(col("sub").eq(lit(1_u8)))), None);
        assert_eq!(tests(&col("node").eq(col("sub"))), None);
        assert_eq!(tests(&col("service").lt(lit("sdo"))), None);
        assert_eq!(tests(&col("data").is_null()), None);
        assert_eq!(tests(&col("node").eq(lit(ScalarValue::UInt8(None)))), None);
    }
}
