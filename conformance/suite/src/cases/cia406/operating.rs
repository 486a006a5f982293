//! Operating parameters (6000h).

use super::number;
use super::position::OPERATING_PARAMETERS;
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, demand};
use canvass_bus::client::Outcome;

/// Bits 4 to 11 have no meaning in any version of the profile.
const RESERVED: u32 = 0x0FF0;

/// Reserved bits of 6000h are refused, or at least not taken over.
#[case(id = "406/operating-parameters/reserved-bits", clause = "CiA 406", confidence = Unknown, level = Should,
       needs = [Encoder], catches = [ReservedOperatingBitsAccepted])]
fn reserved_bits(bench: &mut Bench<'_>) -> Judged {
    let before = bench.read_number(OPERATING_PARAMETERS)?;
    let attempt = bench.download(OPERATING_PARAMETERS, &((before | RESERVED) as u16).to_le_bytes())?;
    if attempt.outcome != Outcome::Downloaded {
        return Ok(());
    }
    let after = bench.read_number(OPERATING_PARAMETERS)?;
    bench.check(demand(after & RESERVED == 0, || {
        let breach = Breach::new(OPERATING_PARAMETERS, "6000h does not take reserved bits over");
        breach.expected("bits 4 to 11 are 0").found(number(after & RESERVED)).told(format!("{after:04X}h"))
    }))
}
