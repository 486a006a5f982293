//! The stories of a diagnosis in words.

use super::{Diagnosed, times};
use canvass_analyzer::findings::{Consequence, Finding, Severity, Story};
use std::fmt::Write;

/// A story to report.
pub struct Told<'a> {
    diagnosed: &'a Diagnosed<'a>,
    story: &'a Story,
}

/// All stories. The story with the worst consequences comes first.
pub fn all<'a>(diagnosed: &'a Diagnosed<'a>) -> impl Iterator<Item = Told<'a>> {
    diagnosed.results.stories.iter().map(move |story| Told { diagnosed, story })
}

impl<'a> Told<'a> {
    /// The findings at the head of the story. There is at least one.
    pub fn head(&self) -> Vec<&'a Finding> {
        self.findings(&self.story.head)
    }

    /// The consequences of the head, each with its findings.
    pub fn consequences(&self) -> impl Iterator<Item = (&'a Consequence, Vec<&'a Finding>)> {
        self.story.consequences.iter().map(|consequence| (consequence, self.findings(&consequence.findings)))
    }

    pub fn severity(&self) -> Severity {
        self.story.severity(&self.diagnosed.results.findings)
    }

    fn findings(&self, places: &[usize]) -> Vec<&'a Finding> {
        places.iter().filter_map(|at| self.diagnosed.results.findings.get(*at)).collect()
    }
}

/// The nodes that findings of one kind are about: `node 5`, `nodes 3, 4`. Empty if there are none.
pub fn whom(diagnosed: &Diagnosed<'_>, findings: &[&Finding]) -> String {
    let mut nodes: Vec<String> = Vec::new();
    for node in findings.iter().filter_map(|finding| finding.node) {
        let node = node.to_string();
        if !nodes.contains(&node) {
            nodes.push(node);
        }
    }
    match (findings.first(), nodes.len()) {
        (Some(first), 0 | 1) => diagnosed.whom(first),
        (Some(first), _) => {
            let on = first.channel.filter(|_| diagnosed.results.buses.len() > 1).map(|id| diagnosed.channel(id));
            let on = on.map(|channel| format!(" on {channel}")).unwrap_or_default();
            format!("nodes {}{on}", nodes.join(", "))
        }
        (None, _) => String::new(),
    }
}

/// The words of the first of several findings of one kind, with the number of further ones and their objects.
pub fn words(diagnosed: &Diagnosed<'_>, findings: &[&Finding]) -> String {
    const LISTED: usize = 8;
    let Some((first, others)) = findings.split_first() else { return String::new() };
    let mut text = format!("{}{}", first.message, times(diagnosed, first));
    if others.is_empty() {
        return text;
    }
    let mut objects: Vec<String> =
        others.iter().filter_map(|finding| finding.object).map(|object| object.to_string()).collect();
    objects.dedup();
    // Writing to a string can't fail.
    let _ = write!(text, "; {} more like this", others.len());
    if !objects.is_empty() {
        let more = if objects.len() > LISTED { ", …" } else { "" };
        objects.truncate(LISTED);
        let _ = write!(text, " of {}{more}", objects.join(", "));
    }
    text
}
