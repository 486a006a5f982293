//! The assumption that a live device serves frames in their order, and the required duration of its silence.
//!
//! SDO and LSS have separate values, as many stacks serve them in separate tasks.

use super::property::Property;
use canvass_traces::Duration;

/// Number of violations that did not come back after which the device is not assumed to serve requests in their order.
const MOST_DOUBTS: u32 = 3;

/// The required silence is halved, but not below the measured time, after this number of sequences in which each
/// violation came back.
const REGAINED: u32 = 64;

/// The trust in one of the device's services.
#[derive(Clone, Copy, Debug)]
struct Trust {
    /// Number of violations that did not come back.
    doubts: u32,
    /// Number of sequences since the last violation that did not come back, or since the last halving.
    since_doubt: u32,
    /// The required duration of silence.
    quiet: Duration,
}

impl Trust {
    fn doubt(&mut self, longest: Duration) {
        self.doubts += 1;
        self.since_doubt = 0;
        self.quiet = self.quiet.times(2).min(longest);
    }

    /// Counts a sequence in which each violation came back. After [`REGAINED`] such sequences the required silence gets
    /// shorter again, as the host may have caused the late answer.
    fn regain(&mut self, measured: Duration) {
        self.since_doubt += 1;
        if self.since_doubt >= REGAINED {
            self.since_doubt = 0;
            self.quiet = Duration(self.quiet.nanos() / 2).max(measured);
        }
    }

    const fn is_in_order(&self) -> bool {
        self.doubts < MOST_DOUBTS
    }
}

/// The trust in all services of the device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trusts {
    lss: Trust,
    others: Trust,
    measured: Duration,
    /// Whether an answer to an LSS frame may still be under way.
    pub awaits_lss: bool,
}

impl Trusts {
    /// Full trust, as no violation has failed to come back yet. `measured`: the required duration of silence.
    pub const fn new(measured: Duration) -> Self {
        let trust = Trust { doubts: 0, since_doubt: 0, quiet: measured };
        Self { lss: trust, others: trust, measured, awaits_lss: false }
    }

    /// Records a violation that did not come back. The required silence grows for a while, to at most `longest`.
    pub fn doubt(&mut self, property: Property, longest: Duration) {
        if is_lss(property) { self.lss.doubt(longest) } else { self.others.doubt(longest) }
    }

    /// Counts another sequence.
    pub fn regain(&mut self) {
        self.lss.regain(self.measured);
        self.others.regain(self.measured);
    }

    /// The duration of silence required now.
    pub fn quiet(&self) -> Duration {
        if self.awaits_lss { self.lss.quiet.max(self.others.quiet) } else { self.others.quiet }
    }

    /// Whether an answer to a later request proves that the frames before it have taken effect.
    pub(crate) const fn are_in_order(&self) -> bool {
        self.others.is_in_order() && (!self.awaits_lss || self.lss.is_in_order())
    }

    /// Whether an answer of the property's service to a later request proves that the requests before it have taken
    /// effect.
    pub(crate) const fn is_in_order(&self, property: Property) -> bool {
        if is_lss(property) { self.lss.is_in_order() } else { self.others.is_in_order() }
    }
}

const fn is_lss(property: Property) -> bool {
    matches!(property, Property::LegalLss | Property::Fastscan)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lss_and_the_others_are_doubted_apart() {
        let (usual, longest) = (Duration::from_millis(2), Duration::from_secs(1));
        let mut trusts = Trusts::new(usual);
        (0..MOST_DOUBTS).for_each(|_| trusts.doubt(Property::LegalLss, longest));
        assert!(trusts.are_in_order() && !trusts.is_in_order(Property::LegalLss));
        assert_eq!(trusts.quiet(), usual);
        trusts.awaits_lss = true;
        assert!(!trusts.are_in_order());
        assert_eq!(trusts.quiet(), usual.times(8));
        (0..3 * REGAINED).for_each(|_| trusts.regain());
        assert_eq!(trusts.quiet(), usual, "what was late once may have been the host's doing");
        (0..20).for_each(|_| trusts.doubt(Property::LegalSdo, longest));
        assert!(!trusts.are_in_order() && trusts.quiet() == longest);
    }
}
