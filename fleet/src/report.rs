//! The contents of a lake, for a page: totals, plots over time, and the answers to the usual questions.

use crate::views::VIEWS;
use canvass_reports::fleet::{Fleet, Line, Plot, Question};
use datafusion::arrow::array::AsArray as _;
use datafusion::arrow::array::{Array, ArrayRef, RecordBatch};
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Float64Type};
use datafusion::arrow::error::ArrowError;
use datafusion::arrow::util::display::{ArrayFormatter, FormatOptions};
use datafusion::error::Result;
use datafusion::prelude::SessionContext;

/// Figures of the whole lake: the name of each, and the statement that computes it.
const TOTALS: [(&str, &str); 6] = [
    ("Captures", "SELECT count(*) FROM captures"),
    ("not readable to their end", "SELECT count(*) FROM captures WHERE reason IS NOT NULL"),
    ("Frames", "SELECT coalesce(sum(frames), 0) FROM captures"),
    (
        "Devices with an identity",
        "SELECT count(*) FROM (SELECT DISTINCT vendor_id, product_code, serial_number FROM nodes WHERE serial_number IS NOT NULL)",
    ),
    ("Findings", "SELECT count(*) FROM findings"),
    ("Test runs", "SELECT count(*) FROM runs"),
];

/// Plots: the title of each, and a statement with three columns: x axis, name of the line and value, in the order
/// shown. Rows without date are in the folder of 1970.
const PLOTS: [(&str, &str); 6] = [
    (
        "Captures by day",
        "SELECT date, '' AS line, count(*) AS value FROM captures WHERE date > DATE '1970-01-01' \
         GROUP BY date ORDER BY date",
    ),
    (
        "Frames by day",
        "SELECT date, '' AS line, sum(frames) AS value FROM captures WHERE date > DATE '1970-01-01' \
         GROUP BY date ORDER BY date",
    ),
    (
        "Errors and warnings by day",
        "SELECT date, severity AS line, count(*) AS value FROM findings WHERE severity IN ('error', 'warning') \
         AND date > DATE '1970-01-01' \
         GROUP BY date, severity ORDER BY date, severity",
    ),
    (
        "EMCY messages by day",
        "SELECT date, '' AS line, count(*) AS value FROM events WHERE event = 'emcy' AND emcy_state = 'raised' \
         AND date > DATE '1970-01-01' \
         GROUP BY date ORDER BY date",
    ),
    (
        "SDO transfers: 99 of 100 take at most [ms], by month and product",
        "SELECT month, product AS line, max(p99_ns) / 1e6 AS value FROM (\
         SELECT date_trunc('month', e.started) AS month, \
         coalesce(concat('product ', arrow_cast(n.product_code, 'Utf8')), 'unknown product') AS product, \
         approx_percentile_cont(0.99) WITHIN GROUP (ORDER BY e.duration_ns) AS p99_ns \
         FROM events e LEFT JOIN nodes n ON n.capture = e.capture AND n.channel = e.channel AND n.node = e.node \
         WHERE e.event = 'sdo' AND e.outcome = 'complete' AND e.date > DATE '1970-01-01' \
         GROUP BY date_trunc('month', e.started), \
         coalesce(concat('product ', arrow_cast(n.product_code, 'Utf8')), 'unknown product')) \
         GROUP BY month, product ORDER BY month, product",
    ),
    (
        "Failed cases by day",
        "SELECT date, '' AS line, sum(fail) AS value FROM runs WHERE kind = 'test' AND date > DATE '1970-01-01' \
         GROUP BY date ORDER BY date",
    ),
];

/// Maximum number of lines in a plot that can be distinguished.
const LINES: usize = 6;

/// Queries a lake whose tables and views are registered in the session. Each answer has at most `most_rows` rows.
///
/// # Errors
/// The errors of the query engine.
pub async fn ask(session: &SessionContext, lake: &str, most_rows: usize) -> Result<Fleet> {
    let mut fleet = Fleet {
        lake: lake.to_owned(),
        made_by: format!("canvass-fleet {}", env!("CARGO_PKG_VERSION")),
        ..Fleet::default()
    };
    for (name, statement) in TOTALS {
        let figure = rows(session, statement).await?.1.into_iter().flatten().flatten().next();
        fleet.totals.push((name, figure.unwrap_or_default()));
    }
    for (title, statement) in PLOTS {
        let batches = session.sql(statement).await?.collect().await?;
        let plot = plot(title, &batches)?;
        if !plot.labels.is_empty() {
            fleet.plots.push(plot);
        }
    }
    for view in VIEWS {
        let statement = format!("SELECT * FROM {} LIMIT {}", view.name, most_rows.saturating_add(1));
        let (columns, mut rows) = rows(session, &statement).await?;
        let is_cut = rows.len() > most_rows;
        rows.truncate(most_rows);
        fleet.questions.push(Question { name: view.name, title: view.title(), doc: view.doc(), columns, rows, is_cut });
    }
    Ok(fleet)
}

/// The names of the columns, and rows of texts.
type Rows = (Vec<String>, Vec<Vec<Option<String>>>);

async fn rows(session: &SessionContext, statement: &str) -> Result<Rows> {
    let answer = session.sql(statement).await?;
    let columns = answer.schema().fields().iter().map(|field| field.name().clone()).collect();
    let mut rows = Vec::new();
    for batch in answer.collect().await? {
        let texts = batch.columns().iter().map(texts).collect::<Result<Vec<_>, _>>()?;
        rows.extend(
            (0..batch.num_rows()).map(|row| texts.iter().map(|column| column[row].clone()).collect::<Vec<_>>()),
        );
    }
    Ok((columns, rows))
}

fn texts(column: &ArrayRef) -> Result<Vec<Option<String>>, ArrowError> {
    let formatter = ArrayFormatter::try_new(column, &FormatOptions::default())?;
    let text = |row| if column.is_null(row) { Ok(None) } else { formatter.value(row).try_to_string().map(Some) };
    (0..column.len()).map(text).collect()
}

/// Makes a plot from batches whose first two columns are texts and whose third column is a number.
fn plot(title: &str, batches: &[RecordBatch]) -> Result<Plot> {
    let mut plot = Plot { title: title.to_owned(), ..Plot::default() };
    for batch in batches {
        let (labels, names) = (texts(batch.column(0))?, texts(batch.column(1))?);
        let values = cast(batch.column(2), &DataType::Float64)?;
        let values = values.as_primitive::<Float64Type>().iter();
        for ((label, name), value) in labels.into_iter().zip(names).zip(values) {
            point(&mut plot, &label.unwrap_or_default(), &name.unwrap_or_default(), value);
        }
    }
    plot.lines.iter_mut().for_each(|line| line.values.resize(plot.labels.len(), None));
    Ok(plot)
}

fn point(plot: &mut Plot, label: &str, name: &str, value: Option<f64>) {
    // The label of a month has no day and time.
    let label = label.strip_suffix("-01T00:00:00Z").unwrap_or(label);
    if plot.labels.last().is_none_or(|last| last != label) {
        plot.labels.push(label.to_owned());
    }
    let at = match plot.lines.iter().position(|line| line.name == name) {
        Some(at) => at,
        None if plot.lines.len() < LINES => {
            plot.lines.push(Line { name: name.to_owned(), values: Vec::new() });
            plot.lines.len() - 1
        }
        None => return,
    };
    if let Some(line) = plot.lines.get_mut(at) {
        line.values.resize(plot.labels.len() - 1, None);
        line.values.push(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_a_place_for_each_label() {
        let mut plot = Plot::default();
        for (label, name, value) in [("2025-01-28", "a", 1.0), ("2025-01-28", "b", 2.0), ("2025-01-29", "b", 3.0)] {
            point(&mut plot, label, name, Some(value));
        }
        plot.lines.iter_mut().for_each(|line| line.values.resize(plot.labels.len(), None));
        assert_eq!(plot.labels, ["2025-01-28", "2025-01-29"]);
        assert_eq!(plot.lines[0].values, [Some(1.0), None]);
        assert_eq!(plot.lines[1].values, [Some(2.0), Some(3.0)]);
        point(&mut plot, "2025-02-01T00:00:00Z", "b", None);
        assert_eq!(plot.labels[2], "2025-02");
    }
}
