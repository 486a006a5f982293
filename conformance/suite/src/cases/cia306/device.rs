//! The device compared with its description: objects of the device that the description lacks.

use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, observed};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Index, Multiplexer};
use canvass_bus::client::Outcome;
use canvass_bus::observation::{Observation, Subject};

/// The index ranges in which devices usually have objects, checked in every run.
const USUAL: [(u16, u16); 12] = [
    (0x1000, 0x102A),
    (0x1200, 0x1203),
    (0x1280, 0x1283),
    (0x1400, 0x1407),
    (0x1600, 0x1607),
    (0x1800, 0x1807),
    (0x1A00, 0x1A07),
    (0x1F50, 0x1F57),
    (0x1F80, 0x1F83),
    (0x2000, 0x200F),
    (0x6000, 0x600F),
    (0x6500, 0x650F),
];

/// All indexes, for an exhaustive run.
const ALL: [(u16, u16); 1] = [(0x1000, 0x9FFF)];

/// The device has no object that is missing in its description.
///
/// The case reads the indexes where devices usually have objects. In an exhaustive run it reads every index from 1000h
/// to 9FFFh, which takes about a minute on a live bus.
#[case(id = "306/device/undescribed", clause = "CiA 306", confidence = Unknown, level = Should, needs = [Description],
       catches = [UndescribedObject])]
fn undescribed(bench: &mut Bench<'_>) -> Judged {
    const JUDGED: u64 = 64;
    // A device that returns no value has no objects to show.
    bench.read(crate::bench::sdo::DEVICE_TYPE)?;
    let ranges: &[(u16, u16)] = if bench.options().exhaustive { &ALL } else { &USUAL };
    let mut found = 0;
    for index in ranges.iter().flat_map(|&(first, last)| first..=last) {
        let is_described = |description: &canvass_analyzer::dictionary::DeviceDescription| {
            description.dictionary.object(Index(index)).is_some()
        };
        if bench.target().description.as_ref().is_none_or(is_described) {
            continue;
        }
        let attempt = bench.upload(Multiplexer::new(index, 0))?;
        let is_there = match &attempt.outcome {
            Outcome::Uploaded(_) => true,
            Outcome::Aborted(abort) => abort.code == AbortCode::WRITE_ONLY,
            _ => false,
        };
        if !is_there {
            continue;
        }
        found += 1;
        if found <= JUDGED {
            let breach = Breach::new(Subject::Object(Index(index)), "every object of the device is described");
            let breach = breach.expected("abort 0602 0000h, since the description does not name it");
            bench.check(Err(Box::new(breach.found(observed(&attempt.outcome)).told(attempt.outcome.to_string()))))?;
        }
    }
    let more: u64 = found.saturating_sub(JUDGED);
    if more > 0 {
        let breach = Breach::new(Subject::Device, "every object of the device is described");
        let breach =
            breach.expected("no more than these").found(Observation::named("more objects without description"));
        bench.check(Err(Box::new(breach.told(format!("{more} more")))))?;
    }
    Ok(())
}
