//! What objects say and take in a firmware whose tables are wrong.

use super::Mischief;
use crate::Fault;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::{AbortCode, Response};

impl Mischief {
    /// What is answered to the upload of an object that the firmware has and should not.
    pub(super) fn surplus(&self, at: Multiplexer) -> Option<Response> {
        let (value, fault): ([u8; 4], _) = match (at.index.0, at.sub.0) {
            (0x200A, 0) => ([0x2A, 0, 0, 0], Fault::UndescribedObject),
            (0x1018, 0xFF) => ([0x42, 0, 0, 0], Fault::StructureEntryWrong),
            _ => return None,
        };
        self.has(fault).then(|| Response::upload(at, &value))
    }

    /// Whether a download that must be refused is confirmed.
    pub(super) fn forgives(&self, at: Multiplexer, code: AbortCode) -> bool {
        let Some((asked, value)) = self.download.filter(|(asked, _)| *asked == at) else { return false };
        let is_extended = value & 1 << 29 != 0;
        let is_mapping = matches!(asked.index.0, 0x1600..0x1800 | 0x1A00..0x1C00);
        match (asked.index.0, asked.sub.0) {
            (0x1800, 1) if !is_extended => value & 0x1FFF_F800 != 0 && self.has(Fault::CanIdTooHighAccepted),
            (0x1800, 1) => self.has(Fault::ExtendedBitAccepted),
            (0x1005, 0) => value & 1 << 30 != 0 && self.has(Fault::SyncProducerBitAccepted),
            _ => is_mapping && code == AbortCode::NOT_MAPPABLE && self.has(Fault::MappingDirectionUnchecked),
        }
    }

    /// What an object reads as in a firmware whose tables are wrong.
    pub(super) fn planted(&self, at: Multiplexer, value: u32) -> u32 {
        match (at.index.0, at.sub.0) {
            (0x1003, 0) if self.has(Fault::ErrorHistoryNotKept) => 0,
            (0x1005, 0) if self.has(Fault::SyncIdWrong) => value ^ 0x1,
            (0x1012, 0) if self.has(Fault::TimeIdWrong) => value ^ 0x1,
            (0x1014, 0) if self.has(Fault::EmcyIdWrong) => value ^ 0x1,
            (0x1200, 1) if self.has(Fault::SdoServerIdWrong) => value ^ 0x80,
            (0x1800, 1) if self.has(Fault::PdoIdNotPredefined) => value ^ 0x40,
            (0x1A00, 1) if self.has(Fault::DefaultMappingWrong) => value ^ 0x18,
            (0x1010, 1) if self.has(Fault::StoreCapabilityDenied) => 0,
            (0x1010, 1) if self.has(Fault::StoreCapabilityWrong) => u32::from_le_bytes(*b"save"),
            _ => value,
        }
    }
}
