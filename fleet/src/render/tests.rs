use super::*;
use datafusion::arrow::array::{BinaryArray, StringArray, TimestampNanosecondArray};
use datafusion::arrow::datatypes::{Field, Schema};
use std::sync::Arc;

#[path = "../../tests/fleet/sink.rs"]
mod sink;
use sink::Shared;

fn hostile() -> RecordBatch {
    let columns: Vec<(&str, datafusion::arrow::array::ArrayRef)> = vec![
        (
            "t",
            Arc::new(TimestampNanosecondArray::from(vec![Some(1_738_061_235_000_000_001), None]).with_timezone("UTC")),
        ),
        ("data", Arc::new(BinaryArray::from(vec![Some(&[0xAB_u8, 1][..]), None]))),
        ("text", Arc::new(StringArray::from(vec![Some("=1+1\u{1b}[31m\u{202e}"), None]))),
    ];
    let fields: Vec<Field> =
        columns.iter().map(|(name, column)| Field::new(*name, column.data_type().clone(), true)).collect();
    let columns = columns.into_iter().map(|(_, column)| column).collect();
    RecordBatch::try_new(Arc::new(Schema::new(fields)), columns).unwrap()
}

fn rendered(format: Format) -> Vec<u8> {
    let (batch, out) = (hostile(), Shared::default());
    let mut answer = answer(format, &batch.schema(), Box::new(out.clone())).unwrap();
    answer.batch(&batch).unwrap();
    answer.finish().unwrap();
    out.0.lock().unwrap().clone()
}

#[test]
fn nothing_acts_in_texts() {
    for format in [Format::Table, Format::Json, Format::Csv] {
        let text = String::from_utf8(rendered(format)).unwrap();
        assert!(!text.contains(['\u{1b}', '\u{202e}']), "{text}");
    }
    assert!(String::from_utf8(rendered(Format::Csv)).unwrap().contains("'=1+1"));
}

#[test]
fn json_has_integer_nanoseconds_and_hexadecimal_digits() {
    let text = String::from_utf8(rendered(Format::Json)).unwrap();
    let rows: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((&rows[0]["t"], &rows[0]["data"]), (&1_738_061_235_000_000_001_i64.into(), &"AB01".into()));
    assert!(rows[1]["t"].is_null() && rows[1]["text"].is_null());
}

#[test]
fn other_programs_read_it_back() {
    let stream = rendered(Format::Arrow);
    let reader = datafusion::arrow::ipc::reader::StreamReader::try_new(&stream[..], None).unwrap();
    assert_eq!(reader.map(|batch| batch.unwrap()).collect::<Vec<_>>(), [hostile()]);
    let parquet = bytes::Bytes::from(rendered(Format::Parquet));
    let reader = datafusion::parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(parquet).unwrap();
    assert_eq!(reader.build().unwrap().map(|batch| batch.unwrap()).collect::<Vec<_>>(), [hostile()]);
}
