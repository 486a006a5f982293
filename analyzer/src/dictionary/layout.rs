//! The layout of a described device's PDOs, bit by bit, after a start with nothing stored.

use super::description::DeviceDescription;
use super::difference::mapping;
use super::object::{Entry, Setting};
use crate::PdoNumber;
use crate::identity::Multiplexer;
use crate::wire::pdo::MappingEntry;

/// A PDO with its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct PdoLayout<'a> {
    /// The PDO.
    pub pdo: PdoNumber,
    /// The COB-ID of the PDO; `None` if the description does not give it.
    pub cob_id: Option<&'a Setting>,
    /// The transmission type of the PDO; `None` if the description does not give it.
    pub transmission_type: Option<u8>,
    /// The fields in the order of the mapping; `None` if the description does not give the mapping.
    pub fields: Option<Vec<PdoField<'a>>>,
}

/// A part of a PDO.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PdoField<'a> {
    /// The mapped object, or a data type that skips bits.
    pub mapped: MappingEntry,
    /// The position of the field's first bit in the PDO; bit 0 is the least significant of byte 0.
    pub offset: u32,
    /// The description of the mapped object, if there is one.
    pub entry: Option<&'a Entry>,
}

impl PdoField<'_> {
    /// The position of the bit after the field's last one.
    pub fn end(&self) -> u32 {
        self.offset + u32::from(self.mapped.bits())
    }
}

impl PdoLayout<'_> {
    /// The number of bits of the field.
    pub fn bits(&self) -> u32 {
        self.fields.iter().flatten().last().map_or(0, PdoField::end)
    }
}

/// The layouts of all described PDOs: first of RPDOs, then of TPDOs.
pub fn layouts(description: &DeviceDescription) -> Vec<PdoLayout<'_>> {
    let objects = description.dictionary.objects().iter();
    let mut pdos: Vec<PdoNumber> = objects
        .filter_map(|object| {
            let index = object.index.0;
            PdoNumber::of_mapping_index(index).or(PdoNumber::of_communication_index(index))
        })
        .collect();
    pdos.sort_by_key(|pdo| pdo.communication_index());
    pdos.dedup();
    pdos.into_iter().map(|pdo| layout(description, pdo)).collect()
}

fn layout(description: &DeviceDescription, pdo: PdoNumber) -> PdoLayout<'_> {
    let start = |sub| {
        let entry = description.dictionary.entry(Multiplexer::new(pdo.communication_index(), sub)).ok()?;
        entry.configured.as_ref().or(entry.default.as_ref())
    };
    let transmission_type = start(2).and_then(|setting| u8::try_from(setting.fixed()?.to_raw()?).ok());
    let fields = mapping(description, pdo).map(|mapped| {
        let mut offset = 0;
        let field = |mapped: MappingEntry| {
            let entry = description.dictionary.entry(mapped.object()).ok();
            let field = PdoField { mapped, offset, entry };
            offset = field.end();
            field
        };
        mapped.into_iter().map(field).collect()
    });
    PdoLayout { pdo, cob_id: start(1), transmission_type, fields }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_follow_each_other() {
        let text = include_str!("../../tests/difference/old.eds")
            .replace("[1A00]\n", "[1600]\nParameterName=RPDO\nObjectType=9\nSubNumber=1\n[1600sub0]\nParameterName=Count\nDataType=5\nAccessType=rw\n[1A00]\n")
            .replace("AccessType=rw\nDefaultValue=1\nPDOMapping=0", "AccessType=rw\nDefaultValue=2\nPDOMapping=0")
            .replace("[2000]\n", "[1A00sub2]\nParameterName=Second\nDataType=7\nAccessType=rw\nDefaultValue=0x20000010\n[2000]\n");
        let description = DeviceDescription::read(text.as_bytes()).unwrap();
        let layouts = layouts(&description);
        let pdos: Vec<String> = layouts.iter().map(|layout| format!("{} {}", layout.pdo, layout.bits())).collect();
        assert_eq!(pdos, ["RPDO 1 0", "TPDO 1 24", "TPDO 2 0"]);
        assert_eq!((layouts[0].fields.as_ref(), layouts[0].cob_id), (None, None));
        let fields = layouts[1].fields.as_ref().unwrap();
        let shown: Vec<_> =
            fields.iter().map(|field| (field.offset, field.end(), field.entry.map(|it| it.name.as_str()))).collect();
        assert_eq!(shown, [(0, 8, Some("State")), (8, 24, Some("Setting"))]);
        assert_eq!((layouts[1].cob_id, layouts[1].transmission_type), (Some(&Setting::NodeIdPlus(0x180)), Some(255)));
    }
}
