//! `findings`: problems that the diagnosis found.

use super::column::{Column, Rows, write, write_str};
use canvass_analyzer::NodeId;
use canvass_analyzer::findings::Finding;
use canvass_analyzer::statistics::CaseName;
use canvass_reports::diagnosis::{Diagnosed, evidence};
use canvass_tables::columns;

/// The rows of `findings`.
pub struct Findings;

/// A finding of a capture.
pub struct FindingRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The diagnosis of the capture.
    pub diagnosed: &'a Diagnosed<'a>,
    /// The finding.
    pub finding: &'a Finding,
}

impl Rows for Findings {
    type Row<'a> = FindingRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.capture));
        "rule" word "the rule's id; `canvass explain RULE` says what it means" = |row| Some(row.finding.rule.id);
        "severity" word "`error`, `warning`, `info`" = |row| Some(row.finding.severity.name());
        "t" time "when it was first seen" = |row| Some(row.finding.first);
        "t_last" time "when it was last seen" = |row| Some(row.finding.last);
        "count" u64 "how often it was seen" = |row| Some(row.finding.count);
        "channel" name "the channel's name; null where it is about a whole capture" = |row, out| write_str(out, row.finding.channel.map(|id| row.diagnosed.channels.name(id)));
        "node" u8 "the node that it is about" = |row| row.finding.node.map(NodeId::raw).map(u64::from);
        "origin" u8 "the node that it comes from, where that is another one" = |row| row.finding.origin.map(NodeId::raw).map(u64::from);
        "object" name "the object that it is about, where findings are distinguished by that" = |row, out| write(out, row.finding.object);
        "test_case" name "the case of a conformance run that was under way" = |row, out| match &row.finding.case {
            Some(CaseName::Id(id)) => write_str(out, Some(id)),
            Some(CaseName::Numbered { group, case }) => write(out, Some(format_args!("{group}.{case}"))),
            None => false,
        };
        "title" word "the rule in a few words" = |row| Some(row.finding.rule.title);
        "message" text "what happened" = |row, out| write_str(out, Some(&row.finding.message));
        "advice" word "what to do about it" = |row| Some(row.finding.rule.advice);
        "evidence" text "the frames that prove it: a JSON array, as `canvass diagnose --format json` has it" = |row, out| write(out, Some(serde_json::json!(evidence(row.diagnosed, row.finding))));
    ];
}
