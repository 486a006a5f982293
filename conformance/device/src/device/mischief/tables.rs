//! Answers of a firmware with wrong object tables.

use super::Mischief;
use crate::Fault;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::{AbortCode, Response};

impl Mischief {
    /// The answer to the upload of an object that only this faulty firmware has.
    pub(super) fn surplus(&self, at: Multiplexer) -> Option<Response> {
        let (value, fault): ([u8; 4], _) = match (at.index.0, at.sub.0) {
            (0x200A, 0) => ([0x2A, 0, 0, 0], Fault::UndescribedObject),
            (object::IDENTITY, 0xFF) => ([0x42, 0, 0, 0], Fault::StructureEntryWrong),
            _ => return None,
        };
        self.has(fault).then(|| Response::upload(at, &value))
    }

    /// Whether the firmware confirms a download that it must refuse.
    pub(super) fn forgives(&self, at: Multiplexer, code: AbortCode) -> bool {
        let Some((asked, value)) = self.download.filter(|(asked, _)| *asked == at) else { return false };
        let is_extended = value & 1 << 29 != 0;
        let is_mapping = object::is_pdo_mapping(asked.index.0);
        match (asked.index.0, asked.sub.0) {
            (object::TPDO_COMMUNICATION_PARAMETER, 1) if !is_extended => {
                value & 0x1FFF_F800 != 0 && self.has(Fault::CanIdTooHighAccepted)
            }
            (object::TPDO_COMMUNICATION_PARAMETER, 1) => self.has(Fault::ExtendedBitAccepted),
            (object::COB_ID_SYNC, 0) => value & 1 << 30 != 0 && self.has(Fault::SyncProducerBitAccepted),
            _ => is_mapping && code == AbortCode::NOT_MAPPABLE && self.has(Fault::MappingDirectionUnchecked),
        }
    }

    /// The value of an object in the firmware's wrong tables.
    pub(super) fn planted(&self, at: Multiplexer, value: u32) -> u32 {
        match (at.index.0, at.sub.0) {
            (object::PREDEFINED_ERROR_FIELD, 0) if self.has(Fault::ErrorHistoryNotKept) => 0,
            (object::COB_ID_SYNC, 0) if self.has(Fault::SyncIdWrong) => value ^ 0x1,
            (object::COB_ID_TIME, 0) if self.has(Fault::TimeIdWrong) => value ^ 0x1,
            (object::COB_ID_EMCY, 0) if self.has(Fault::EmcyIdWrong) => value ^ 0x1,
            (object::SDO_SERVER_PARAMETER, 1) if self.has(Fault::SdoServerIdWrong) => value ^ 0x80,
            (object::TPDO_COMMUNICATION_PARAMETER, 1) if self.has(Fault::PdoIdNotPredefined) => value ^ 0x40,
            (object::TPDO_MAPPING_PARAMETER, 1) if self.has(Fault::DefaultMappingWrong) => value ^ 0x18,
            (object::STORE_PARAMETERS, 1) if self.has(Fault::StoreCapabilityDenied) => 0,
            (object::RESTORE_DEFAULT_PARAMETERS, 1) if self.has(Fault::RestoreCapabilityWrong) => {
                u32::from_le_bytes(*b"load")
            }
            (object::STORE_PARAMETERS, 1) if self.has(Fault::StoreCapabilityWrong) => u32::from_le_bytes(*b"save"),
            _ => value,
        }
    }
}
