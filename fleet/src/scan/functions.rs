//! Table functions, `events('field/**/*.log')`, and files in place of tables: `FROM 'x.mcap'`.

use super::{CaptureTable, Files, Options};
use crate::capture::find;
use crate::table::Table;
use async_trait::async_trait;
use datafusion::catalog::{TableFunctionArgs, TableFunctionImpl, TableProvider, UrlTableFactory};
use datafusion::common::{ScalarValue, plan_err};
use datafusion::datasource::dynamic_file::DynamicListTableFactory;
use datafusion::error::Result;
use datafusion::execution::SessionState;
use datafusion::logical_expr::Expr;
use datafusion::prelude::SessionContext;
use datafusion_session::SessionStore;
use std::sync::Arc;

/// A table function for captures.
#[derive(Debug)]
struct CaptureFunction(Table);

impl TableFunctionImpl for CaptureFunction {
    fn call_with_args(&self, args: TableFunctionArgs<'_, '_>) -> Result<Arc<dyn TableProvider>> {
        let patterns: Vec<String> = args.exprs().iter().filter_map(text).collect();
        if patterns.is_empty() || patterns.len() < args.exprs().len() {
            let name = self.0.name();
            return plan_err!("{name}: expected patterns of files as texts, such as {name}('field/**/*.log')");
        }
        let options = Options::of(args.session().config_options());
        Ok(Arc::new(CaptureTable::new(self.0, Files::Patterns(patterns), &options)?))
    }
}

fn text(expression: &Expr) -> Option<String> {
    match expression {
        Expr::Literal(ScalarValue::Utf8(Some(text)) | ScalarValue::Utf8View(Some(text)), _) => Some(text.clone()),
        _ => None,
    }
}

/// Registers the table functions.
pub fn register(context: &SessionContext) {
    for table in Table::ALL {
        context.register_udtf(table.name(), Arc::new(CaptureFunction(table)));
    }
}

/// Registers tables of captures and results by their names. Tables of captures skip results among the files, and tables
/// of results skip captures.
///
/// # Errors
/// If a rule of `canvass.devices` can't be used.
pub fn register_files(context: &SessionContext, patterns: &[String]) -> Result<()> {
    let options = Options::of(context.copied_config().options());
    for table in Table::ALL {
        let files = Files::Patterns(patterns.to_vec());
        context.register_table(table.name(), Arc::new(CaptureTable::new(table, files, &options)?))?;
    }
    Ok(())
}

/// Tables of `FROM 'x.mcap'`: the messages of captures; Parquet and Arrow files are tables themselves.
#[derive(Debug, Default)]
pub struct FileTables {
    others: DynamicListTableFactory,
}

impl FileTables {
    /// The place for the session, which the creator of the session fills.
    pub fn session_store(&self) -> &SessionStore {
        self.others.session_store()
    }

    fn state(&self) -> Option<SessionState> {
        let session = self.session_store().get_session().upgrade()?;
        session.read().as_any().downcast_ref::<SessionState>().cloned()
    }
}

#[async_trait]
impl UrlTableFactory for FileTables {
    async fn try_new(&self, url: &str) -> Result<Option<Arc<dyn TableProvider>>> {
        let is_table = [".parquet", ".arrow"].iter().any(|ending| url.ends_with(ending));
        if is_table {
            return self.others.try_new(url).await;
        }
        let Some(state) = self.state() else { return Ok(None) };
        // The engine reports a name that matches no file as a missing table.
        let Ok(files) = find(url, state.runtime_env()).await else { return Ok(None) };
        let options = Options::of(state.config_options());
        Ok(Some(Arc::new(CaptureTable::new(Table::Messages, Files::Known(files), &options)?)))
    }
}
