//! Stories: findings of one kind together, with the findings that follow from them.
//!
//! Each rule reports what it sees, independently of the others. Most findings after a breakdown follow from one
//! finding: other nodes miss the lost node, requests to it are not answered, it restarts. The head of a story is the
//! finding from which the others follow; the others come in the order of time.

mod causes;
mod groups;

use super::finding::{Finding, Severity};

/// One event with its consequences.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Story {
    /// The indexes of the findings at the head: all of one kind, of one node or of several nodes at the same time.
    pub head: Vec<usize>,
    /// The consequences, each of one kind, in the order of time.
    pub consequences: Vec<Consequence>,
}

/// Findings of one kind that follow from others.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Consequence {
    /// The indexes of the findings.
    pub findings: Vec<usize>,
    /// The index of the finding from which these findings follow.
    pub of: usize,
}

impl Story {
    /// The indexes of all findings in the story.
    pub fn all(&self) -> impl Iterator<Item = usize> {
        let consequences = self.consequences.iter().flat_map(|consequence| &consequence.findings);
        self.head.iter().chain(consequences).copied()
    }

    /// The severity of the worst finding at the head.
    pub fn severity(&self, findings: &[Finding]) -> Severity {
        let severities = self.head.iter().filter_map(|at| Some(findings.get(*at)?.severity));
        severities.max().unwrap_or(Severity::Info)
    }
}

/// Groups findings into stories; the story with the worst consequences first. Each finding is in one story.
pub(super) fn tell(findings: &[Finding]) -> Vec<Story> {
    let groups = groups::of(findings);
    let causes = causes::of(&groups);
    let mut stories: Vec<(usize, Story)> = Vec::new();
    for (at, group) in groups.iter().enumerate() {
        if causes[at].is_none() {
            stories.push((at, Story { head: group.places.clone(), consequences: Vec::new() }));
        }
    }
    for (at, group) in groups.iter().enumerate() {
        let Some(of) = causes[at] else { continue };
        let root = causes::root(&causes, at);
        if let Some((_, story)) = stories.iter_mut().find(|(head, _)| *head == root) {
            let of = groups[of].places.first().copied().unwrap_or_default();
            story.consequences.push(Consequence { findings: group.places.clone(), of });
        }
    }
    let mut stories: Vec<Story> = stories.into_iter().map(|(_, story)| story).collect();
    let first = |places: &[usize]| places.iter().filter_map(|at| Some(findings.get(*at)?.first)).min();
    for story in &mut stories {
        story.consequences.sort_by_key(|consequence| first(&consequence.findings));
    }
    stories.sort_by_key(|story| {
        let head = story.head.first().and_then(|at| findings.get(*at));
        let is_hint = story.severity(findings) == Severity::Info;
        (is_hint, head.map(|head| head.rank), first(&story.head))
    });
    stories
}
