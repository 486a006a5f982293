//! Random descriptions without any fault: with PDOs of both directions, dummy entries, the short form, links, modules,
//! objects of an encoder and every kind of data type.

use crate::dice::Dice;
use std::fmt::Write;

/// The integer types: index, bits, whether the type is signed.
pub const INTEGERS: [(u16, u32, bool); 8] = [
    (2, 8, true),
    (3, 16, true),
    (4, 32, true),
    (0x15, 64, true),
    (5, 8, false),
    (6, 16, false),
    (7, 32, false),
    (0x1B, 64, false),
];

struct Writer<'d> {
    text: String,
    dice: &'d mut Dice,
    indexes: Vec<u16>,
    /// The objects that PDOs can carry: index, sub-index, bits.
    tpdo: Vec<(u16, u8, u32)>,
    rpdo: Vec<(u16, u8, u32)>,
}

/// The description of a device type, or of a configured device. The name of the file is `example.eds`.
pub fn right(dice: &mut Dice, is_configuration: bool) -> String {
    let (rpdos, tpdos) = (dice.between(2, 4) as u16, dice.between(2, 4) as u16);
    let mut writer = Writer { text: String::new(), dice, indexes: Vec::new(), tpdo: Vec::new(), rpdo: Vec::new() };
    let identity = [1, 2, 3].map(|_| writer.dice.between(1, u64::from(u32::MAX)));
    writer.communication(identity);
    writer.encoder();
    writer.manufacturer();
    for (count, communication, mapping, is_tpdo) in [(rpdos, 0x1400, 0x1600, false), (tpdos, 0x1800, 0x1A00, true)] {
        for number in 0..count {
            writer.pdo(communication + number, is_tpdo);
            writer.mapping(mapping + number, is_tpdo, number == 0);
        }
    }
    let mut text = head(writer.dice, identity, rpdos, tpdos);
    writer.lists(&mut text);
    if is_configuration {
        let rate = writer.dice.of(&[10, 20, 50, 100, 125, 250, 500, 800, 1000]);
        let node_id = writer.dice.between(1, 127);
        let _ = write!(text, "[DeviceComissioning]\nNodeID={node_id}\nNodeName=drive\nBaudrate={rate}\n\n");
    }
    text + &writer.text + MODULES
}

const MODULES: &str = "[SupportedModules]\nNrOfEntries=2\n\n[M1ModuleInfo]\nProductName=Inputs\nProductVersion=1\n\
    ProductRevision=2\nOrderCode=I8\n\n[M1SubExtends]\nNrOfEntries=1\n1=0x5F00\n\n[M1SubExt5F00]\nParameterName=Input\n\
    ObjectType=0x7\nDataType=0x0005\nAccessType=ro\nPDOMapping=0\nCount=2\nObjExtend=0\n\n[M2ModuleInfo]\n\
    ProductName=Outputs\nProductVersion=1\nProductRevision=3\nOrderCode=O8\n";

fn head(dice: &mut Dice, [vendor, product, revision]: [u64; 3], rpdos: u16, tpdos: u16) -> String {
    let (month, day) = (dice.between(1, 12), dice.between(1, 28));
    let mut text = format!(
        "[FileInfo]\nFileName=example.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\nDescription=Made by chance\n\
         CreationTime=09:00AM\nCreationDate={month:02}-{day:02}-2026\nCreatedBy=chance\nModificationTime=4:49PM\n\
         ModificationDate=12-31-2026\nModifiedBy=chance\n\n[DeviceInfo]\nVendorName=Vendor\nVendorNumber={vendor}\n\
         ProductName=Product\nProductNumber=0x{product:X}\nRevisionNumber={revision}\nOrderCode=A-7\n"
    );
    // Writing to a string can't fail.
    for rate in [10, 20, 50, 100, 125, 250, 500, 800] {
        let _ = writeln!(text, "BaudRate_{rate}={}", u8::from(dice.heads()));
    }
    let _ = write!(
        text,
        "BaudRate_1000=1\nSimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\nDynamicChannelsSupported=0\n\
         CompactPDO=0\nGroupMessaging=0\nNrOfRXPDO={rpdos}\nNrOfTXPDO={tpdos}\nLSS_Supported=1\n\n[DummyUsage]\n\
         Dummy0001=0\nDummy0002=0\nDummy0005=1\nDummy0006={}\nDummy0007=0\n\n",
        u8::from(dice.heads())
    );
    let lines = dice.between(1, 5);
    let _ = writeln!(text, "[Comments]\nLines={lines}");
    for line in 1..=lines {
        let _ = writeln!(text, "Line{line}=A comment of some length, number {line}");
    }
    text + "\n; What follows are the lists.\n"
}

impl Writer<'_> {
    fn lists(&self, text: &mut String) {
        let list = |index: u16| match index {
            0x1000 | 0x1001 | 0x1018 => 0,
            0x2000..=0x5FFF => 2,
            _ => 1,
        };
        for (number, name) in ["MandatoryObjects", "OptionalObjects", "ManufacturerObjects"].iter().enumerate() {
            let listed: Vec<u16> = self.indexes.iter().copied().filter(|&index| list(index) == number).collect();
            let _ = writeln!(text, "[{name}]\nSupportedObjects={}", listed.len());
            for (position, index) in (1..).zip(listed) {
                let _ = writeln!(text, "{position}=0x{index:04X}");
            }
            text.push('\n');
        }
    }

    fn section(&mut self, name: &str, fields: &[(&str, String)]) {
        let _ = writeln!(self.text, "[{name}]");
        for (field, value) in fields {
            let _ = writeln!(self.text, "{field}={value}");
        }
        self.text.push('\n');
    }

    /// The section of a value. `more` has default and limits, as written in the file.
    fn entry(&mut self, name: &str, data_type: u16, access: &str, mappable: bool, more: &[(&str, String)]) {
        let mut fields = vec![
            ("ParameterName", format!("Value {name}")),
            ("ObjectType", "0x7".to_owned()),
            ("DataType", format!("0x{data_type:04X}")),
            ("AccessType", access.to_owned()),
        ];
        fields.extend(more.iter().cloned());
        fields.push(("PDOMapping", u8::from(mappable).to_string()));
        self.section(name, &fields);
    }

    fn variable(&mut self, index: u16, data_type: u16, access: &str, default: &str) {
        self.indexes.push(index);
        self.entry(&format!("{index:04X}"), data_type, access, false, &[("DefaultValue", default.to_owned())]);
    }

    /// The section of an array or record, and the section of its sub-index 0.
    fn container(&mut self, index: u16, code: u8, subs: u8, access: &str, count: u8) {
        self.indexes.push(index);
        let name = format!("{index:04X}");
        let fields = [
            ("ParameterName", format!("Values {name}")),
            ("ObjectType", format!("0x{code}")),
            ("SubNumber", (subs + 1).to_string()),
        ];
        self.section(&name, &fields);
        self.entry(&format!("{name}sub0"), 5, access, false, &[("DefaultValue", count.to_string())]);
    }

    fn communication(&mut self, identity: [u64; 3]) {
        let kind = if self.dice.heads() { "0x00020196" } else { "0x00010196" };
        self.variable(0x1000, 7, "ro", kind);
        self.variable(0x1001, 5, "ro", "0");
        self.variable(0x1005, 7, "rw", "0x80");
        self.variable(0x1006, 7, "rw", "0");
        self.variable(0x1007, 7, "rw", "0");
        self.variable(0x1008, 9, "const", "Encoder by chance");
        self.variable(0x100C, 6, "rw", "0");
        self.variable(0x100D, 5, "rw", "0");
        for index in [0x1010, 0x1011] {
            self.container(index, 8, 1, "ro", 1);
            self.entry(&format!("{index:04X}sub1"), 7, "rw", false, &[("DefaultValue", "1".to_owned())]);
        }
        self.variable(0x1012, 7, "rw", "0x100");
        self.variable(0x1014, 7, "rw", "$NODEID+0x80");
        self.variable(0x1015, 6, "rw", "0");
        self.variable(0x1017, 6, "rw", "0");
        self.container(0x1018, 9, 4, "ro", 4);
        for (sub, number) in (1..).zip(identity) {
            self.entry(&format!("1018sub{sub}"), 7, "ro", false, &[("DefaultValue", number.to_string())]);
        }
        self.entry("1018sub4", 7, "ro", false, &[("DefaultValue", String::new())]);
        self.variable(0x1019, 5, "rw", "0");
        self.container(0x1200, 9, 2, "ro", 2);
        for (sub, base) in [(1, 0x600), (2, 0x580)] {
            self.entry(&format!("1200sub{sub}"), 7, "ro", false, &[("DefaultValue", format!("$NODEID+0x{base:X}"))]);
        }
    }

    fn encoder(&mut self) {
        let is_multi_turn = self.text.contains("0x00020196");
        let steps = 1 << self.dice.between(8, 14);
        let turns = if is_multi_turn { 1 << self.dice.between(1, 12) } else { 1 };
        self.variable(0x6000, 6, "rw", "4");
        self.variable(0x6001, 7, "rw", &format!("{steps}"));
        self.variable(0x6002, 7, "rw", &format!("0x{:X}", steps * turns));
        let preset = self.dice.between(0, steps * turns - 1);
        self.variable(0x6003, 7, "rw", &format!("{preset}"));
        let access = self.dice.of(&["ro", "const"]);
        self.variable(0x6501, 7, access, &format!("0x{steps:X}"));
        self.variable(0x6502, 6, access, &format!("{turns}"));
    }

    /// An entry with an integer type and limits. Returns the bits of the type.
    fn integer(&mut self, section: &str, access: &str, mappable: bool) -> u32 {
        let (data_type, bits, is_signed) = self.dice.of(&INTEGERS);
        self.integer_of(section, (data_type, bits, is_signed), access, mappable);
        bits
    }

    fn integer_of(&mut self, section: &str, (data_type, _, is_signed): (u16, u32, bool), access: &str, mappable: bool) {
        let (low, default, high) = (self.dice.between(1, 30), self.dice.between(31, 60), self.dice.between(61, 127));
        let sign = if is_signed && self.dice.heads() { "-" } else { "" };
        let mut more = vec![("LowLimit", format!("{sign}{low}")), ("HighLimit", high.to_string())];
        if self.dice.heads() {
            more[1].1 = format!("0x{high:X}");
        }
        more.push(("DefaultValue", if access == "wo" { String::new() } else { default.to_string() }));
        self.entry(section, data_type, access, mappable, &more);
    }

    fn manufacturer(&mut self) {
        let mut index = 0x2000;
        let more = |dice: &mut Dice, index: &mut u16| *index += dice.between(1, 0x40) as u16;
        more(self.dice, &mut index);
        self.mappable_of(index, INTEGERS[4], "rwr");
        more(self.dice, &mut index);
        self.mappable_of(index, INTEGERS[5], "rwr");
        for access in ["ro", "rww", "rwr", "const", "rww", "rww", "wo", "rww", "rwr", "ro"] {
            more(self.dice, &mut index);
            self.mappable(index, access);
        }
        for (data_type, default) in [(9, "Text of a device"), (0xA, "01 23 AB"), (8, "1.5"), (0x11, "0.25"), (1, "1")] {
            more(self.dice, &mut index);
            self.variable(index, data_type, "rw", default);
        }
        more(self.dice, &mut index);
        self.indexes.push(index);
        let domain = [("ParameterName", "Program".to_owned()), ("ObjectType", "0x2".to_owned())];
        self.section(&format!("{index:04X}"), &[&domain[..], &[("DataType", "0x000F".to_owned())]].concat());
        for code in [8, 9, 8] {
            more(self.dice, &mut index);
            self.container_of_settings(index, code);
        }
        more(self.dice, &mut index);
        self.short_form(index);
    }

    fn mappable(&mut self, index: u16, access: &str) {
        let kind = self.dice.of(&INTEGERS);
        self.mappable_of(index, kind, access);
    }

    fn mappable_of(&mut self, index: u16, kind: (u16, u32, bool), access: &str) {
        self.indexes.push(index);
        self.integer_of(&format!("{index:04X}"), kind, access, true);
        let bits = kind.1;
        if !matches!(access, "wo" | "rww") {
            self.tpdo.push((index, 0, bits));
        }
        if matches!(access, "wo" | "rww") {
            self.rpdo.push((index, 0, bits));
        }
    }

    fn container_of_settings(&mut self, index: u16, code: u8) {
        let subs = self.dice.between(3, 6) as u8;
        self.container(index, code, subs, "ro", subs);
        let kind = self.dice.of(&INTEGERS);
        for sub in 1..=subs {
            let name = format!("{index:04X}sub{sub:X}");
            if code == 8 && self.dice.heads() {
                self.integer_of(&name, kind, "rwr", true);
                self.tpdo.push((index, sub, kind.1));
            } else if code == 8 {
                self.integer_of(&name, kind, "rww", true);
                self.rpdo.push((index, sub, kind.1));
            } else {
                self.integer(&name, "rw", false);
            }
        }
        if self.dice.heads() {
            self.section(
                &format!("{index:04X}ObjectLinks"),
                &[("ObjectLinks", "1".to_owned()), ("1", "0x1018".to_owned())],
            );
        }
    }

    fn short_form(&mut self, index: u16) {
        self.indexes.push(index);
        let count = self.dice.between(3, 9);
        let fields = [
            ("ParameterName", "Level".to_owned()),
            ("ObjectType", "0x8".to_owned()),
            ("CompactSubObj", count.to_string()),
            ("DataType", "0x0006".to_owned()),
            ("AccessType", "rw".to_owned()),
            ("DefaultValue", "7".to_owned()),
            ("PDOMapping", "0".to_owned()),
        ];
        self.section(&format!("{index:04X}"), &fields);
        let two =
            |one: &str, other: &str| [("NrOfEntries", "2".to_owned()), ("1", one.to_owned()), ("3", other.to_owned())];
        self.section(&format!("{index:04X}Name"), &two("First level", "Third level"));
        self.section(&format!("{index:04X}Value"), &two("0x10", "11"));
        self.section(
            &format!("{index:04X}ObjectLinks"),
            &[("ObjectLinks", "1".to_owned()), ("1", "0x1018".to_owned())],
        );
    }

    fn pdo(&mut self, index: u16, is_tpdo: bool) {
        let base = if is_tpdo { 0x180 } else { 0x200 } + 0x100 * (index & 0xF);
        self.container(index, 9, 2, "ro", 2);
        let name = format!("{index:04X}");
        self.entry(&format!("{name}sub1"), 7, "rw", false, &[("DefaultValue", format!("$NODEID+0x{base:X}"))]);
        let kind = self.dice.of(&[0, 1, 240, 254, 255]);
        self.entry(&format!("{name}sub2"), 5, "rw", false, &[("DefaultValue", kind.to_string())]);
    }

    /// Eight mapping entries, of which some are in use. The first RPDO skips a byte; the first TPDO has a byte and a
    /// word.
    fn mapping(&mut self, index: u16, is_tpdo: bool, is_first: bool) {
        let mut mapped = Vec::new();
        let mut left = 64;
        if is_first && !is_tpdo {
            mapped.push(0x0005_0008);
            left -= 8;
        }
        if is_first && is_tpdo {
            // The byte and the word of the first TPDO.
            for &(target, sub, bits) in self.tpdo.iter().take(2) {
                mapped.push(entry(target, sub, bits));
                left -= bits;
            }
        }
        for _ in 0..self.dice.between(1, 4) {
            let all = if is_tpdo { &self.tpdo } else { &self.rpdo };
            let fit: Vec<_> = all.iter().copied().filter(|&(.., bits)| bits <= left).collect();
            let Some((target, sub, bits)) = self.dice.pick(&fit) else { break };
            left -= bits;
            mapped.push(entry(target, sub, bits));
        }
        self.container(index, 9, 8, "rw", mapped.len() as u8);
        for sub in 1..=8 {
            let value = mapped.get(sub - 1).copied().unwrap_or(0);
            let default = [("DefaultValue", format!("0x{value:08X}"))];
            self.entry(&format!("{index:04X}sub{sub}"), 7, "rw", false, &default);
        }
    }
}

/// An entry of a mapping.
fn entry(index: u16, sub: u8, bits: u32) -> u32 {
    u32::from(index) << 16 | u32::from(sub) << 8 | bits
}
