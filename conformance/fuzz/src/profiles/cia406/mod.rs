//! CiA 406: encoders.

mod position;

use crate::Knowledge;
use crate::profile::{Broken, Dialogue, Profile, Registered};
use crate::property::ProfileProperty;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::profiles::cia406::{NUMBER, makers, objects};

/// The profile.
#[derive(Debug)]
struct Cia406;

inventory::submit! { Registered(&Cia406) }

impl Profile for Cia406 {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn properties(&self) -> &'static [&'static ProfileProperty] {
        static PROPERTIES: [&ProfileProperty; 1] = [&position::IN_RANGE];
        &PROPERTIES
    }

    fn judge(
        &self,
        at: Multiplexer,
        value: &[u8],
        knowledge: &Knowledge,
        expected: &dyn Fn(Multiplexer) -> Option<u64>,
    ) -> Option<Broken> {
        position::judge(at, value, knowledge, expected)
    }

    fn dialogue(&self, script: &mut dyn Dialogue) -> bool {
        position::dialogue(script)
    }

    fn provokes(&self, at: Multiplexer) -> bool {
        matches!(at.index.0, objects::WORK_AREA_LOW_LIMIT | objects::WORK_AREA_HIGH_LIMIT)
            || makers::temperature_limits().any(|limit| limit.index == at.index)
    }
}
