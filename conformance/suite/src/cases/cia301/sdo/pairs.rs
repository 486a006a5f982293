//! Ordered pairs of SDO transfers: the remains of one transfer must not change the next.

use super::transfers::{End, Form, Subjects};
use crate::bench::Bench;
use crate::case;
use crate::verdict::{Breach, Judged, Stop, When, tried};
use canvass_analyzer::wire::nmt::Command;
use canvass_bus::observation::Observation;
use canvass_traces::Duration;

/// Time for the pairs on a live bus; further pairs are left out, unless the user wants all.
const LIVE: Duration = Duration::from_millis(2_500);

/// A transfer that follows another one.
#[derive(Clone, Copy, Debug)]
struct Pair {
    first: (Form, End),
    second: Form,
    /// Whether both transfers use the same object.
    same: bool,
}

impl Pair {
    /// All ordered pairs of these forms. The transfers of every second pair use the same object, those of the others two
    /// objects. If `all` is set, each pair occurs in both ways.
    fn all(forms: &[Form], all: bool, counts: impl Fn(Form, Form) -> bool) -> Vec<Self> {
        let firsts = forms.iter().flat_map(|form| form.ends().iter().map(|end| (*form, *end)));
        let seconds = |first| forms.iter().map(move |second| (first, *second));
        let pairs = firsts.flat_map(seconds).filter(|((first, _), second)| counts(*first, *second));
        let both = |(number, (first, second))| {
            let pair = move |same| Self { first, second, same };
            [true, false].into_iter().filter(move |same| all || (number % 2 == 0) == *same).map(pair)
        };
        let mut pairs: Vec<Self> = pairs.enumerate().flat_map(both).collect();
        // If the time is short, pairs of the usual variants come first.
        pairs.sort_by_key(|pair| pair.first.0.is_variant() as u8 + pair.second.is_variant() as u8);
        pairs
    }
}

/// A transfer works after every other transfer: expedited and segmented ones in both directions, with and without a
/// stated size, of the same object and of another one, whether the transfer before ended, was aborted by the client or
/// by the server, or was abandoned.
///
/// After an abandoned transfer the server may refuse one request. A kind of transfer that the server does not serve at
/// all is judged by the case for it.
#[case(id = "301/sdo/transfer/pairs", clause = "CiA 301 7.2.4.2.1", confidence = Cited, level = Must,
       needs = [ScratchObject, SegmentedDownload], catches = [SdoDownloadRefusedAfterUpload, SdoStaleSizeExpected])]
fn pairs(bench: &mut Bench<'_>) -> Judged {
    every_pair(bench, &Form::PLAIN, |_, _| true)
}

/// A transfer works after every other transfer, if one of them is a block transfer: with and without CRC and stated
/// size, of the same object and of another one, whether the transfer before ended, was aborted by the client or by the
/// server, or was abandoned.
///
/// After an abandoned transfer the server may refuse one request. A kind of transfer that the server does not serve at
/// all is judged by the case for it.
#[case(id = "301/sdo/transfer/block-pairs", clause = "CiA 301 7.2.4.2.1", confidence = Cited, level = Must,
       needs = [ScratchObject, BlockUpload, BlockDownload],
       catches = [SdoBlockDownloadWritesUpload, SdoBlockDownloadKeepsUpload, SdoBlockUploadSurvivesRefusal])]
fn block_pairs(bench: &mut Bench<'_>) -> Judged {
    every_pair(bench, &Form::ALL, |first, second| first.is_block() || second.is_block())
}

fn every_pair(bench: &mut Bench<'_>, forms: &[Form], counts: impl Fn(Form, Form) -> bool) -> Judged {
    let mut subjects = Subjects::find(bench)?;
    let served = served(bench, &mut subjects, forms)?;
    // Uploads alone could follow each other even on a device that accepts no download.
    tried(served.iter().filter(|form| form.is_download()).count(), "a kind of download that the server serves")?;
    let pairs = Pair::all(&served, bench.options().exhaustive, counts);
    let (begun, mut count) = (bench.now(), 0);
    for pair in &pairs {
        let is_late = bench.is_live() && !bench.options().exhaustive && bench.now().since(begun) > LIVE;
        if is_late {
            break;
        }
        if !has_first(bench, &mut subjects, *pair)? {
            continue;
        }
        count += 1;
        match judge_second(bench, &mut subjects, *pair) {
            Err(Stop::Breach(breach)) => {
                bench.check(Err(breach))?;
                // The next pair must not begin with the remains of this pair.
                subjects.settle(bench)?;
            }
            other => other?,
        }
    }
    bench.note(format!("{count} of {} ordered pairs of {} kinds of transfers", pairs.len(), served.len()));
    tried(count, "two kinds of transfers that follow each other")
}

/// The forms that the server serves, at least as the first transfers after a start. A server that accepts a transfer and
/// carries it out wrongly has a breach even then.
fn served(bench: &mut Bench<'_>, subjects: &mut Subjects, forms: &[Form]) -> Result<Vec<Form>, Stop> {
    let mut served = Vec::new();
    let allowed: Vec<Form> = forms.iter().copied().filter(|form| subjects.allow(*form)).collect();
    for form in allowed {
        let mut failed = failed(bench, subjects, form)?;
        if failed.is_some() {
            // The remains of an earlier transfer must not hide that the server serves this one.
            bench.make_server_idle();
            bench.reset(Command::RESET_NODE)?;
            subjects.settle(bench)?;
            failed = self::failed(bench, subjects, form)?;
        }
        let Some(breach) = failed else {
            served.push(form);
            continue;
        };
        if matches!(breach.actual, Observation::Abort(_)) {
            bench.note(format!("{form}: the server does not serve it, so no pair contains it"));
        } else {
            bench.check(Err(breach))?;
        }
        subjects.settle(bench)?;
    }
    Ok(served)
}

/// The breach of a transfer on one object; `None` if the server serves it. A transfer on the other object, which may have
/// another length, would already be the second of a pair.
fn failed(bench: &mut Bench<'_>, subjects: &mut Subjects, form: Form) -> Result<Option<Box<Breach>>, Stop> {
    match bench.unjudged(|bench| subjects.complete(bench, form, 0)) {
        Err(Stop::Breach(breach)) => Ok(Some(breach)),
        outcome => outcome.map(|_| None),
    }
}

/// Brings the first transfer of a pair to its end; `false` if the first transfer fails. Other pairs, in which the same
/// transfer is the second, judge such a failure.
fn has_first(bench: &mut Bench<'_>, subjects: &mut Subjects, pair: Pair) -> Result<bool, Stop> {
    let (form, end) = pair.first;
    match bench.unjudged(|bench| subjects.end(bench, form, end, 0)) {
        Err(Stop::Inconclusive(_) | Stop::Breach(_)) if !bench.is_cancelled() => {
            subjects.settle(bench)?;
            Ok(false)
        }
        ended => ended.map(|()| true),
    }
}

fn judge_second(bench: &mut Bench<'_>, subjects: &mut Subjects, pair: Pair) -> Judged {
    let (_, end) = pair.first;
    let object = usize::from(!pair.same);
    match subjects.complete(bench, pair.second, object) {
        Err(Stop::Breach(breach)) if end == End::Abandoned => {
            // A server may take the request for the end of the abandoned transfer. Its own abort ends that transfer
            // (7.2.4.2.16), so that a client that knows nothing of it may simply ask again.
            if !matches!(breach.actual, Observation::Abort(_)) {
                subjects.settle(bench)?;
            }
            subjects.complete(bench, pair.second, object)
        }
        outcome => outcome,
    }
    .map(|_| ())
    .map_err(|stop| named(stop, pair))
}

/// Adds the transfer before to the words of a breach.
fn named(stop: Stop, pair: Pair) -> Stop {
    let Stop::Breach(breach) = stop else { return stop };
    let (form, end) = pair.first;
    let object = if pair.same { "the same object" } else { "another object" };
    let duty = format!("{}, after {form} of {object} {end}", breach.duty());
    let detail = breach.detail.clone().unwrap_or_default();
    let named = Breach { situation: When::Own(duty.into()), ..*breach };
    Stop::Breach(Box::new(if detail.is_empty() { named } else { named.told(detail) }))
}
