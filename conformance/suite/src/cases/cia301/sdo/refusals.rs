//! Refusals for more than one reason, and refusals of contradictory limits (CiA 301, 7.2.4.3.17).

use crate::bench::Bench;
use crate::bench::sdo::DEVICE_TYPE;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Breach, Judged, demand, observed};
use canvass_analyzer::object;
use canvass_analyzer::{Multiplexer, SubIndex};

/// A download that is wrong for several reasons is refused with the same abort each time. The abort may name any of the
/// reasons; the case notes which.
#[case(id = "301/sdo/download/several-reasons", clause = "CiA 301 7.2.4.3.17", confidence = Cited, level = Should,
       catches = [SdoRefusalAlternates, SdoReadOnlyWritable])]
fn several_reasons(bench: &mut Bench<'_>) -> Judged {
    const REPEATED: usize = 4;
    let attempts: [(&str, Multiplexer, &[u8], Situation); 3] = [
        ("a read-only object, of a wrong length", DEVICE_TYPE, &[0], Situation::ReadOnlyAndTooShort),
        (
            "a sub-index that a read-only object does not have",
            Multiplexer::new(object::DEVICE_TYPE, 7),
            &[0, 0],
            Situation::MissingEntryOfReadOnly,
        ),
        (
            "a sub-index that does not exist, of a wrong length",
            Multiplexer::new(object::IDENTITY, 0x70),
            &[0],
            Situation::MissingEntryOfReadOnly,
        ),
    ];
    bench.each(attempts, |bench, (what, at, value, situation)| {
        // DS-301 V3.0 had no 1018h.
        if !bench.has(Multiplexer { sub: SubIndex(0), ..at })? {
            return Ok(());
        }
        let first = bench.download(at, value)?;
        first.refused(situation)?;
        for _ in 1..REPEATED {
            let again = bench.download(at, value)?;
            bench.check(demand(again.outcome == first.outcome, || {
                let breach = Breach::new(at, format!("downloads to {what} are always refused for the same reason"));
                breach.expected(observed(&first.outcome)).found(observed(&again.outcome))
            }))?;
        }
        bench.note(format!("{what}: {}", first.outcome));
        Ok(())
    })
}
