//! Compares the frames read and written: every missing frame must have been reported.
//!
//! The frames of a changed capture are written out as a log with one frame per line, and counted; frames that the log
//! can't hold are reported. In formats with one row per frame the rows are counted, too: each original row must be a
//! frame, a reported damage, or a different kind of row after the change.

use super::FOLDER;
use super::limited::Program;
use super::mutation::Mutation;
use super::rows;
use super::seeds::{IsFrame, Seed};
use anyhow::{Context, Result};
use serde_json::Value;
use std::collections::BTreeMap;

/// The account of a capture's frames.
#[derive(Default)]
pub struct Accounted {
    /// Number of counted rows.
    pub rows: u64,
    /// Number of changed rows that look like no frame any more, and so need no report.
    pub became_others: u64,
    /// Missing frames without a report.
    pub silent_loss: Option<String>,
}

/// Counts the frames of a changed capture.
pub fn account(
    program: &Program,
    seed: &Seed,
    mutation: Mutation,
    bytes: &[u8],
    path: &str,
    thread: u64,
) -> Result<Accounted> {
    let (out, quality) = (format!("{FOLDER}/{thread}-out.log"), format!("{FOLDER}/{thread}-quality.json"));
    let _ = std::fs::remove_file(&quality);
    let _ = std::fs::remove_file(&out);
    let args = ["convert", path, &out, "--force", "--to", "candump", "--quality=json", "--quality-out", &quality];
    let run = program.run(&args.map(str::to_owned));
    // The program has already reported a capture that it can't open.
    let Ok(text) = std::fs::read_to_string(&quality) else {
        let silent = run.status == Some(0) || run.stderr.is_empty();
        return Ok(Accounted {
            silent_loss: silent.then(|| "nothing was read and nothing reported".to_owned()),
            ..Accounted::default()
        });
    };
    let quality: Value = serde_json::from_str(&text).context("--quality")?;
    let (frames, told) = counts(&quality).context("--quality names no frames")?;
    let written = std::fs::read(&out)?.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).count() as u64;
    let left_out = left_out(&run.stderr);
    let mut accounted = Accounted::default();
    if written + left_out < frames {
        accounted.silent_loss =
            Some(format!("{frames} frames were read, {written} written and {left_out} reported as left out"));
    }
    if let Some(is_frame) = seed.is_frame.filter(|_| mutation.keeps_rows()) {
        let rows = Rows::of(&seed.bytes, bytes, is_frame);
        (accounted.rows, accounted.became_others) = (rows.intact + rows.changed, rows.others);
        if frames + told < rows.intact + rows.changed {
            accounted.silent_loss = Some(format!(
                "{} rows of frames and {} changed ones came to {frames} frames and {told} damages",
                rows.intact, rows.changed
            ));
        }
    }
    Ok(accounted)
}

/// The rows of a changed text.
struct Rows {
    /// Number of unchanged rows that are frames.
    intact: u64,
    /// Number of changed rows that still look like frames.
    changed: u64,
    /// Number of changed rows that look like no frame.
    others: u64,
}

impl Rows {
    fn of(original: &[u8], changed: &[u8], is_frame: IsFrame) -> Self {
        let mut known: BTreeMap<&[u8], bool> = BTreeMap::new();
        known.extend(rows(original).into_iter().map(|row| (row, is_frame(row))));
        let mut rows_of = Self { intact: 0, changed: 0, others: 0 };
        for row in rows(changed) {
            match known.get(row) {
                Some(true) => rows_of.intact += 1,
                Some(false) => {}
                None if is_frame(row) && !row.trim_ascii().is_empty() => rows_of.changed += 1,
                None => rows_of.others += 1,
            }
        }
        rows_of
    }
}

/// Number of frames, and of damages including the frames reported as lost.
fn counts(quality: &Value) -> Option<(u64, u64)> {
    let captures = quality["sources"].as_array()?;
    let frames = captures.iter().map(|capture| capture["frames"].as_u64()).sum::<Option<u64>>()?;
    let damages = captures.iter().flat_map(|capture| capture["damages"].as_object().into_iter().flatten());
    Some((frames, damages.filter_map(|(_, count)| count.as_u64()).sum()))
}

/// The number in lines such as `canvass: candump can't hold errors: 3 frames left out`.
fn left_out(stderr: &str) -> u64 {
    let lines = stderr.lines().filter_map(|line| line.strip_suffix(" left out"));
    let counts = lines.filter_map(|line| line.rsplit_once(": ")?.1.split(' ').next()?.parse::<u64>().ok());
    counts.sum()
}
