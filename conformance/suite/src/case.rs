//! What a conformance case is: an item of the catalogue.

use crate::bench::Bench;
use crate::clause::{Clause, Level};
use crate::need::Need;
use crate::situation::Situation;
use crate::touch::Touch;
use crate::verdict::Judged;
use canvass_device::Fault;

/// A case of the catalogue, registered by the `#[case]` attribute.
#[derive(Debug)]
pub struct Case {
    /// Stable and textual: `301/sdo/download/read-only`.
    pub id: &'static str,
    /// What the standard demands, in the words of its author: the doc comment of the case.
    pub requirement: &'static str,
    /// Where the standard demands it.
    pub clause: Clause,
    /// How strictly it is demanded.
    pub level: Level,
    /// Features without which the case is not applicable.
    pub needs: &'static [&'static Need],
    /// What the case does that the user must allow first.
    pub touches: &'static [Touch],
    /// Firmware faults, each of which makes the case fail.
    pub catches: &'static [Fault],
    /// The rows of the table of allowed answers that it asks; none where it judges no answers, but times and values.
    pub answers: &'static [Situation],
    /// The number of a comparable case of CiA's conformance test tool.
    pub cct: Option<&'static str>,
    /// Stimulus and verdict.
    pub run: fn(&mut Bench<'_>) -> Judged,
}

inventory::collect!(Case);

impl Case {
    /// Standard and service: the first two words of the id, such as `301/sdo`.
    pub fn family(&self) -> &'static str {
        self.id.match_indices('/').nth(1).map_or(self.id, |(at, _)| self.id.get(..at).unwrap_or(self.id))
    }

    /// Whether it looks at the device at all, and not at its description alone.
    pub fn asks_the_device(&self) -> bool {
        !matches!(self.family(), "306/file" | "306/objects")
    }

    /// Whether the case may make the device operational. A run of others never does.
    pub fn may_start_the_device(&self) -> bool {
        let family = self.family();
        let stays_pre_operational =
            ["301/cob-id", "301/dictionary", "301/identity", "301/sdo", "301/verify-configuration"];
        !stays_pre_operational.contains(&family) && !["205/", "305/", "306/"].iter().any(|of| family.starts_with(of))
    }

    /// Whether the quantity that a simulated device measures must move while the case runs.
    pub fn needs_motion(&self) -> bool {
        self.needs.iter().any(|need| need.is_of_moving())
    }

    /// Whether the device may be lost in it, so that it runs after those that can't lose it.
    pub fn can_lose_the_device(&self) -> bool {
        self.touches.iter().any(|touch| touch.can_lose_the_device())
    }

    /// The first sentence of the requirement: a line for lists.
    pub fn summary(&self) -> &'static str {
        let paragraph = self.requirement.split("\n\n").next().unwrap_or(self.requirement);
        paragraph.split_inclusive(". ").next().unwrap_or(paragraph).trim_end()
    }
}
