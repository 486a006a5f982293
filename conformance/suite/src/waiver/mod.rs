//! The waiver file: breaches that the user of a device accepts, each with a reason.
//!
//! ```toml
//! [[waiver]]
//! case = "301/pdo/mapping/*"              # an id or a pattern with *, or a list of them
//! object = "1A00:01"                      # the subject of the breach, as reports name it; * for any
//! does = "abort 0604 0041h"               # the behaviour of the device, as reports name it
//! reason = "mapping is fixed, ticket 4711"
//! owner = "Ann"                           # optional: the person who answers for the waiver
//! expires = 2027-06-30                    # optional: the last day on which the waiver holds
//!
//! [[waiver]]
//! situation = "read-only"                 # in place of the case: wherever cases meet the situation
//! object = "*"
//! does = "abort 0800 0000h"
//! reason = "one code for all refusals, ticket 4712"
//! ```
//!
//! [`Quarantine`]s are in the same file. A waiver excuses the behaviour `does` of the object `object` in the case
//! `case` or the situation `situation`; the verdict is then *deviation*. All other breaches still fail the case. A waiver
//! for a case or a situation that does not exist is an error, and so is one that names neither a case, a situation nor
//! an object.
//! A waiver that excused nothing, or has expired, is reported with the actual findings: waivers must not outlive their
//! purpose.

mod checked;
mod suggested;

pub use checked::{Checked, Found, Use};
pub use suggested::suggested;

use crate::catalogue;
use crate::glob;
use crate::quarantine::{self, Quarantine, day};
use crate::runner::CaseReport;
use crate::situation::Situation;
use crate::verdict::{Authority, Deviation, Grade};
use canvass_bus::observation::{BadPattern, BadSubject, Pattern, Subject};
use serde::Deserialize;
use std::collections::BTreeSet;
use toml::Spanned;
use toml::value::Datetime;

/// Maximum number of other breaches that are named for a waiver that excused nothing.
const SHOWN: usize = 3;

/// The waivers of a file.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Waivers {
    waivers: Vec<Waiver>,
    quarantines: Vec<Quarantine>,
}

/// A waiver.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Waiver {
    /// The line at which the waiver begins, from 1.
    pub line: usize,
    /// The ids of cases, or patterns with `*`.
    pub cases: Vec<String>,
    /// The subject of the breach; `None` for any.
    pub subject: Option<Subject>,
    /// The situation of the breach; `None` for any.
    pub situation: Option<Situation>,
    /// The behaviour of the device.
    pub does: Pattern,
    /// The reason why the user accepts the breach.
    pub reason: String,
    /// The person who answers for the waiver.
    pub owner: Option<String>,
    /// The last day of the waiver, `YYYY-MM-DD`.
    pub expires: Option<String>,
}

/// An error in a waiver file.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct BadWaiver {
    /// The line, counted from 1.
    pub line: usize,
    /// The expected content and the actual one.
    pub problem: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    waiver: Vec<Spanned<WaiverRow>>,
    #[serde(default)]
    quarantine: Vec<Spanned<quarantine::QuarantineRow>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WaiverRow {
    case: Option<OneOrMore>,
    situation: Option<String>,
    object: String,
    does: String,
    reason: String,
    owner: Option<String>,
    expires: Option<Datetime>,
}

/// A text, or a list of texts.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl Waivers {
    /// Reads a waiver file.
    ///
    /// # Errors
    /// [`BadWaiver`] with the line: invalid TOML, an unknown or missing key, an empty reason, a case that does not
    /// exist, an invalid date or object.
    pub fn read(text: &str) -> Result<Self, BadWaiver> {
        let file: File = toml::from_str(text).map_err(|error| BadWaiver {
            line: error.span().map_or(1, |span| line_of(text, span.start)),
            problem: error.message().to_owned(),
        })?;
        let waivers = file.waiver.into_iter().map(|row| {
            let line = line_of(text, row.span().start);
            waiver(line, row.into_inner()).map_err(|problem| BadWaiver { line, problem })
        });
        let quarantines = file.quarantine.into_iter().map(|row| {
            let line = line_of(text, row.span().start);
            let known = |read: Quarantine| catalogue::expect(&read.case).map(|()| read);
            row.into_inner().read(line).and_then(known).map_err(|problem| BadWaiver { line, problem })
        });
        Ok(Self { waivers: waivers.collect::<Result<_, _>>()?, quarantines: quarantines.collect::<Result<_, _>>()? })
    }

    /// The deviations that the waivers explain on this day (`YYYY-MM-DD`), without expired ones.
    pub fn deviations(&self, today: &str) -> Vec<Deviation> {
        let valid = self.waivers.iter().filter(|waiver| !waiver.has_expired(today));
        valid.map(Waiver::deviation).collect()
    }

    /// The quarantines that hold on this day.
    pub fn quarantines(&self, today: &str) -> Vec<Quarantine> {
        self.quarantines.iter().filter(|quarantine| !quarantine.has_expired(today)).cloned().collect()
    }

    /// A sentence about each waiver that excused nothing in a run, because it has expired, or because the cases found
    /// no breach or another one; and about each quarantine that is over.
    pub fn idle(&self, today: &str, reports: &[&CaseReport]) -> Vec<String> {
        let used: BTreeSet<usize> = reports.iter().flat_map(|report| waivers_of(report)).collect();
        let idle = self.waivers.iter().filter(|waiver| !used.contains(&waiver.line));
        let over = self.quarantines.iter().filter(|quarantine| quarantine.has_expired(today));
        let over = over.filter(|over| reports.iter().any(|report| glob::matches(&over.case, report.case.id)));
        let over = over.map(|Quarantine { case, line, until, owner, .. }| {
            format!(
                "the quarantine of {case} (line {line}, {owner}) has expired on {until}: failures of the case count"
            )
        });
        idle.filter_map(|waiver| waiver.why_idle(today, reports)).chain(over).collect()
    }
}

/// The lines of the waivers that excuse something in a report.
fn waivers_of(report: &CaseReport) -> impl Iterator<Item = usize> {
    report.verdict.breaches().iter().filter_map(|ruled| match ruled.excuse.as_ref()?.by {
        Authority::Waiver { line } => Some(line),
        Authority::Manual => None,
    })
}

impl Waiver {
    fn has_expired(&self, today: &str) -> bool {
        self.expires.as_deref().is_some_and(|last| last < today)
    }

    /// The reason why the waiver excused nothing; `None` if none of its cases ran.
    fn why_idle(&self, today: &str, reports: &[&CaseReport]) -> Option<String> {
        let (line, does) = (self.line, &self.does);
        let this = format!("the waiver for {} (line {line})", self.place());
        if self.has_expired(today) {
            return Some(format!("{this} has expired on {}", self.expires.as_deref().unwrap_or_default()));
        }
        let ran = |report: &&&CaseReport| report.verdict.kind().is_executed() && self.is_for(report.case.id);
        let ran: Vec<_> = reports.iter().filter(ran).collect();
        if ran.is_empty() {
            return None;
        }
        let found = ran.iter().flat_map(|report| report.verdict.breaches());
        let wrong = found.filter(|ruled| ruled.breach.grade == Grade::Wrong);
        let mut others: Vec<String> =
            wrong.map(|ruled| format!("{}: {}", ruled.breach.subject, ruled.breach.actual)).collect();
        others.dedup();
        if others.is_empty() {
            return Some(format!("{this} was not needed: no breach was found"));
        }
        let more = others.len().saturating_sub(SHOWN);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        others.truncate(SHOWN);
        let others = others.join("; ");
        let subject = self.subject_text();
        Some(format!("{this} excused no breach: it accepts {subject}: {does}; found: {others}{more}"))
    }

    /// Whether the waiver is for a case, perhaps among others.
    fn is_for(&self, case: &str) -> bool {
        self.cases.iter().any(|pattern| glob::matches(pattern, case))
    }

    /// Where the waiver holds, in words: `301/pdo/mapping/*`, `the situation read-only`.
    fn place(&self) -> String {
        let cases = self.cases.join(", ");
        match self.situation {
            Some(situation) if cases == "*" => format!("the situation {}", situation.id()),
            Some(situation) => format!("{cases} in the situation {}", situation.id()),
            None => cases,
        }
    }

    fn subject_text(&self) -> String {
        self.subject.map_or_else(|| "any object".to_owned(), |subject| subject.to_string())
    }

    fn deviation(&self) -> Deviation {
        let owner = self.owner.as_ref().map(|owner| format!(", {owner}")).unwrap_or_default();
        let until = self.expires.as_ref().map(|day| format!(", until {day}")).unwrap_or_default();
        Deviation {
            cases: self.cases.clone(),
            subject: self.subject,
            situation: self.situation,
            does: self.does.clone(),
            documented: format!("waived: {} (line {}{owner}{until})", self.reason, self.line),
            by: Authority::Waiver { line: self.line },
        }
    }
}

fn waiver(line: usize, row: WaiverRow) -> Result<Waiver, String> {
    let WaiverRow { case, situation, object, does, reason, owner, expires } = row;
    if reason.trim().is_empty() {
        return Err("expected a reason: a waiver says why the breach is accepted".to_owned());
    }
    let cases = match case {
        Some(OneOrMore::One(case)) => vec![case],
        Some(OneOrMore::More(cases)) => cases,
        None => vec!["*".to_owned()],
    };
    if cases.is_empty() {
        return Err("expected a case: the list is empty".to_owned());
    }
    cases.iter().try_for_each(|case| catalogue::expect(case))?;
    let situation = situation.map(|id| situation_of(&id)).transpose()?;
    let subject = match &*object {
        "*" => None,
        object => Some(object.parse().map_err(|error: BadSubject| error.to_string())?),
    };
    if situation.is_none() && cases.iter().any(|case| case == "*") {
        return Err("expected a case or a situation: a waiver must not excuse a behaviour everywhere".to_owned());
    }
    let does = does.parse().map_err(|error: BadPattern| error.to_string())?;
    let expires = expires.map(day).transpose()?;
    Ok(Waiver { line, cases, subject, situation, does, reason, owner, expires })
}

fn situation_of(id: &str) -> Result<Situation, String> {
    let unknown = || format!("no situation is called \"{id}\": `canvass list situations` shows them");
    Situation::by_id(id).ok_or_else(unknown)
}

/// The line of a byte position, from 1.
fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Evidence;
    use crate::verdict::{Breach, Excuse, Kind, Ruled, Verdict};
    use canvass_bus::observation::Observation;
    use canvass_traces::Duration;

    const FILE: &str = "# ours\n\n[[waiver]]\ncase = \"301/heartbeat/*\"\nobject = \"heartbeat\"\n\
        does = \"time 90 ms..110 ms\"\nreason = \"slow timer\"\n\n\
        [[waiver]]\ncase = \"301/identity/names\"\nobject = \"1008\"\ndoes = \"value *\"\nreason = \"ticket 7\"\n\
        expires = 2027-06-30\n";

    fn breach(subject: &str) -> Breach {
        Breach::new(subject.parse::<Subject>().unwrap(), "it is printable").found(Observation::Value(vec![7]))
    }

    fn report(ruled: Vec<Ruled>) -> CaseReport {
        CaseReport {
            case: catalogue::find("301/identity/names").unwrap(),
            verdict: Verdict::new(ruled, None),
            evidence: Evidence::default(),
            notes: Vec::new(),
            foreign: Vec::new(),
            measurements: Vec::new(),
            uses: Vec::new(),
            outcomes: Vec::new(),
            quarantine: None,
            duration: Duration::ZERO,
        }
    }

    #[test]
    fn a_quarantine_holds_until_its_day_and_is_told_of_afterwards() {
        let row =
            "[[quarantine]]\ncase = \"301/identity/*\"\nowner = \"Ann\"\nreason = \"ticket 12\"\nuntil = 2027-06-30\n";
        let waivers = Waivers::read(row).unwrap();
        let held = |today| waivers.quarantines(today).into_iter().next();
        assert!(held("2027-07-01").is_none());
        let quarantine = held("2027-06-30").unwrap();
        assert_eq!(quarantine.to_string(), "in quarantine until 2027-06-30 (Ann): ticket 12");
        assert!(quarantine.holds("301/identity/names", Kind::Fail) && !quarantine.holds("301/nmt/order", Kind::Fail));
        assert!(!quarantine.holds("301/identity/names", Kind::Pass));
        assert!(waivers.idle("2027-06-30", &[&report(Vec::new())]).is_empty());
        assert!(waivers.idle("2027-07-01", &[&report(Vec::new())])[0].contains("has expired on 2027-06-30"));
        let other = CaseReport { case: catalogue::find("301/nmt/back-to-back").unwrap(), ..report(Vec::new()) };
        assert_eq!(waivers.idle("2027-07-01", &[&other, &report(Vec::new())]).len(), 1);
        assert!(waivers.idle("2027-07-01", &[&other]).is_empty(), "its case did not run");
        for (from, to, says) in [
            ("owner = \"Ann\"\n", "", "missing field `owner`"),
            ("until = 2027-06-30\n", "", "missing field `until`"),
            ("\"Ann\"", "\"\"", "expected a reason and an owner"),
            ("identity", "idenity", "canvass list cases"),
            ("2027-06-30", "12:00:00", "expected a day"),
        ] {
            let error = Waivers::read(&row.replace(from, to)).unwrap_err();
            assert!(error.line == 1 && error.problem.contains(says), "{to}: {error}");
        }
    }

    #[test]
    fn waivers_explain_their_cases_until_they_expire() {
        let waivers = Waivers::read(FILE).unwrap();
        let names = catalogue::find("301/identity/names").unwrap();
        let explains = |today: &str, breach: &Breach| {
            waivers.deviations(today).iter().any(|deviation| deviation.explains(names.id, breach))
        };
        assert!(explains("2027-06-30", &breach("1008:00")));
        assert!(!explains("2027-06-30", &breach("1009:00")), "another object");
        assert!(!explains("2027-06-30", &breach("1008:00").found(Observation::Silence)), "another behaviour");
        assert!(!explains("2027-07-01", &breach("1008:00")), "expired");
        assert_eq!(waivers.deviations("2027-01-01")[1].by, Authority::Waiver { line: 9 });
    }

    #[test]
    fn a_waiver_that_excused_nothing_says_why() {
        let waivers = Waivers::read(FILE).unwrap();
        let idle = |today: &str, ruled: Vec<Ruled>| waivers.idle(today, &[&report(ruled)]);
        let excuse = Some(Excuse { documented: String::new(), by: Authority::Waiver { line: 9 } });
        assert!(idle("2027-01-01", vec![Ruled { breach: breach("1008:00"), excuse }]).is_empty());
        assert!(idle("2027-01-01", Vec::new())[0].ends_with("was not needed: no breach was found"));
        let other = Ruled { breach: breach("1009:00"), excuse: None };
        assert!(idle("2027-01-01", vec![other])[0].ends_with("accepts 1008h: value *; found: 1009h:00: value 07"));
        assert!(idle("2028-01-01", Vec::new())[0].contains("expired on 2027-06-30"));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let with = |from: &str, to: &str| Waivers::read(&FILE.replace(from, to)).unwrap_err();
        for (from, to, line, says) in [
            ("\"slow timer\"", "\" \"", 3, "expected a reason"),
            ("reason = \"slow timer\"\n", "", 3, "missing field `reason`"),
            ("does = \"value *\"\n", "", 9, "missing field `does`"),
            ("\"value *\"", "\"*\"", 9, "expected what the device does"),
            ("301/identity/names", "301/identity/nmaes", 9, "canvass list cases"),
            ("expires =", "until =", 14, "unknown field `until`"),
            ("2027-06-30", "12:00:00", 9, "expected a day"),
            ("\"1008\"", "\"name\"", 9, "expected an object"),
            ("case = \"301/heartbeat/*\"", "case = \"301", 4, ""),
        ] {
            let error = with(from, to);
            assert!(error.line == line && error.problem.contains(says), "{to}: {error}");
        }
    }

    /// The actual breaches are named, at most three, each once; a case that did not run to its end does not count.
    #[test]
    fn what_was_found_instead_is_named() {
        let waivers = Waivers::read(FILE).unwrap();
        let wrong = |subject: &str| Ruled { breach: breach(subject), excuse: None };
        let found = |subjects: &[&str]| {
            let report = report(subjects.iter().map(|subject| wrong(subject)).collect());
            let told = waivers.idle("2027-01-01", &[&report]);
            assert_eq!(told.len(), 1, "the other waiver's case did not run: {told:?}");
            told[0].split("found: ").nth(1).unwrap().to_owned()
        };
        assert_eq!(found(&["1009:00", "1009:00"]), "1009h:00: value 07");
        let three = "1009h:00: value 07; 100Ah:00: value 07; 100Bh:00: value 07";
        assert_eq!(found(&["1009:00", "100A:00", "100B:00"]), three);
        assert_eq!(found(&["1009:00", "100A:00", "100B:00", "100C:00"]), format!("{three} and 1 more"));
        let tolerated = Ruled { breach: breach("1009:00").tolerated(), excuse: None };
        let told = waivers.idle("2027-01-01", &[&report(vec![tolerated])]);
        assert!(told[0].ends_with("no breach was found"), "{told:?}");
        let ended =
            CaseReport { verdict: Verdict::inconclusive(crate::verdict::Reason::default()), ..report(Vec::new()) };
        assert_eq!(waivers.idle("2027-01-01", &[&ended]), Vec::<String>::new());
        assert_eq!(waivers.idle("2027-01-01", &[]), Vec::<String>::new());
        // An excuse by the manual is not one by the waiver, even for the same breach.
        let excuse = Some(Excuse { documented: String::new(), by: Authority::Manual });
        let by_manual = report(vec![Ruled { breach: breach("1008:00"), excuse }]);
        assert_eq!(waivers.idle("2027-01-01", &[&by_manual]).len(), 1);
    }

    /// Reports state who accepts a breach, until when, and why.
    #[test]
    fn who_accepts_a_breach_is_told() {
        let documented = |more: &str| {
            let file = format!("{}{more}", FILE.split("expires").next().unwrap());
            Waivers::read(&file).unwrap().deviations("2027-01-01")[1].documented.clone()
        };
        assert_eq!(documented(""), "waived: ticket 7 (line 9)");
        assert_eq!(documented("owner = \"Ann\"\n"), "waived: ticket 7 (line 9, Ann)");
        assert_eq!(
            documented("owner = \"Ann\"\nexpires = 2027-06-30\n"),
            "waived: ticket 7 (line 9, Ann, until 2027-06-30)"
        );
    }
}
