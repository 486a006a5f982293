//! Commands that only Chromium has.

use crate::browser::Browser;
use fantoccini::wd::WebDriverCompatibleCommand;
use http::Method;
use serde_json::{Value, json};
use url::{ParseError, Url};

/// A command of chromedriver outside the standard.
#[derive(Debug)]
struct OwnCommand {
    path: &'static str,
    parameters: Value,
}

impl WebDriverCompatibleCommand for OwnCommand {
    fn endpoint(&self, base: &Url, session: Option<&str>) -> Result<Url, ParseError> {
        base.join(&format!("session/{}/{}", session.unwrap_or_default(), self.path))
    }

    fn method_and_body(&self, _: &Url) -> (Method, Option<String>) {
        (Method::POST, Some(self.parameters.to_string()))
    }
}

impl Browser {
    /// A command of the browser's own protocol.
    #[track_caller]
    pub fn command(&self, name: &str, parameters: &Value) -> Value {
        self.own("goog/cdp/execute", json!({ "cmd": name, "params": parameters }))
    }

    /// The lines of a log since the last call.
    #[track_caller]
    pub(crate) fn log(&self, kind: &str) -> Value {
        self.own("se/log", json!({ "type": kind }))
    }

    #[track_caller]
    fn own(&self, path: &'static str, parameters: Value) -> Value {
        let what = format!("{path} {parameters}");
        self.ask(what, self.client.issue_cmd(OwnCommand { path, parameters }))
    }
}
