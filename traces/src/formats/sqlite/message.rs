//! The table of messages, and a message in a row of it.

use super::row::Value;
use crate::Record;
use crate::damage::Flaw;
use crate::formats::python_can::Message;

/// The columns of the table, by name.
const COLUMNS: [&str; 7] = ["ts", "arbitration_id", "extended", "remote", "error", "dlc", "data"];

/// The place of each of [`COLUMNS`] in a row.
pub(super) type Places = [usize; COLUMNS.len()];

/// The places of the columns in the SQL that made a table; `None` if it is no table of messages.
pub(super) fn places(sql: &str) -> Option<Places> {
    let (_, columns) = sql.split_once('(')?;
    let names: Vec<&str> = columns
        .trim_end()
        .trim_end_matches([';', ')'])
        .split(',')
        .map(|column| column.split_whitespace().next().unwrap_or_default().trim_matches(['"', '`', '[', ']', '\'']))
        .collect();
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = names.iter().position(|name| name.eq_ignore_ascii_case(column))?;
    }
    Some(places)
}

/// The message in a row.
pub(super) fn message(columns: &[Value<'_>], places: &Places) -> Result<Record, Flaw> {
    let [time, id, extended, remote, error, length, data] = places.map(|place| columns.get(place));
    let integer = |value: Option<&Value<'_>>, name: &str| {
        match value {
            Some(Value::Integer(number)) => u64::try_from(*number).map_err(|_| number.to_string()),
            // Python stores a whole double in a column of integers as such.
            Some(Value::Null) | None => Err("none".to_owned()),
            Some(other) => Err(format!("{other:?}")),
        }
        .map_err(|found| Flaw::malformed(format!("a number in the column {name}"), found))
    };
    let data = match data {
        Some(Value::Blob(data) | Value::Text(data)) => *data,
        Some(Value::Null) => &[],
        other => return Err(Flaw::malformed("bytes in the column data", format!("{other:?}"))),
    };
    let id = integer(id, "arbitration_id")?;
    let message = Message {
        nanos: nanos(time)?,
        id: u32::try_from(id).map_err(|_| Flaw::malformed("an id of at most 29 bits", id.to_string()))?,
        extended: integer(extended, "extended")? != 0,
        remote: integer(remote, "remote")? != 0,
        error: integer(error, "error")? != 0,
        length: integer(length, "dlc")?,
        data,
    };
    message.record().map_err(|wrong| Flaw::malformed(wrong.expected(), format!("{message:?}")))
}

/// The nanoseconds of a time in seconds, rounded to the digits that its double has.
fn nanos(time: Option<&Value<'_>>) -> Result<u64, Flaw> {
    /// Seconds from which a double no longer holds nanoseconds.
    const COARSE: f64 = 4e6;
    let seconds = match time {
        Some(Value::Real(seconds)) => *seconds,
        Some(Value::Integer(seconds)) => *seconds as f64,
        other => return Err(Flaw::malformed("a time in the column ts", format!("{other:?}"))),
    };
    let (digits, unit) = if seconds < COARSE { (seconds * 1e9, 1) } else { (seconds * 1e6, 1_000) };
    // A double that is no time from 1970 on becomes 0 or the largest number.
    let nanos = (digits.round() as u64).checked_mul(unit).filter(|_| digits >= 0.0);
    nanos.ok_or_else(|| Flaw::malformed("a time from 1970 to 2554, in seconds", seconds.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_may_be_in_any_order() {
        let sql = "CREATE TABLE messages (ts REAL, arbitration_id INTEGER, extended INTEGER, remote INTEGER, \
                   error INTEGER, dlc INTEGER, data BLOB)";
        assert_eq!(places(sql), Some([0, 1, 2, 3, 4, 5, 6]));
        let sql = "create table \"x\"(data BLOB, \"ts\" REAL,arbitration_id,extended,remote,error,dlc);";
        assert_eq!(places(sql), Some([1, 2, 3, 4, 5, 6, 0]));
        assert_eq!(places("CREATE TABLE notes (ts REAL, text TEXT)"), None);
        assert_eq!(places("CREATE INDEX"), None);
    }

    #[test]
    fn times_are_rounded_to_their_digits() {
        let nanos = |seconds| nanos(Some(&Value::Real(seconds)));
        assert_eq!(nanos(1_700_000_000.123_456).unwrap(), 1_700_000_000_123_456_000);
        assert_eq!(nanos(12.000_000_001).unwrap(), 12_000_000_001);
        assert!(nanos(-1.0).is_err() && nanos(f64::NAN).is_err() && nanos(1e300).is_err());
    }
}
