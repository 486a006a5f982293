//! The matrix of the selftest with the cases that failed on each fault. As JSON it is a [`SelftestResult`].

pub mod alone;
pub mod null;
pub mod wire;

use crate::results::selftest::{
    FalseAlarm, FaultBesideLiberties, FuzzedViolation, MissedCase, SelftestResult, Summary,
};
use crate::results::{self, Contract, Verdict, Word};
use canvass_device::{Fault, Liberties, Liberty};
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::liberties::{FuzzedLiberties, Sparing};
use canvass_fuzzer::reproducer;
use canvass_suite::case::Case;
use canvass_suite::selftest::{
    self, Chance, FaultRow, LibertyRow, Masked, Masking, Matrix, ModelRow, MotionRow, Moving,
};
use canvass_suite::verdict::{Kind, Reason};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn json(matrix: &Matrix, fuzzed: &Sparing, out: &mut dyn Write) -> io::Result<()> {
    let not_spared = fuzzed.rows().filter(|row| !row.violations.is_empty());
    let result = SelftestResult {
        combinations: matrix.sparing.combined.iter().map(liberty).collect(),
        fuzzed_not_spared: not_spared.map(violations).collect(),
        liberties: matrix.sparing.alone.iter().map(liberty).collect(),
        masked: matrix.masking.masked.iter().map(masked).collect(),
        matrix: matrix.faults.iter().map(fault).collect(),
        missed_beside_liberties: matrix.sparing.missed.iter().map(missed).collect(),
        missed_trembling: matrix.moving.missed.iter().map(|fault| fault.id().into()).collect(),
        models: matrix.models.iter().map(model).collect(),
        motions: matrix.moving.rows.iter().map(motion).collect(),
        schema: SelftestResult::SCHEMA.into(),
        summary: summary(matrix, fuzzed),
        vacuous_cases: ids(&matrix.vacuous_cases()),
    };
    results::write(&result, out)
}

fn summary(matrix: &Matrix, fuzzed: &Sparing) -> Summary {
    Summary {
        beside_deviations: matrix.masking.beside_deviations,
        beside_liberties: matrix.sparing.looked_for,
        cases: matrix.cases.len(),
        combinations: matrix.sparing.combined.len(),
        combinations_spared: matrix.sparing.combined.iter().filter(|row| row.is_spared()).count(),
        detected: matrix.detected(),
        false_alarms: matrix.false_alarms(),
        faults: matrix.faults.len(),
        fuzzed: fuzzed.rows().count(),
        fuzzed_exchanges: fuzzed.exchanges(),
        fuzzed_spared: fuzzed.spared(),
        liberties: matrix.sparing.alone.len(),
        masked: matrix.masking.masked.len(),
        missed_beside_liberties: matrix.sparing.missed.len(),
        missed_trembling: matrix.moving.missed.len(),
        models: matrix.models.len(),
        motions: matrix.moving.rows.len(),
        motions_spared: matrix.moving.spared(),
        put_beside_liberties: matrix.sparing.tried,
        spared: matrix.sparing.spared(),
        trembling: matrix.moving.tried,
        vacuous_cases: matrix.vacuous_cases().len(),
    }
}

fn ids(cases: &[&'static Case]) -> Vec<Word> {
    cases.iter().map(|case| case.id.into()).collect()
}

fn fault(row: &FaultRow) -> results::selftest::FaultRow {
    let missed = row.missed.iter().map(|(case, kind)| MissedCase { case: case.id.into(), verdict: Verdict(*kind) });
    results::selftest::FaultRow {
        detected: row.is_detected(),
        failed: ids(&row.failed),
        fault: row.fault.id().into(),
        missed: missed.collect(),
        model: row.model.into(),
        unrelated: ids(&row.unrelated),
    }
}

fn masked(row: &Masked) -> results::selftest::Masked {
    let (case, fault, model) = (row.case.id.into(), row.fault.id().into(), row.model.into());
    results::selftest::Masked { case, fault, model, verdict: Verdict(row.kind) }
}

fn names(liberties: Liberties) -> Vec<&'static str> {
    liberties.iter().map(Liberty::id).collect()
}

fn words(liberties: Liberties) -> Vec<Word> {
    liberties.iter().map(|liberty| liberty.id().into()).collect()
}

fn missed((fault, liberties): &(Fault, Liberties)) -> FaultBesideLiberties {
    FaultBesideLiberties { fault: fault.id().into(), liberties: words(*liberties) }
}

fn false_alarms(alarms: &[(&'static Case, Kind, Reason)]) -> Vec<FalseAlarm> {
    let alarm = |(case, kind, reason): &(&Case, Kind, Reason)| FalseAlarm {
        case: case.id.into(),
        reason: reason.to_string(),
        verdict: Verdict(*kind),
    };
    alarms.iter().map(alarm).collect()
}

fn liberty(row: &LibertyRow) -> results::selftest::Liberties {
    results::selftest::Liberties {
        executed: row.executed,
        false_alarms: false_alarms(&row.alarms),
        liberties: words(row.liberties),
        model: row.model.into(),
    }
}

fn motion(row: &MotionRow) -> results::selftest::Motion {
    results::selftest::Motion {
        executed: row.executed,
        false_alarms: false_alarms(&row.alarms),
        model: row.model.into(),
        motion: row.motion.clone().into(),
        start: row.start,
    }
}

fn violations(row: &FuzzedLiberties) -> results::selftest::FuzzedLiberties {
    let violations = row.violations.iter().map(violation).collect();
    results::selftest::FuzzedLiberties { liberties: words(row.liberties), model: row.model.into(), violations }
}

fn violation(found: &Found) -> FuzzedViolation {
    let violation = &found.violation;
    FuzzedViolation {
        actual: violation.actual.to_string(),
        expected: violation.expected.to_string(),
        log: reproducer::candump(&found.sequence),
        property: violation.property.id().into(),
        rule: violation.rule.into(),
    }
}

fn model(row: &ModelRow) -> results::selftest::ModelRow {
    let (executed, false_alarms, model) = (row.executed, false_alarms(&row.alarms), row.model.into());
    results::selftest::ModelRow { executed, false_alarms, model }
}

/// The matrix for people: a line for each fault with the cases that failed on it, then the errors of the catalogue,
/// then the counts.
pub fn text(matrix: &Matrix, fuzzed: &Sparing) -> String {
    let mut text = String::new();
    for row in &matrix.faults {
        let sign = if row.is_detected() { '✓' } else { '✗' };
        line(&mut text, &format!("{sign} {} on {}", row.fault, row.model));
        for case in &row.failed {
            let named = if case.catches.contains(&row.fault) { "" } else { "  (does not name it)" };
            line(&mut text, &format!("    {}{named}", case.id));
        }
    }
    line(&mut text, "");
    wrong_lines(&mut text, matrix);
    let (faults, detected) = (matrix.faults.len(), matrix.detected());
    let share = (detected * 100).checked_div(faults).unwrap_or(0);
    line(&mut text, &format!("{detected} of {faults} faults detected ({share} %) by {} cases", matrix.cases.len()));
    masked_lines(&mut text, &matrix.masking);
    sparing_lines(&mut text, &matrix.sparing, fuzzed);
    moving_lines(&mut text, &matrix.moving);
    masking_line(&mut text, &matrix.masking);
    let (alarms, vacuous, models) = (matrix.false_alarms(), matrix.vacuous_cases().len(), matrix.models.len());
    line(&mut text, &format!("{alarms} false alarms on {models} models and {faults} faults, {vacuous} vacuous cases"));
    text
}

/// Appends the errors of the catalogue: missed faults, false alarms, and cases that never fail.
fn wrong_lines(text: &mut String, matrix: &Matrix) {
    for row in &matrix.faults {
        for (case, kind) in &row.missed {
            line(text, &format!("missed: {} does not fail on {} but ends with {kind}", case.id, row.fault));
        }
        for case in &row.unrelated {
            line(text, &format!("false alarm: {} fails on {}, which is not its matter", case.id, row.fault));
        }
    }
    for row in &matrix.models {
        for (case, kind, reason) in &row.alarms {
            line(text, &format!("false alarm: {}: {} ends with {kind}: {reason}", row.model, case.id));
        }
    }
    for case in matrix.vacuous_cases() {
        line(text, &format!("vacuous: {} fails on no fault", case.id));
    }
}

fn masked_lines(text: &mut String, masking: &Masking) {
    for Masked { model, fault, case, kind } in &masking.masked {
        line(text, &format!("masked: {fault} on {model}: {} ends with {kind}", case.id));
    }
}

fn masking_line(text: &mut String, masking: &Masking) {
    let Masking { shown, tried, beside_deviations, masked } = masking;
    let hidden = masked.len();
    line(
        text,
        &format!(
            "{shown} of {tried} pairs of fault and case on models that deviate show, {beside_deviations} beside a deviation; \
             {hidden} hidden by one"
        ),
    );
}

/// Appends the results of suite and fuzzer for liberties, and for faults in addition to liberties.
fn sparing_lines(text: &mut String, sparing: &selftest::Sparing, fuzzed: &Sparing) {
    for row in sparing.alone.iter().chain(&sparing.combined) {
        let taken = names(row.liberties).join(", ");
        for (case, kind, reason) in &row.alarms {
            line(text, &format!("not spared: {taken} on {}: {} ends with {kind}: {reason}", row.model, case.id));
        }
    }
    for (fault, liberties) in &sparing.missed {
        line(text, &format!("missed: {fault} beside {}", names(*liberties).join(", ")));
    }
    let combined = sparing.combined.iter().filter(|row| row.is_spared()).count();
    let (spared, alone, random) = (sparing.spared(), sparing.alone.len(), sparing.combined.len());
    let together = Chance::TOGETHER;
    line(
        text,
        &format!(
            "specificity: {spared} of {alone} liberties spared, {combined} of {random} random combinations of {together}"
        ),
    );
    fuzzed_lines(text, fuzzed);
    let (looked_for, hidden) = (sparing.looked_for, sparing.tried - sparing.looked_for);
    let found = looked_for - sparing.missed.len();
    line(
        text,
        &format!(
            "sensitivity beside random liberties: {found} of {looked_for} faults found; {hidden} did not show there"
        ),
    );
}

/// Appends the results for devices that move.
fn moving_lines(text: &mut String, moving: &Moving) {
    for row in &moving.rows {
        for (case, kind, reason) in &row.alarms {
            let place = format!("{} {} from position {}", row.model, row.motion, row.start);
            line(text, &format!("not spared: {place}: {} ends with {kind}: {reason}", case.id));
        }
    }
    for fault in &moving.missed {
        line(text, &format!("missed: {fault} on a trembling device"));
    }
    let (spared, all, tried) = (moving.spared(), moving.rows.len(), moving.tried);
    let found = tried - moving.missed.len();
    line(text, &format!("motion: {spared} of {all} motions spared, {found} of {tried} faults found while trembling"));
}

/// Appends the results of the fuzzer for liberties.
fn fuzzed_lines(text: &mut String, fuzzed: &Sparing) {
    for row in fuzzed.rows() {
        let taken = names(row.liberties).join(", ");
        for found in &row.violations {
            let violation = &found.violation;
            let (property, rule) = (violation.property, violation.rule);
            let what = format!("expected {}, found {}", violation.expected, violation.actual);
            line(text, &format!("not spared by the fuzzer: {taken} on {}: {property} {rule}: {what}", row.model));
        }
    }
    let rows = fuzzed.rows().count();
    line(
        text,
        &format!(
            "specificity of the fuzzer: {} of {rows} liberties and combinations spared in {} exchanges",
            fuzzed.spared(),
            fuzzed.exchanges()
        ),
    );
}

fn line(text: &mut String, line: &str) {
    // Writing to a string can't fail.
    let _ = writeln!(text, "{line}");
}
