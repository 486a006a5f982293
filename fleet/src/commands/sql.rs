//! `canvass-fleet sql`: statements, or a shell.

use super::shell;
use crate::cli::Engine;
use crate::output::{self, WholeFile, diagnostic};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_fleet::lake;
use canvass_fleet::render::{self, Format};
use canvass_fleet::scan::{CaptureScan, register_files};
use canvass_fleet::views;
use datafusion::logical_expr::LogicalPlan;
use datafusion::physical_plan::{ExecutionPlan, execute_stream};
use datafusion::prelude::SessionContext;
use datafusion::sql::parser::{DFParser, Statement};
use futures::StreamExt as _;
use std::io::{IsTerminal as _, Read as _, Write};
use std::path::PathBuf;
use std::sync::Arc;

/// Query captures, results and lakes in SQL
///
/// Without a statement, canvass-fleet opens a shell on a terminal, or otherwise reads the statements from standard
/// input.
#[derive(clap::Args)]
pub struct Args {
    /// Statements, separated by semicolons, such as "SELECT count(*) FROM events('field/*.log')"
    #[arg(value_name = "STATEMENT")]
    statement: Option<String>,
    /// The lake whose tables the statements use by name
    #[arg(long, value_name = "LAKE")]
    lake: Option<String>,
    /// Files, folders and patterns, local or as s3://BUCKET/..., whose tables the statements use by name; captures are
    /// decoded on the fly
    #[arg(long, value_name = "SOURCE", conflicts_with = "lake")]
    over: Vec<String>,
    /// How to print answers
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Write the answer to a file instead of standard output
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Maximum number of rows of a table; other formats have all rows
    #[arg(long, value_name = "N", default_value_t = 1000)]
    max_rows: usize,
    #[command(flatten)]
    engine: Engine,
}

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        output::refuse_terminal(self.format, self.output.as_deref())?;
        let session = self.engine.session().await?;
        if let Some(lake) = &self.lake {
            lake::register(&session, lake).await?;
        }
        if !self.over.is_empty() {
            register_files(&session, &self.over)?;
        }
        if self.lake.is_some() || !self.over.is_empty() {
            views::register(&session).await?;
        }
        let answers = Answers::new(session, self.format, self.max_rows);
        let statement = match self.statement {
            Some(statement) => statement,
            None if std::io::stdin().is_terminal() => return shell::run(answers).await,
            None => {
                let mut text = String::new();
                std::io::stdin().read_to_string(&mut text)?;
                text
            }
        };
        match &self.output {
            Some(path) => {
                let file = WholeFile::create(path)?;
                answers.all(&statement, || Ok(file.writer()?)).await?;
                file.complete()?;
            }
            None => {
                answers.all(&statement, || Ok(output::raw())).await?;
            }
        }
        Ok(Status::Good)
    }
}

/// Answers statements.
pub struct Answers {
    session: SessionContext,
    format: Format,
    max_rows: usize,
}

impl Answers {
    /// Prints answers in this format; a table for people shows at most `max_rows` rows.
    pub const fn new(session: SessionContext, format: Format, max_rows: usize) -> Self {
        Self { session, format, max_rows }
    }

    /// Answers all statements of a text, one after the other. Returns how many files were no captures.
    pub async fn all(
        &self,
        text: &str,
        out: impl Fn() -> Result<Box<dyn Write + Send>, Failure>,
    ) -> Result<usize, Failure> {
        let statements = DFParser::parse_sql(text)?;
        if statements.is_empty() {
            return Err(anyhow!("there is no statement: expected SQL, such as SELECT * FROM events('a.log')").into());
        }
        let (mut unreadable, mut answers) = (0, 0);
        for statement in statements {
            unreadable += self.one(statement, &out, &mut answers).await?;
        }
        Ok(unreadable)
    }

    async fn one(
        &self,
        statement: Statement,
        out: impl Fn() -> Result<Box<dyn Write + Send>, Failure>,
        answers: &mut usize,
    ) -> Result<usize, Failure> {
        let plan = self.session.state().statement_to_plan(statement).await?;
        let is_question = !matches!(plan, LogicalPlan::Ddl(_) | LogicalPlan::Statement(_));
        let is_told = is_question && !plan.schema().fields().is_empty();
        *answers += usize::from(is_told);
        if *answers > 1 && self.format.is_one_document() {
            let expected = "CSV, Parquet and Arrow hold one answer: expected one statement with an answer, found more";
            return Err(anyhow!(expected).into());
        }
        let answer = self.session.execute_logical_plan(plan).await?;
        if !is_told {
            answer.collect().await?;
            return Ok(0);
        }
        let out = out()?;
        let plan = answer.create_physical_plan().await?;
        let mut batches = execute_stream(Arc::clone(&plan), self.session.task_ctx())?;
        let mut rendered = render::answer(self.format, &batches.schema(), out)?;
        let mut left = if self.format == Format::Table { self.max_rows } else { usize::MAX };
        while let Some(batch) = batches.next().await {
            let batch = batch?;
            rendered.batch(&batch.slice(0, batch.num_rows().min(left)))?;
            if batch.num_rows() > left {
                diagnostic(&format!("canvass-fleet: only the first {} rows are shown (--max-rows)", self.max_rows));
                break;
            }
            left -= batch.num_rows();
        }
        rendered.finish()?;
        Ok(tell_unreadable(&plan))
    }

    /// The session, for questions of the shell itself.
    pub const fn session(&self) -> &SessionContext {
        &self.session
    }
}

/// Prints how many files were no captures.
fn tell_unreadable(plan: &Arc<dyn ExecutionPlan>) -> usize {
    let unreadable = unreadable(plan);
    if unreadable > 0 {
        let files = if unreadable == 1 { "1 file was" } else { &format!("{unreadable} files were") };
        diagnostic(&format!(
            "canvass-fleet: {files} passed over, as nothing could be read there: SELECT capture, reason FROM \
             captures('…') WHERE reason IS NOT NULL tells which and why"
        ));
    }
    unreadable
}

fn unreadable(plan: &Arc<dyn ExecutionPlan>) -> usize {
    let own = plan
        .downcast_ref::<CaptureScan>()
        .and_then(CaptureScan::metrics)
        .and_then(|metrics| metrics.sum_by_name(CaptureScan::UNREADABLE))
        .map_or(0, |count| count.as_usize());
    own + plan.children().into_iter().map(unreadable).sum::<usize>()
}
