//! A conformance case, an item of the catalogue.

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
    /// The stable id in words: `301/sdo/download/read-only`.
    pub id: &'static str,
    /// The requirement of the standard in the words of the case's author: the doc comment of the case.
    pub requirement: &'static str,
    /// The clause of the standard that contains the requirement.
    pub clause: Clause,
    /// Whether the standard requires the behaviour, recommends it, or leaves it open.
    pub level: Level,
    /// Features without which the case is not applicable.
    pub needs: &'static [&'static Need],
    /// Actions of the case that the user must allow first.
    pub touches: &'static [Touch],
    /// Firmware faults. Each of them makes the case fail.
    pub catches: &'static [Fault],
    /// The rows of the table of allowed answers that the case uses; empty if it judges times and values, not answers.
    pub answers: &'static [Situation],
    /// The number of a comparable case of CiA's conformance test tool.
    pub cct: Option<&'static str>,
    /// The function of the case: stimulus and verdict.
    pub run: fn(&mut Bench<'_>) -> Judged,
}

inventory::collect!(Case);

impl Case {
    /// Standard and service: the first two words of the id, such as `301/sdo`.
    pub fn family(&self) -> &'static str {
        self.id.match_indices('/').nth(1).map_or(self.id, |(at, _)| self.id.get(..at).unwrap_or(self.id))
    }

    /// Whether the case uses the device, not only its description.
    pub fn asks_the_device(&self) -> bool {
        !matches!(self.family(), "306/file" | "306/objects")
    }

    /// Whether the case may make the device operational. A run without such cases never does.
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

    /// Whether the case may lose the device. Such cases run last.
    pub fn can_lose_the_device(&self) -> bool {
        self.touches.iter().any(|touch| touch.can_lose_the_device())
    }

    /// The first sentence of the requirement, for lists.
    pub fn summary(&self) -> &'static str {
        let paragraph = self.requirement.split("\n\n").next().unwrap_or(self.requirement);
        paragraph.split_inclusive(". ").next().unwrap_or(paragraph).trim_end()
    }
}
