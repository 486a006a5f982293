//! The shown description in each form.

use super::{Shown, Style, picture};
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::dictionary::layout::PdoField;
use canvass_analyzer::wire::pdo::MappingEntry;
use canvass_analyzer::{Index, Multiplexer, NodeId};
use proptest::prelude::*;

const EDS: &str = "[DeviceInfo]\nProductName=Encoder <b>\nVendorName=Vendor\n[1800]\nParameterName=TPDO\nObjectType=9\nSubNumber=3\n\
    [1800sub0]\nParameterName=Highest\nDataType=5\nAccessType=const\nDefaultValue=2\n\
    [1800sub1]\nParameterName=COB-ID\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x40000180\n\
    [1800sub2]\nParameterName=Type\nDataType=5\nAccessType=rw\nDefaultValue=1\n\
    [1A00]\nParameterName=Mapping\nObjectType=9\nSubNumber=3\n\
    [1A00sub0]\nParameterName=Count\nDataType=5\nAccessType=rw\nDefaultValue=2\n\
    [1A00sub1]\nParameterName=First\nDataType=7\nAccessType=rw\nDefaultValue=0x20000001\n\
    [1A00sub2]\nParameterName=Second\nDataType=7\nAccessType=rw\nDefaultValue=0x20010010\n\
    [2000]\nParameterName=Door\nObjectType=7\nDataType=1\nAccessType=ro\nPDOMapping=1\n\
    [2001]\nParameterName=\x1b[31m<script>a|b\nObjectType=7\nDataType=6\nAccessType=rw\nPDOMapping=1\nLowLimit=1\nHighLimit=9\n\
    DefaultValue=5\n";
const STYLE: Style = Style { colors: false, width: 80 };

fn shown(only: Option<u16>, node: Option<NodeId>) -> Shown {
    let description = DeviceDescription::read(EDS.as_bytes()).unwrap();
    Shown { file: "x.eds".to_owned(), description, node, only: only.map(Index) }
}

#[test]
fn text_has_a_row_for_each_entry_and_a_picture_for_each_pdo() {
    let text = shown(None, None).text(Style { width: 160, ..STYLE });
    assert!(text.starts_with("Encoder <b>, Vendor\nx.eds: 4 objects\n\n"), "{text}");
    let row = |start: &str| {
        let line = text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {text}"));
        line.split(['│', '┆']).map(str::trim).filter(|cell| !cell.is_empty()).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(row("│ 2000h"), "2000h; Door; BOOLEAN; ro; TPDO");
    let hostile = row("│ 2001h");
    assert!(hostile.ends_with("<script>a|b; UNSIGNED16; rw; RPDO, TPDO; 5; 1 to 9"), "{hostile}");
    assert_eq!(row("│ 1800h"), "1800h; TPDO; RECORD");
    assert_eq!(row("│    :01"), ":01; COB-ID; UNSIGNED32; rw; $NODEID+40000180h");
    assert!(text.contains("┆ 2001h:00 (16 bits) ┆"), "{text}");
    let pdo = "\nTPDO 1: 17 bits, CAN-ID $NODEID+180h, no remote frames\n  transmission type 1 (at SYNC)\n  \
               byte 0       1       2\n       AB──────────────┤.......\n  A    bit 0          2000h:00 Door, BOOLEAN\n  \
               B    bits 1 to 16   2001h:00 ";
    assert!(text.contains(pdo), "{text}");
}

/// The table has the beginning of a very long value, the details of its object the whole.
#[test]
fn a_very_long_value_is_cut_in_the_table() {
    let long = "x".repeat(400_000);
    let eds =
        format!("{EDS}[2002]\nParameterName=Text\nObjectType=7\nDataType=9\nAccessType=ro\nDefaultValue={long}\n");
    let of = |only: Option<u16>| {
        let description = DeviceDescription::read(eds.as_bytes()).unwrap();
        Shown { file: "x.eds".to_owned(), description, node: None, only: only.map(Index) }.text(STYLE)
    };
    let whole = of(None);
    let squeezed: String = whole.chars().filter(|c| !c.is_whitespace() && !"│┆".contains(*c)).collect();
    assert!(squeezed.contains("…(400002characters)") && whole.len() < 40_000, "{}", whole.len());
    assert!(of(Some(0x2002)).contains(&long));
}

#[test]
fn one_object_is_shown_in_detail() {
    let text = shown(Some(0x1800), NodeId::new(5)).text(STYLE);
    let expected = "1800h TPDO: RECORD\n  CiA 301 7.5.2.37: TPDO communication parameter, RECORD\n  x.eds, line 4\n";
    assert!(text.starts_with(expected), "{text}");
    let cob_id = "  1800h:01 COB-ID\n    type       UNSIGNED32, 32 bits\n    access     rw\n    PDO        can't be mapped\n    \
                  default    40000185h\n    standard   CiA 301 7.5.2.37: TPDO communication parameter 1, COB-ID used by TPDO\n";
    assert!(text.contains(cob_id), "{text}");
    assert!(text.contains("TPDO 1: 17 bits, CAN-ID 185h"), "{text}");
    let carried = shown(Some(0x2000), None).text(STYLE);
    assert!(carried.contains("TPDO 1: ") && carried.contains("    PDO        TPDO\n"), "{carried}");
}

#[test]
fn texts_of_files_do_not_act() {
    let one = shown(None, None);
    let mut page = Vec::new();
    one.html(&mut page).unwrap();
    let page = String::from_utf8(page).unwrap();
    for text in [one.text(STYLE), one.markdown(), one.json().to_string(), page.clone()] {
        assert!(!text.contains('\x1b'), "{text}");
    }
    assert!(!page.contains("<script>a") && page.contains("&lt;script&gt;a|b"), "{page}");
    assert!(page.contains("<tbody id=\"o2001\">") && page.contains("href=\"#o2001\""), "{page}");
    assert!(one.markdown().contains("a\\|b"), "{}", one.markdown());
}

#[test]
fn a_page_needs_nothing_else() {
    let mut page = Vec::new();
    shown(None, None).html(&mut page).unwrap();
    let page = String::from_utf8(page).unwrap();
    for part in ["default-src 'none'", "id=\"filter\"", "<svg class=\"layout\"", "byte 2", "@media print"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("http://") && !page.contains("https://") && !page.contains(" style=\""), "{page}");
}

#[test]
fn json_has_numbers_as_numbers() {
    let json = shown(None, None).json();
    assert_eq!(json["schema"], "canvass/eds-show/1");
    let entry = &json["objects"][3]["entries"][0];
    assert_eq!((&entry["default"], &entry["high_limit"], &entry["rpdo"]), (&5.into(), &9.into(), &true.into()));
    let pdo = &json["pdos"][0];
    assert_eq!((&pdo["bits"], &pdo["fields"][1]["offset"]), (&17.into(), &1.into()));
    assert_eq!(pdo["cob_id"], "$NODEID+0x40000180");
    assert_eq!(shown(None, NodeId::new(5)).json()["pdos"][0]["cob_id"], 0x4000_0185);
}

proptest! {
    /// Each bit of the picture belongs to its field, and no line is wider than a page.
    #[test]
    fn a_picture_has_each_bit_in_its_place(lengths in proptest::collection::vec(0u8..=64, 0..64)) {
        let mut offset = 0;
        let fields: Vec<PdoField<'_>> = lengths.iter().map(|&bits| {
            let field = PdoField { mapped: MappingEntry::new(Multiplexer::new(0x2000, 0), bits), offset, entry: None };
            offset = field.end();
            field
        }).collect();
        let lines = picture::lines(&fields);
        prop_assert!(lines.iter().all(|line| line.chars().count() <= 5 + 64));
        let drawn: Vec<char> = lines[1].chars().skip(5).collect();
        for (number, field) in fields.iter().enumerate().filter(|(_, field)| field.mapped.bits() > 0 && field.end() <= 64) {
            prop_assert_eq!(drawn[field.offset as usize], picture::letter(number));
            let inner = &drawn[field.offset as usize + 1..field.end() as usize];
            prop_assert!(inner.iter().all(|bit| matches!(bit, '─' | '┤')));
        }
        prop_assert!(drawn.iter().skip(offset as usize).all(|&bit| bit == '.'));
    }
}
