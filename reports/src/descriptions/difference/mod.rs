//! The differences between two device descriptions, in all output forms.

pub(super) mod json;
mod report;

use canvass_analyzer::dictionary::difference::{ChangeKind, Class, Difference, Fact};

/// The differences between two files.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The name of the old file, as the user gave it.
    pub old: String,
    /// The name of the new file, as the user gave it.
    pub new: String,
    /// The differences, in the order of the description.
    pub differences: Vec<Difference>,
}

impl Compared {
    /// Whether there is a difference of this class or a graver one.
    pub fn has(&self, least: Class) -> bool {
        self.differences.iter().any(|difference| difference.kind.class >= least)
    }

    fn count(&self, class: Class) -> usize {
        self.differences.iter().filter(|difference| difference.kind.class == class).count()
    }

    /// The number of differences by class: `2 breaking, no notable, 1 harmless`.
    fn counts(&self) -> String {
        let counts = Class::ALL.map(|class| match self.count(class) {
            0 => format!("no {class}"),
            count => format!("{count} {class}"),
        });
        counts.join(", ")
    }

    /// The differences by kind, the gravest first. Kinds of the same class keep their order.
    fn by_kind(&self) -> Vec<(&'static ChangeKind, Vec<&Difference>)> {
        let mut kinds: Vec<(&'static ChangeKind, Vec<&Difference>)> = Vec::new();
        for difference in &self.differences {
            match kinds.iter_mut().find(|(kind, _)| *kind == difference.kind) {
                Some((_, same)) => same.push(difference),
                None => kinds.push((difference.kind, vec![difference])),
            }
        }
        kinds.sort_by_key(|(kind, _)| std::cmp::Reverse(kind.class));
        kinds
    }
}

/// The object of a difference: `6004h:00 Position value`.
fn subject(difference: &Difference) -> String {
    format!("{} {}", difference.subject, difference.name).trim_end().to_owned()
}

/// The content of a description's fact in words.
fn fact(fact: Option<&Fact>) -> String {
    fact.map_or_else(|| "nothing".to_owned(), ToString::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Form, Report, Style};
    use canvass_analyzer::dictionary::DeviceDescription;
    use canvass_analyzer::dictionary::difference::compare;

    const OLD: &str = "[DeviceInfo]\nNrOfTXPDO=0\nBaudRate_125=1\n[2000]\nParameterName=Set\nDataType=5\nAccessType=rw\n\
                       DefaultValue=5\n[2001]\nParameterName=a|b\x1b[31m\nDataType=0x7\nAccessType=rw\n\
                       DefaultValue=0x12345678\n";

    fn compared(from: &str, to: &str) -> Compared {
        let read = |text: &str| DeviceDescription::read(text.as_bytes()).unwrap();
        let differences = compare(&read(OLD), &read(&OLD.replacen(from, to, 1)));
        Compared { old: "old.eds".to_owned(), new: "new.eds".to_owned(), differences }
    }

    const TEXT: Form = Form::Text(Style { color: false, width: None });
    const PAINTED: Form = Form::Text(Style { color: true, width: None });

    fn written(compared: &Compared, form: Form) -> String {
        let mut out = Vec::new();
        compared.write(form, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn text_tells_each_kind_once() {
        let both =
            compared("DataType=5\nAccessType=rw\nDefaultValue=5\n", "DataType=6\nAccessType=ro\nDefaultValue=5\n");
        let expected = "breaking  the data type has changed  [entry/data-type]\n  \
            2000h:00 Set: UNSIGNED8 -> UNSIGNED16\n  \
            = Values and mappings of the old length are refused (abort 0607 0010h). With the same length, the same \
            bytes now mean another value.\n\n\
            breaking  the entry can't be written any more  [entry/not-writable]\n  \
            2000h:00 Set: rw -> ro\n  \
            = A DCF that sets it can't be downloaded completely: the device answers with abort 0601 0002h.\n\n";
        let text = written(&both, TEXT);
        assert!(text.starts_with(expected), "{text}");
        assert!(text.ends_with("old.eds -> new.eds: 2 breaking, 1 notable, no harmless\n"), "{text}");
        assert!(
            written(&both, PAINTED)
                .starts_with("\x1b[31mbreaking\x1b[0m  the data type has changed  [entry/data-type]")
        );
        assert!(both.has(Class::Breaking));
    }

    #[test]
    fn what_is_the_same_is_said_to_be() {
        let same = compared("5", "5");
        assert_eq!(written(&same, TEXT), "old.eds -> new.eds: no difference\n");
        assert!(written(&same, Form::Markdown).contains(": no difference."));
        assert!(!same.has(Class::Harmless));
    }

    #[test]
    fn texts_of_files_do_not_act() {
        let hostile = compared("[2001]\nParameterName=a|b\x1b[31m", "[2001]\nParameterName=c|d\x1b]0;x\x07");
        for text in [TEXT, Form::Markdown, Form::Json].map(|form| written(&hostile, form)) {
            assert!(!text.contains(['\x1b', '\x07']), "{text}");
        }
        assert!(written(&hostile, Form::Markdown).contains("c\\|d"), "{}", written(&hostile, Form::Markdown));
    }

    #[test]
    fn json_has_numbers_as_numbers() {
        let json = written(&compared("DefaultValue=0x12345678", "DefaultValue=$NODEID+1"), Form::Json);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let one = &json["differences"][0];
        assert_eq!((&one["kind"], &one["class"]), (&"default/changed".into(), &"notable".into()));
        assert_eq!((&one["index"], &one["sub"]), (&0x2001.into(), &0.into()));
        assert_eq!((&one["before"], &one["after"]), (&0x1234_5678.into(), &"$NODEID+0x1".into()));
        assert_eq!(json["summary"], serde_json::json!({ "breaking": 0, "notable": 2, "harmless": 0 }));
    }
}
