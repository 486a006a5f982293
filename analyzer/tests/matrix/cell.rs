//! Cells of the matrix: one incident each.

use super::draw::Draw;
use super::judge::{self, Truth, Verdict};
use super::network::{Base, Events, Known, Network};
use super::operator::{Operator, When};
use super::play::{play, touched};
use super::sort::Sort;
use canvass_traces::Record;
use std::collections::HashMap;
use std::fmt;

/// A cell: `BASE/KNOWN/SERVICE/MESSAGE/OPERATOR/WHEN`.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    base: (Base, &'static str),
    known: (Known, &'static str),
    /// The sort of message.
    pub sort: Sort,
    /// What goes wrong.
    pub operator: Operator,
    when: (When, &'static str),
}

/// What became of a cell.
pub struct Outcome {
    /// The verdict on the diagnosis.
    pub verdict: Verdict,
    /// The findings, in their order.
    pub findings: Vec<String>,
    /// What was done.
    pub truth: String,
}

impl Cell {
    /// All cells. Some of them have no message: their network does not send its sort.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for base in Base::ALL {
            for known in Known::ALL {
                for sort in Sort::all() {
                    for operator in Operator::all(&sort) {
                        let once = operator == Operator::BeginLate;
                        let times = When::ALL.into_iter().filter(|(when, _)| !once || *when == When::ToTheEnd);
                        all.extend(times.map(|when| Self { base, known, sort, operator, when }));
                    }
                }
            }
        }
        all
    }

    /// The cell with this id.
    pub fn by_id(id: &str) -> Option<Self> {
        Self::all().into_iter().find(|cell| cell.to_string() == id)
    }

    fn events(&self) -> Events {
        let is_event = matches!(self.sort.group, "emcy" | "error-frame") || self.sort == Sort::GLOBAL_FAIL_SAFE;
        if is_event || self.sort.id().ends_with("/abort") { Events::Some } else { Events::None }
    }

    fn draw(&self, seed: u64) -> Draw {
        Draw::new(seed, &self.to_string())
    }

    /// The records with the incident, and what was done; `None` if the network sends no such message.
    pub fn records(&self, seed: u64) -> Option<(Network, Vec<Record>, Truth)> {
        let mut draw = self.draw(seed);
        let network_draw = Draw::new(draw.number(), "network");
        let network = Network::new(self.base.0, self.known.0, self.events(), network_draw);
        let incident = self.operator.act(&network.plan, &self.sort, self.when.0, &mut draw)?;
        let records = play(&network.plan, &incident.fates);
        let healthy = play(&network.plan, &HashMap::new());
        let is_same = |(one, other): (&Record, &Record)| one.timestamp == other.timestamp && one.frame == other.frame;
        if records.len() == healthy.len() && records.iter().zip(&healthy).all(is_same) {
            return None;
        }
        let touched = touched(&network.plan, &incident.fates);
        let truth = Truth::new(&network.plan, &incident, &touched, self.sort);
        Some((network, records, truth))
    }

    /// Diagnoses the cell; `None` if the network sends no such message.
    pub fn measure(&self, seed: u64) -> Option<Outcome> {
        let (network, records, truth) = self.records(seed)?;
        let descriptions = network.descriptions();
        let before = judge::diagnose(&play(&network.plan, &HashMap::new()), &descriptions).findings;
        let results = judge::diagnose(&records, &descriptions);
        let verdict = judge::verdict(&results, &before, &truth);
        Some(Outcome { verdict, findings: judge::shown(&results, &before), truth: truth.to_string() })
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { base, known, sort, operator, when } = self;
        write!(f, "{}/{}/{}/{}/{}", base.1, known.1, sort.id(), operator.id(), when.1)
    }
}
