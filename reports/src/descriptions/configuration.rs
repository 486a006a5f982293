//! The differences between two configurations, or between a configuration and a device.

use super::difference::json::content;
use crate::document::{Block, Cell, Depth, Document, Report, Row, Section, Table, Tone};
use crate::escape::JsonText;
use crate::page_text::{counted, none_or_counted};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::difference::Fact;
use canvass_analyzer::dictionary::{DataClass, DataType, Setting, Value as Content};
use canvass_traces::hex;
use serde_json::{Value, json};
use std::io::{self, Write};

/// The name and version of the contract.
const SCHEMA: &str = "canvass/dcf-diff/1";

/// Two configurations, compared setting by setting.
#[derive(Clone, Debug)]
pub struct ComparedConfigurations {
    /// The name of the first configuration, as the user gave it.
    pub one: String,
    /// The name of the second one: a file, or `node 5 on can0`.
    pub other: String,
    /// The number of compared settings.
    pub settings: usize,
    /// The settings whose values differ, by index.
    pub differences: Vec<DifferingSetting>,
}

/// A setting with two values.
#[derive(Clone, Debug)]
pub struct DifferingSetting {
    /// The entry.
    pub at: Multiplexer,
    /// The name of the entry; empty if it is unknown.
    pub name: String,
    /// The data type of the entry, if it is known.
    pub data_type: Option<DataType>,
    /// The value in the first configuration; `None` if it has none.
    pub one: Option<Vec<u8>>,
    /// The value in the second configuration.
    pub other: SideOfSetting,
}

/// The second side of a differing setting.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum SideOfSetting {
    /// A value.
    Value(Vec<u8>),
    /// No value.
    Nothing,
    /// The device answered the request for the value otherwise: an abort, or nothing.
    Answer(String),
}

impl DifferingSetting {
    fn value(&self, bytes: &[u8]) -> Option<Content> {
        Content::decode(self.data_type?, bytes).ok()
    }

    /// `1000`, `385 (181h)`, `"name"`; bytes in hexadecimal if the data type is unknown.
    fn told(&self, bytes: &[u8]) -> String {
        let value = self.value(bytes);
        match (&value, self.data_type.and_then(DataType::class)) {
            (Some(Content::Unsigned(number)), Some(DataClass::Unsigned)) if *number > 9 => {
                format!("{number} ({number:X}h)")
            }
            (Some(value), _) => value.to_string(),
            (None, _) if bytes.is_empty() => "no bytes".to_owned(),
            (None, _) => hex::spaced(bytes).to_string(),
        }
    }

    fn sides(&self) -> [String; 2] {
        let one = self.one.as_ref().map_or_else(String::new, |bytes| self.told(bytes));
        let other = match &self.other {
            SideOfSetting::Value(bytes) => self.told(bytes),
            SideOfSetting::Nothing => String::new(),
            SideOfSetting::Answer(answer) => answer.clone(),
        };
        [one, other]
    }

    fn document(&self) -> Value {
        let side = |bytes: &[u8]| {
            let value = self.value(bytes).map(|value| content(&Fact::Setting(Setting::Fixed(value))));
            json!({ "data": hex::compact(bytes).to_string(), "value": value })
        };
        let other = match &self.other {
            SideOfSetting::Value(bytes) => side(bytes),
            SideOfSetting::Nothing => Value::Null,
            SideOfSetting::Answer(answer) => json!({ "answer": answer }),
        };
        json!({
            "index": self.at.index.0,
            "sub": self.at.sub.0,
            "name": self.name,
            "one": self.one.as_ref().map(|bytes| side(bytes)),
            "other": other,
        })
    }
}

impl Report for ComparedConfigurations {
    fn document(&self, depth: Depth) -> Document {
        let differences = none_or_counted(self.differences.len(), "difference");
        let summary = format!("{} compared, {differences}", counted(self.settings, "setting"));
        let (title, outcome) = match depth {
            Depth::Screen => (String::new(), format!("{} and {}: {summary}", self.one, self.other)),
            Depth::Paper | Depth::Print | Depth::Page => (format!("{} and {}", self.one, self.other), summary),
        };
        let row = |differing: &DifferingSetting| {
            let [one, other] = differing.sides();
            let object = format!("{} {}", differing.at, differing.name).trim_end().to_owned();
            Row::of([object.into(), one.into(), Cell { tone: Tone::Doubt, ..other.into() }])
        };
        let mut table = Table::of(["setting", &self.one, &self.other], self.differences.iter().map(row));
        table.is_framed = depth == Depth::Screen;
        let is_any = !self.differences.is_empty();
        let section = Section { id: "", title: String::new(), blocks: vec![Block::Table(table)] };
        Document {
            command: "dcf diff",
            kind: "CANopen configurations",
            title,
            outcome,
            sections: if is_any { vec![section] } else { Vec::new() },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        let document = json!({
            "schema": SCHEMA,
            "one": self.one,
            "other": self.other,
            "settings": self.settings,
            "differences": self.differences.iter().map(DifferingSetting::document).collect::<Vec<_>>(),
        });
        writeln!(JsonText(out), "{document:#}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Form, Style};

    fn written(form: Form) -> String {
        let differing = |sub, data_type, one: Option<&[u8]>, other| DifferingSetting {
            at: Multiplexer::new(0x1800, sub),
            name: "a\x07b".to_owned(),
            data_type,
            one: one.map(<[u8]>::to_vec),
            other,
        };
        let differences = vec![
            differing(
                1,
                Some(DataType::UNSIGNED32),
                Some(&[0x81, 1, 0, 0x40]),
                SideOfSetting::Value(vec![0x82, 1, 0, 0x40]),
            ),
            differing(2, None, Some(&[1, 2]), SideOfSetting::Answer("abort 0602 0000h".to_owned())),
            differing(3, Some(DataType::UNSIGNED8), None, SideOfSetting::Value(vec![7])),
        ];
        let (one, other) = ("x.dcf".to_owned(), "node 5 on can0".to_owned());
        let compared = ComparedConfigurations { one, other, settings: 12, differences };
        let mut out = Vec::new();
        compared.write(form, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn both_values_are_told() {
        let text = written(Form::Text(Style::default()));
        assert!(text.contains("1073742209 (40000181h)") && text.contains("1073742210 (40000182h)"), "{text}");
        assert!(text.contains("01 02") && text.contains("abort 0602 0000h") && !text.contains('\x07'), "{text}");
        assert!(text.contains("x.dcf and node 5 on can0: 12 settings compared, 3 differences"), "{text}");
    }

    #[test]
    fn programs_get_numbers_and_bytes() {
        let json: Value = serde_json::from_str(&written(Form::Json)).unwrap();
        assert_eq!((&json["schema"], &json["settings"]), (&SCHEMA.into(), &12.into()));
        let first = &json["differences"][0];
        assert_eq!((&first["index"], &first["one"]["value"]), (&0x1800.into(), &0x4000_0181_u32.into()));
        assert_eq!(first["one"]["data"], "81010040");
        assert_eq!(json["differences"][1]["other"]["answer"], "abort 0602 0000h");
        assert_eq!(json["differences"][2]["one"], Value::Null);
    }
}
