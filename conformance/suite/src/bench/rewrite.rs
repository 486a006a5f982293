//! Writes values back, in the order that CiA 301 requires.

use super::Bench;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::configuration::{Download, companions, is_cob_id, ordered};
use canvass_bus::client::Outcome;
use canvass_bus::client::sdo::Mode;

/// Writes values back, except to objects that act; returns the values that the device does not have again.
pub(super) fn write_back(bench: &mut Bench<'_>, originals: &[Download]) -> Vec<Download> {
    let settings: Vec<&Download> = originals.iter().filter(|original| !bench.acts(original.at)).collect();
    let wrong: Vec<&Download> = settings.iter().copied().filter(|original| !has_again(bench, original)).collect();
    let companions = wrong.iter().flat_map(|original| companions(original.at));
    let needed: Vec<Multiplexer> = wrong.iter().map(|original| original.at).chain(companions.flatten()).collect();
    let rewritten = settings.iter().copied().filter(|original| needed.contains(&original.at));
    let held: Vec<(Multiplexer, u32)> = needed
        .iter()
        .filter(|at| is_cob_id(**at))
        .filter_map(|&at| match bench.upload(at).ok()?.outcome {
            Outcome::Uploaded(value) => Some((at, super::sdo::number(&value))),
            _ => None,
        })
        .collect();
    for Download { at, value } in ordered(rewritten, &held) {
        // A refusal shows when the value is read back.
        let _ = bench.download_as(at, &value, Mode::Shortest);
    }
    let again: Vec<&Download> = settings.into_iter().filter(|original| needed.contains(&original.at)).collect();
    again.into_iter().filter(|original| !has_again(bench, original)).cloned().collect()
}

/// Whether an object has its value again. An object that can't be read counts as changed.
fn has_again(bench: &mut Bench<'_>, original: &Download) -> bool {
    let now = bench.upload(original.at).map(|attempt| attempt.outcome);
    matches!(now, Ok(Outcome::Uploaded(value)) if value == original.value)
}
