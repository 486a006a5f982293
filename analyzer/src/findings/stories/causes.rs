//! Cause and effect between groups of findings.

use super::groups::Group;
use crate::findings::effect::{Effect, Kinds, Nodes, SETTLE, Time};
use canvass_traces::Timestamp;

/// The index of each group's cause; `None` for a group without a cause.
pub fn of(groups: &[Group<'_>]) -> Vec<Option<usize>> {
    let mut causes: Vec<Option<usize>> = vec![None; groups.len()];
    for (at, effect) in groups.iter().enumerate() {
        let possible = groups
            .iter()
            .enumerate()
            .filter(|(other, cause)| *other != at && cause.channel == effect.channel && follows(effect, cause));
        // Of several possible causes, the cause with the highest rank is taken; among equal ranks, the one that began
        // last before the effect.
        let best = possible.min_by_key(|(_, cause)| (cause.rank(), effect.first().since(cause.first())));
        causes[at] = best.map(|(cause, _)| cause);
    }
    for at in 0..groups.len() {
        if is_circle(&causes, at) {
            causes[at] = None;
        }
    }
    link(groups, &mut causes);
    causes
}

/// Links causes and effects through a third group: a node is lost, its consumer notices, sends an EMCY, and leaves
/// operational. All these findings stay in one story.
fn link(groups: &[Group<'_>], causes: &mut [Option<usize>]) {
    let orders: Vec<_> = groups.iter().map(|group| (group.first(), group.rank())).collect();
    for (at, effect) in groups.iter().enumerate() {
        let Some(cause) = causes[at] else { continue };
        let story = root(causes, cause);
        let between = (0..groups.len()).filter(|&other| {
            let is_between = orders[cause] < orders[other] && orders[other] < orders[at];
            let group = &groups[other];
            is_between
                && group.channel == effect.channel
                && follows(effect, group)
                && root(causes, other) == story
                && !leads_to(causes, other, at)
        });
        if let Some(last) = between.max_by_key(|other| orders[*other]) {
            causes[at] = Some(last);
        }
    }
}

/// Whether the group `cause` is among the direct or indirect causes of the group `effect`.
fn leads_to(causes: &[Option<usize>], effect: usize, cause: usize) -> bool {
    let chain = std::iter::successors(Some(effect), |at| causes[*at]);
    chain.take(causes.len()).any(|at| at == cause)
}

/// The group from which all others of a story follow.
pub fn root(causes: &[Option<usize>], at: usize) -> usize {
    let mut root = at;
    for _ in 0..causes.len() {
        match causes[root] {
            Some(cause) => root = cause,
            None => break,
        }
    }
    root
}

fn is_circle(causes: &[Option<usize>], at: usize) -> bool {
    causes[root(causes, at)].is_some()
}

/// Whether one group is an effect of another.
fn follows(effect: &Group<'_>, cause: &Group<'_>) -> bool {
    let own = effect.rule.follows.iter().filter(|(id, _)| *id == cause.rule.id);
    if own.map(|(_, stated)| stated).any(|stated| is_as_stated(stated, effect, cause)) {
        return true;
    }
    let effects = cause.rule.leads_to;
    let named = effects.iter().any(|stated| stated.names(effect.rule.id));
    let applies = |stated: &&Effect| if named { stated.names(effect.rule.id) } else { stated.rules.is_empty() };
    effects.iter().filter(applies).any(|stated| is_as_stated(stated, effect, cause))
}

/// Whether the first occurrence of an effect and at least half of all occurrences come at the right time.
fn is_mostly(effect: &Group<'_>, in_time: impl Fn(Timestamp) -> bool) -> bool {
    if !in_time(effect.first()) {
        return false;
    }
    let counts = effect.findings.iter().map(|finding| finding.occurrences.count(&in_time));
    let (timely, all) = counts.fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1));
    timely * 2 >= all
}

fn is_as_stated(stated: &Effect, effect: &Group<'_>, cause: &Group<'_>) -> bool {
    let same = || effect.nodes.iter().any(|node| cause.has(Some(*node)));
    let of_nodes = match stated.nodes {
        Nodes::Any => true,
        Nodes::Same => same(),
        Nodes::Other => !same(),
        Nodes::Origin => effect.findings.iter().any(|finding| cause.has(finding.origin)),
    };
    let of_kind = match stated.kinds {
        Kinds::Any => true,
        Kinds::Same => effect.kind == cause.kind,
        Kinds::These(kinds) => kinds.contains(&effect.kind),
    };
    // A finding that ended before the cause began can't be its effect; nor can a finding that goes on without the
    // cause.
    let in_time = || match stated.time {
        Time::Any => effect.last() + SETTLE >= cause.first(),
        Time::Never => false,
        Time::During(early, settle) => is_mostly(effect, |time| cause.covers(time, early, settle)),
        Time::Spanning(settle) => is_mostly(effect, |time| cause.spans(time, settle)),
    };
    of_nodes && of_kind && (!stated.less_grave || effect.rank() > cause.rank()) && in_time()
}
