//! Store and restore parameters (1010h, 1011h). All of it may write non-volatile memory, so the user has to allow it.

use crate::bench::Bench;
use crate::case;
use crate::client::sdo::Bytes;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_analyzer::wire::sdo::AbortCode;

const STORE: Multiplexer = Multiplexer::new(0x1010, 1);
const RESTORE: Multiplexer = Multiplexer::new(0x1011, 1);

/// Any signature but "save" is refused by 1010h with abort 0800 0020h.
#[case(id = "301/store/wrong-signature", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store], touches = [Nvm], catches = [StoreSignatureUnchecked], cct = "8.3")]
fn wrong_signature(bench: &mut Bench<'_>) -> Judged {
    let mut verdict = Verdict::Pass;
    for signature in [b"evas", b"SAVE", b"wron", b"load"] {
        let attempt = bench.download(STORE, signature)?;
        let tolerated = [AbortCode::GENERAL, AbortCode::INVALID_VALUE];
        verdict = verdict.and(attempt.expect_abort(&[AbortCode::NOT_TRANSFERRED], &tolerated)?);
    }
    Ok(verdict)
}

/// What was stored by "save" is there after reset node. The old value is stored again afterwards.
#[case(id = "301/store/persists", clause = "CiA 301 7.5.2.13", confidence = Derived, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm], catches = [StoreWithoutEffect], cct = "8.5")]
fn persists(bench: &mut Bench<'_>) -> Judged {
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.write(STORE, b"save")?;
    bench.note("1010h was written twice: the device's non-volatile memory has done two more cycles");
    let stored = bench.reset(Command::RESET_NODE).and_then(|()| bench.read(scratch.multiplexer));
    // Whatever came of it, the device gets its old value back.
    bench.write(scratch.multiplexer, &scratch.value)?;
    bench.write(STORE, b"save")?;
    let stored = stored?;
    demand(stored == scratch.other, || {
        let duty = format!("{} has its stored value after reset node", scratch.multiplexer);
        Reason::new(duty, Bytes(&scratch.other).to_string(), Bytes(&stored).to_string())
    })
}

/// "load" restores the defaults with the next reset, not before.
#[case(id = "301/restore/at-reset", clause = "CiA 301 7.5.2.14", confidence = Derived, level = Must,
       needs = [Store, ScratchObject], touches = [Nvm, FactoryDefaults], catches = [RestoreAtOnce], cct = "8.4")]
fn at_reset(bench: &mut Bench<'_>) -> Judged {
    if !bench.has(RESTORE)? {
        return Err(Verdict::NotApplicable(Reason::new("the device restores its defaults", "1011h:01", "none")));
    }
    let scratch = bench.scratch(&[2, 1, 4])?;
    bench.write(scratch.multiplexer, &scratch.other)?;
    bench.download(RESTORE, b"load")?.expect_confirmation()?;
    bench.expect_unchanged(scratch.multiplexer, &scratch.other)
}
