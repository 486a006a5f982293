//! The description of a node, as an EDS.

use super::spec::{NodeSpec, PdoSpec};
use canvass_analyzer::dictionary::{KnownDevice, eds};
use std::fmt::Write;

/// The text of an EDS, object by object.
#[derive(Default)]
struct Text {
    objects: Vec<u16>,
    sections: String,
}

/// A list of objects in an EDS: its section, and the indexes that belong to it.
type List = (&'static str, fn(u16) -> bool);

/// The node as its EDS describes it.
pub fn of(node: &NodeSpec) -> Option<KnownDevice> {
    eds::read(text(node).as_bytes()).ok().map(KnownDevice::described)
}

const U8: u8 = 5;
const U16: u8 = 6;
const U32: u8 = 7;
const STRING: u8 = 9;
const DOMAIN: u8 = 15;

/// The EDS of a node.
fn text(node: &NodeSpec) -> String {
    let mut text = Text::default();
    text.variable(0x1000, "Device type", U32, "ro", "0");
    text.variable(0x1001, "Error register", U8, "ro", "0");
    text.variable(0x1005, "COB-ID SYNC", U32, "rw", "0x80");
    text.variable(0x1006, "Communication cycle period", U32, "rw", "0");
    text.variable(0x100C, "Guard time", U16, "rw", "0");
    text.variable(0x100D, "Life time factor", U8, "rw", "0");
    text.variable(0x1014, "COB-ID EMCY", U32, "rw", "$NODEID+0x80");
    text.variable(0x1017, "Producer heartbeat time", U16, "rw", &(node.heartbeat / 1_000_000).to_string());
    text.array(0x1018, "Identity", &[("Vendor-ID", U32, "0x123"), ("Product code", U32, "1")]);
    for pdo in &node.pdos {
        text.pdo(pdo);
    }
    text.variable(0x2010, "Name", STRING, "rw", "");
    text.variable(0x2011, "Program", DOMAIN, "rw", "");
    text.variable(0x2012, "Limit", U32, "rw", "0");
    text.finish()
}

impl Text {
    fn entry(&mut self, section: &str, name: &str, data_type: u8, access: &str, default: &str) {
        let mappable = u8::from(section.starts_with("21") || section.starts_with("22"));
        let _ = write!(
            self.sections,
            "[{section}]\nParameterName={name}\nObjectType=0x7\nDataType=0x{data_type:04X}\nAccessType={access}\n\
             DefaultValue={default}\nPDOMapping={mappable}\n\n"
        );
    }

    fn variable(&mut self, index: u16, name: &str, data_type: u8, access: &str, default: &str) {
        self.objects.push(index);
        self.entry(&format!("{index:04X}"), name, data_type, access, default);
    }

    fn array(&mut self, index: u16, name: &str, subs: &[(&str, u8, &str)]) {
        self.array_of(index, name, &subs.len().to_string(), subs);
    }

    /// An array whose sub-index 0 has this value.
    fn array_of(&mut self, index: u16, name: &str, highest: &str, subs: &[(&str, u8, &str)]) {
        self.objects.push(index);
        let count = subs.len() + 1;
        let _ = write!(self.sections, "[{index:04X}]\nParameterName={name}\nObjectType=0x9\nSubNumber={count}\n\n");
        self.entry(&format!("{index:04X}sub0"), "Highest sub-index supported", U8, "rw", highest);
        for (sub, (name, data_type, default)) in (1..).zip(subs) {
            self.entry(&format!("{index:04X}sub{sub:X}"), name, *data_type, "rw", default);
        }
    }

    fn pdo(&mut self, pdo: &PdoSpec) {
        let can_id = format!("$NODEID+0x{:X}", pdo.can_id(0));
        let transmission_type = pdo.trigger.transmission_type().to_string();
        let timer = pdo.event_timer().to_string();
        let parameters = [
            ("COB-ID", U32, can_id.as_str()),
            ("Transmission type", U8, transmission_type.as_str()),
            ("Inhibit time", U16, "0"),
            ("Reserved", U8, "0"),
            ("Event timer", U16, timer.as_str()),
        ];
        self.array(pdo.communication(), "PDO communication parameter", &parameters);
        let entries: Vec<String> = pdo.entries().iter().map(|entry| format!("0x{entry:08X}")).collect();
        let rows: Vec<_> = entries.iter().map(|entry| ("Mapped object", U32, entry.as_str())).collect();
        // A multiplexed PDO has a number in place of entries.
        match pdo.is_multiplexed {
            true => self.array_of(pdo.mapping(), "PDO mapping parameter", "0xFE", &[]),
            false => self.array(pdo.mapping(), "PDO mapping parameter", &rows),
        }
        let index = (pdo.entries()[0] >> 16) as u16;
        let values: Vec<_> = entries.iter().map(|_| ("Value", U8, "0")).collect();
        self.array(index, "Process data", &values);
    }

    /// The whole EDS.
    fn finish(self) -> String {
        let mut head = "[FileInfo]\nFileName=node.eds\nFileVersion=1\nFileRevision=1\nEDSVersion=4.0\n\n\
             [DeviceInfo]\nVendorName=Matrix\nVendorNumber=0x123\nProductName=Node\nProductNumber=1\n\
             BaudRate_500=1\nSimpleBootUpSlave=1\nGranularity=8\nGroupMessaging=0\nNrOfRXPDO=4\nNrOfTXPDO=4\n\
             LSS_Supported=0\n\n[DummyUsage]\nDummy0001=0\n\n[Comments]\nLines=0\n\n"
            .to_owned();
        let lists: [List; 3] = [
            ("MandatoryObjects", |index| matches!(index, 0x1000 | 0x1001 | 0x1018)),
            ("OptionalObjects", |index| !matches!(index, 0x1000 | 0x1001 | 0x1018 | 0x2000..=0x5FFF)),
            ("ManufacturerObjects", |index| matches!(index, 0x2000..=0x5FFF)),
        ];
        for (name, is_in) in lists {
            let listed: Vec<_> = self.objects.iter().filter(|index| is_in(**index)).collect();
            let _ = writeln!(head, "[{name}]\nSupportedObjects={}", listed.len());
            for (place, index) in (1..).zip(listed) {
                let _ = writeln!(head, "{place}=0x{index:04X}");
            }
            head.push('\n');
        }
        head + &self.sections
    }
}
