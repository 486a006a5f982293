//! The findings of chosen nodes. The rules have judged all frames, so that a finding keeps its cause at another node.

use super::stories::Story;
use super::{Finding, Results};
use crate::NodeId;

impl Results {
    /// Keeps the stories in which a finding concerns one of these nodes, or is caused by one. The statistics still cover all
    /// nodes.
    pub fn keep_nodes(&mut self, wanted: impl Fn(NodeId) -> bool) {
        let concerns = |finding: &Finding| [finding.node, finding.origin].into_iter().flatten().any(&wanted);
        let findings = &self.findings;
        self.stories.retain(|story| story.all().any(|at| findings.get(at).is_some_and(concerns)));
        let places = self.places();
        let before = self.findings.len();
        let mut kept = places.iter().map(Option::is_some);
        self.findings.retain(|_| kept.next().unwrap_or(false));
        self.left_out += before - self.findings.len();
        let place = |at: &mut usize| {
            let new = places.get(*at).copied().flatten();
            debug_assert!(new.is_some(), "a story holds a finding that was not kept");
            *at = new.unwrap_or(*at);
        };
        for story in &mut self.stories {
            story.head.iter_mut().for_each(place);
            for consequence in &mut story.consequences {
                consequence.findings.iter_mut().for_each(place);
                place(&mut consequence.of);
            }
        }
    }

    /// The index that each finding gets when only those of the stories remain.
    fn places(&self) -> Vec<Option<usize>> {
        let mut places = vec![None; self.findings.len()];
        for at in self.stories.iter().flat_map(Story::all) {
            if let Some(place) = places.get_mut(at) {
                *place = Some(0);
            }
        }
        for (new, place) in places.iter_mut().flatten().enumerate() {
            *place = new;
        }
        places
    }
}
