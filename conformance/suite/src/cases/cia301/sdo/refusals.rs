//! Refusals for more than one reason, and of limits that contradict each other (CiA 301, 7.2.4.3.17).

use crate::bench::Bench;
use crate::case;
use crate::situation::Situation;
use crate::verdict::{Judged, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::sdo::AbortCode;

/// A download that is wrong in several ways is refused each time with the same abort, whichever of the reasons it names.
/// Which one wins is noted.
#[case(id = "301/sdo/download/several-reasons", clause = "CiA 301 7.2.4.3.17", confidence = Attested, level = Should,
       catches = [SdoRefusalAlternates, SdoReadOnlyWritable])]
fn several_reasons(bench: &mut Bench<'_>) -> Judged {
    const REPEATED: usize = 4;
    let attempts: [(&str, Multiplexer, &[u8]); 3] = [
        ("a read-only object, of a wrong length", Multiplexer::new(0x1000, 0), &[0]),
        ("a sub-index that a read-only object does not have", Multiplexer::new(0x1000, 7), &[0, 0]),
        ("a sub-index that does not exist, of a wrong length", Multiplexer::new(0x1018, 0x70), &[0]),
    ];
    for (what, at, value) in attempts {
        let mut first: Option<AbortCode> = None;
        for _ in 0..REPEATED {
            let attempt = bench.download(at, value)?;
            let Some(code) = attempt.abort() else {
                let duty = format!("a download to {what} is refused");
                return Err(Stop::from(Reason::new(duty, "an abort", attempt.outcome.to_string())));
            };
            let expected = *first.get_or_insert(code);
            demand(code == expected, || {
                let duty = format!("downloads to {what} are always refused for the same reason");
                Reason::new(duty, format!("abort {expected}, as before"), format!("abort {code}"))
            })?;
        }
        if let Some(code) = first {
            bench.note(format!("{what}: abort {code}"));
        }
    }
    Ok(())
}

/// A maximum below its minimum is refused with abort 0609 0036h, and the old limit stays.
#[case(id = "301/sdo/download/maximum-below-minimum", clause = "CiA 301 7.2.4.3.17", confidence = Attested,
       level = Should, needs = [WorkArea], catches = [WorkAreaLimitsSwappedAccepted, LimitsSwappedWrongCode])]
fn maximum_below_minimum(bench: &mut Bench<'_>) -> Judged {
    let (low, high) = (Multiplexer::new(0x6401, 1), Multiplexer::new(0x6402, 1));
    if !bench.can_write(low)? || !bench.can_write(high)? {
        let reason = Reason::new("both limits of the work area can be written", "6401h and 6402h", "read-only");
        return Err(Stop::NotApplicable(reason));
    }
    bench.write(high, &2_000_u32.to_le_bytes())?;
    bench.write(low, &1_000_u32.to_le_bytes())?;
    let before = bench.read(high)?;
    let mut attempt = bench.download(high, &999_u32.to_le_bytes())?;
    attempt.what = "high limit below the low limit".to_owned();
    bench.check(attempt.refused(Situation::MaximumBelowMinimum))?;
    bench.expect_unchanged(high, &before)?;
    Ok(())
}
