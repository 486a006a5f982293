//! Needs: features of the device or the bus that a case requires, each with its text and its check in one item.
//!
//! The items stand beside the cases that use them; [`needs`](crate::needs) names all of them.

use crate::bench::{Bench, Found, Met, Rescue};
use crate::case::Case;
use crate::clause::Level;
use crate::touch::Touch;
use crate::verdict::{Reason, Stop};
use std::fmt;

/// A feature of the device or the bus without which a case is not applicable.
pub struct Need {
    /// The stable id in words: `visible-state`.
    pub id: &'static str,
    text: &'static str,
    check: fn(&mut Bench<'_>) -> Result<Met, Stop>,
    fleeting: bool,
    moving: bool,
    provide: Option<Provide>,
    rescue: Option<Rescue>,
}

impl Need {
    /// Creates a need that is checked once in a run: `text` names the missing feature of the device or the bus.
    ///
    /// The check uses the description and the device. A feature is absent if the description lacks it, or if the device
    /// gives an answer that CiA 301 allows for an absent one. The check returns any other answer to a correct request
    /// as a breach.
    pub const fn new(id: &'static str, text: &'static str, check: fn(&mut Bench<'_>) -> Result<Met, Stop>) -> Self {
        Self { id, text, check, fleeting: false, moving: false, provide: None, rescue: None }
    }

    /// Makes the suite check the need before each case, since it may be met before one case but not before the next.
    #[must_use]
    pub(crate) const fn fleeting(self) -> Self {
        Self { fleeting: true, ..self }
    }

    /// Makes the quantity that a simulated device measures move while the case runs.
    #[must_use]
    pub(crate) const fn moving(self) -> Self {
        Self { moving: true, ..self }
    }

    /// Whether the quantity that a simulated device measures must move.
    pub(crate) const fn is_of_moving(&self) -> bool {
        self.moving
    }

    /// Makes the bench set up the feature before each case, and put the device back after it. The device supports the
    /// feature, but lacks it as delivered.
    #[must_use]
    pub(crate) const fn provided_by(self, provide: Provide) -> Self {
        Self { provide: Some(provide), ..self }
    }

    /// Adds the clean-up for cases with this need that could not go on.
    #[must_use]
    pub(crate) const fn rescued_by(self, rescue: Rescue) -> Self {
        Self { rescue: Some(rescue), ..self }
    }

    /// The feature that the device or the bus would need.
    pub const fn text(&self) -> &'static str {
        self.text
    }

    /// Checks the need, without the knowledge of the run.
    #[cfg(test)]
    pub(crate) fn check(&self, bench: &mut Bench<'_>) -> Result<Met, Stop> {
        (self.check)(bench)
    }

    pub(crate) const fn rescue(&self) -> Option<Rescue> {
        self.rescue
    }
}

/// Sets up a feature that a case needs; returns the reason if the device does not allow it.
type Provide = fn(&mut Bench<'_>) -> Result<Met, Stop>;

fn unmet(need: &Need, why: String) -> Stop {
    Stop::NotApplicable(Reason::new("the device has the feature that the case needs", need.text, why))
}

impl Case {
    /// Whether the case has this need.
    pub fn requires(&self, need: &Need) -> bool {
        self.needs.contains(&need)
    }

    /// Checks that all needs of the case are met.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if the device lacks a feature. [`Stop::Breach`] if the device neither serves a feature
    /// nor properly reports its absence; the first case that meets the breach reports it, for the other cases it is
    /// [`Stop::Inconclusive`]. A case of [`Level::Open`] reports no breach.
    pub(crate) fn require(&self, bench: &mut Bench<'_>) -> Result<(), Stop> {
        for &need in self.needs {
            if let Err(why) = self.ask(bench, need)? {
                return Err(unmet(need, why));
            }
        }
        for &need in self.needs {
            if let Some(provide) = need.provide
                && let Err(why) = bench.unjudged(provide)?
            {
                return Err(unmet(need, why));
            }
        }
        Ok(())
    }

    /// Cleans up after a case that was cancelled or could not go on: restores the device's own node-ID and bit rate.
    pub(crate) fn rescue(&self, bench: &mut Bench<'_>) {
        let touches = self.touches.iter().any(|touch| matches!(touch, Touch::NodeId | Touch::BitRate | Touch::Nvm));
        bench.end_early(self.needs.iter().find_map(|need| need.rescue()).filter(|_| touches));
    }

    fn ask(&self, bench: &mut Bench<'_>, need: &Need) -> Result<Met, Stop> {
        match bench.knowledge.known(need.id).cloned() {
            Some(Found::Known(met)) if !need.fleeting => return Ok(met),
            Some(Found::Broken { why, reported_in }) if reported_in != self.id => {
                let actual = format!("{}, as {reported_in} reports", why.actual);
                return Err(Stop::Inconclusive(Reason { actual, ..why }));
            }
            _ => {}
        }
        let asked = asked_undisturbed(bench, need);
        // A need may begin a transfer to find out whether the server supports it.
        bench.make_server_idle();
        let met = match asked {
            Err(Stop::NotApplicable(reason)) => Err(reason.actual),
            Err(Stop::Breach(breach)) if self.level != Level::Open => {
                let why = Reason::from(&*breach);
                bench.knowledge.learned(need.id, Found::Broken { why, reported_in: self.id });
                return Err(Stop::Breach(breach));
            }
            other => other.map_err(Stop::unreached)?,
        };
        bench.knowledge.learned(need.id, Found::Known(met.clone()));
        Ok(met)
    }
}

/// Checks a need, and checks it again if others disturbed a transfer and the device seems to lack the feature: the
/// result holds for the whole run.
fn asked_undisturbed(bench: &mut Bench<'_>, need: &Need) -> Result<Met, Stop> {
    const TRIES: usize = 3;
    for _ in 0..TRIES {
        let before = bench.traffic.clients.collisions();
        let met = bench.unjudged(need.check);
        if bench.traffic.clients.collisions() == before || matches!(met, Ok(Ok(())) | Err(Stop::Error(_))) {
            return met;
        }
    }
    let actual = format!("other SDO clients disturbed {TRIES} tries");
    Err(Stop::Inconclusive(Reason::new(
        "the device can be asked for the feature that the case needs",
        need.text,
        actual,
    )))
}

impl PartialEq for Need {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Need {}

impl fmt::Debug for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::bench::{Options, Target};
    use crate::catalogue;
    use crate::scripted::{NODE, Row, dictionary, frame, test_case, with_bench, with_target};
    use canvass_analyzer::NodeId;
    use canvass_bus::observation::Observation;
    use canvass_traces::{Duration, Frame};
    use std::collections::BTreeMap;

    #[test]
    fn every_need_has_an_id_and_words_of_its_own() {
        let mut texts = BTreeMap::new();
        for need in catalogue::cases().into_iter().flat_map(|case| case.needs) {
            let known = *texts.entry(need.id).or_insert(need.text());
            assert_eq!(known, need.text(), "{need:?}");
        }
        let distinct: std::collections::BTreeSet<_> = texts.values().collect();
        assert!(texts.len() > 50 && distinct.len() == texts.len());
    }

    /// A device with a name of 14 bytes, which gives this answer to the initiate of a block upload.
    fn with_block_answer(answer: &'static str) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> {
        move |request| {
            let answer = match request.to_string().get(..10).unwrap_or_default() {
                "63F#400810" => "5BF#410810000E000000",
                "63F#A40810" => answer,
                "63F#600000" => "5BF#0043414E6F706E73",
                "63F#700000" => "5BF#1143414E6F706E73",
                _ => return Vec::new(),
            };
            vec![(Duration::from_millis(1), frame(answer))]
        }
    }

    /// The outcomes of three cases that need block uploads, one after the other: one of level open, then two of level
    /// must.
    fn outcomes(answer: &'static str) -> [Result<(), Stop>; 3] {
        const NEEDS: &[&Need] = &[&crate::needs::BLOCK_UPLOAD];
        let needs = |level| {
            let like = catalogue::find("301/sdo/block-upload/sized");
            let like = like.or_else(|| catalogue::cases().into_iter().find(|case| case.id.contains("/block-upload/")));
            Case { level, needs: NEEDS, ..*like.unwrap() }
        };
        let (open, must) = (needs(Level::Open), needs(Level::Must));
        let other = Case { id: "301/other", ..must };
        with_bench(with_block_answer(answer), |bench| [open, must, other].map(|case| case.require(bench)))
    }

    #[test]
    fn only_what_the_standard_gives_for_absent_is_absence() {
        for outcome in outcomes("5BF#8008100001000405") {
            assert!(matches!(outcome, Err(Stop::NotApplicable(_))), "{outcome:?}");
        }
        assert!(outcomes("5BF#C60810000E000000").iter().all(Result::is_ok));
    }

    /// The abort 0607 0013h for a correct request does not prove absence: it is a breach, of one case.
    #[test]
    fn any_other_refusal_is_a_breach_and_reported_once() {
        let [open, must, other] = outcomes("5BF#8008100013000706");
        assert!(matches!(open, Err(Stop::Inconclusive(_))), "{open:?}");
        let Err(Stop::Breach(breach)) = must else { panic!("{must:?}") };
        assert_eq!(breach.actual, Observation::Abort(canvass_analyzer::wire::sdo::AbortCode(0x0607_0013)));
        let Err(Stop::Inconclusive(reason)) = other else { panic!("{other:?}") };
        assert!(reason.actual.contains("block-upload"), "{reason}");
    }

    /// The result of a need on a device with this script and this description.
    pub fn asked(
        need: &'static Need,
        script: impl FnMut(&Frame) -> Vec<(Duration, Frame)> + 'static,
        target: &Target,
        options: &Options,
    ) -> Result<(), Stop> {
        let needs: &'static [&'static Need] = vec![need].leak();
        let case = Case { needs, ..test_case("test/needs", |_| Ok(())) };
        with_target(script, target, options, |bench| case.require(bench))
    }

    /// The reason why a device with this dictionary and without description does not meet a need; `None` if it does.
    pub(crate) fn unmet(need: &'static Need, rows: &[Row]) -> Option<String> {
        let target = Target::unknown(NodeId::new(NODE).unwrap());
        let asked = asked(need, dictionary(rows.to_vec()), &target, &Options::default());
        asked.err().map(|stop| stop.reason().actual)
    }

    /// Requires that the need is met if all of these objects exist (and are writable, if `written`), and that it is not
    /// met if one of them is absent.
    pub(crate) fn assert_needs(need: &'static Need, objects: &[(u16, u8)], written: bool) {
        let rows: Vec<Row> = objects.iter().map(|&at| (at, vec![0, 0], true)).collect();
        assert_eq!(unmet(need, &rows), None, "{need:?}");
        for missing in 0..rows.len() {
            let mut fewer = rows.clone();
            let ((index, sub), ..) = fewer.remove(missing);
            let why = unmet(need, &fewer).unwrap_or_default();
            assert!(why.contains(&format!("{index:04X}h:{sub:02X}")), "{need:?} without {index:04X}h:{sub:02X}: {why}");
            let mut fixed = rows.clone();
            fixed[missing].2 = false;
            assert_eq!(unmet(need, &fixed).is_some(), written, "{need:?} with {index:04X}h:{sub:02X} read-only");
        }
    }
}
