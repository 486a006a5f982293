//! Sessions with the language server, as an editor has them.

use crate::running::command;
use lsp_server::{Message, Notification, Request, RequestId};
use serde_json::{Value, json};
use std::io::BufReader;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

const URI: &str = "file:///work/encoder.eds";
const TEXT: &str = "\
[DeviceInfo]
VendorName=Example
LSS_Supported=yes

[OptionalObjects]
SupportedObjects=7
1=0x1018

[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2

[1018sub0]
ParameterName=Highest
DataType=0x0005
AccessType=ro
DefaultValue=1

[1018sub1]
ParameterName=Vendor-ID
DataType=0x0007
AccessType=ro
";

struct Editor {
    server: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    requests: i32,
    findings: Vec<Value>,
}

impl Editor {
    fn start(encodings: &[&str]) -> Self {
        let mut server =
            command(&["lsp"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().unwrap();
        let (to, from) = (server.stdin.take(), BufReader::new(server.stdout.take().unwrap()));
        let mut editor = Self { server, to, from, requests: 0, findings: Vec::new() };
        let begun = editor.ask(
            "initialize",
            json!({ "capabilities": { "general": { "positionEncodings": encodings } }, "processId": null, "rootUri": null }),
        );
        assert_eq!(begun["serverInfo"]["name"], "canvass");
        assert_eq!(begun["capabilities"]["positionEncoding"], encodings[0]);
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Message) {
        message.write(self.to.as_mut().unwrap()).unwrap();
    }

    fn tell(&mut self, method: &str, params: Value) {
        self.send(&Notification { method: method.to_owned(), params }.into());
    }

    /// The answer to a request; findings that arrive meanwhile are kept.
    fn reply(&mut self, method: &str, params: Value) -> Result<Value, i32> {
        self.requests += 1;
        let id = RequestId::from(self.requests);
        self.send(&Request { id: id.clone(), method: method.to_owned(), params }.into());
        loop {
            match Message::read(&mut self.from).unwrap().unwrap() {
                Message::Response(response) => {
                    assert_eq!(response.id, id);
                    return response.response_result.map_err(|error| error.code);
                }
                Message::Notification(said) => self.findings.push(said.params),
                Message::Request(request) => panic!("{request:?}"),
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.reply(method, params).unwrap()
    }

    /// The rules of the findings that the server publishes next.
    fn found(&mut self) -> Vec<String> {
        let said = match self.findings.is_empty() {
            false => self.findings.remove(0),
            true => match Message::read(&mut self.from).unwrap().unwrap() {
                Message::Notification(said) => said.params,
                other => panic!("{other:?}"),
            },
        };
        assert_eq!(said["uri"], URI);
        said["diagnostics"].as_array().unwrap().iter().map(|one| one["code"].as_str().unwrap().to_owned()).collect()
    }

    fn open(&mut self, text: &str) {
        let document = json!({ "uri": URI, "languageId": "eds", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn end(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.to = None;
        assert_eq!(self.server.wait().unwrap().code(), Some(0));
    }
}

/// The position of a column in the line that begins with this text.
fn place(line: &str, character: usize) -> Value {
    let line = TEXT.lines().position(|text| text.starts_with(line)).unwrap();
    json!({ "textDocument": { "uri": URI }, "position": { "line": line, "character": character } })
}

#[test]
fn findings_come_as_one_types_and_go() {
    let mut editor = Editor::start(&["utf-16"]);
    editor.open(TEXT);
    let found = editor.found();
    assert!(found.contains(&"eds/list/count".to_owned()), "{found:?}");
    // The user types another count in place of the 7.
    let line = TEXT.lines().position(|line| line.starts_with("SupportedObjects")).unwrap();
    let range = json!({ "start": { "line": line, "character": 17 }, "end": { "line": line, "character": 18 } });
    let change =
        json!({ "textDocument": { "uri": URI, "version": 2 }, "contentChanges": [{ "range": range, "text": "1" }] });
    editor.tell("textDocument/didChange", change);
    let then = editor.found();
    assert!(!then.contains(&"eds/list/count".to_owned()) && !then.is_empty(), "{then:?}");
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": URI } }));
    assert_eq!(editor.found(), Vec::<String>::new());
    editor.end();
}

#[test]
fn it_shows_completes_and_finds_its_way() {
    let mut editor = Editor::start(&["utf-8", "utf-16"]);
    editor.open(TEXT);
    editor.found();
    let shown = editor.ask("textDocument/hover", place("[1018sub1]", 3));
    assert!(shown["contents"]["value"].as_str().unwrap().contains("Vendor-ID"), "{shown}");
    let goes = editor.ask("textDocument/definition", place("1=0x1018", 4));
    assert_eq!(goes["range"]["start"], json!({ "line": 8, "character": 1 }));
    assert_eq!(editor.ask("textDocument/definition", place("VendorName", 12)), Value::Null);
    let mut asked = place("[1018]", 2);
    asked["context"] = json!({ "includeDeclaration": true });
    assert_eq!(editor.ask("textDocument/references", asked).as_array().unwrap().len(), 4);
    let outline = editor.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": URI } }));
    let identity = &outline.as_array().unwrap()[2];
    assert_eq!((&identity["name"], &identity["detail"]), (&"1018".into(), &"Identity".into()));
    assert_eq!(identity["children"].as_array().unwrap().len(), 2);
    let offered = editor.ask("textDocument/completion", place("LSS_Supported", 14));
    let labels: Vec<_> = offered.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["0", "1"]);
    editor.end();
}

#[test]
fn what_can_be_mended_is_offered_and_mends() {
    let mut editor = Editor::start(&["utf-16"]);
    editor.open(TEXT);
    editor.found();
    let line = TEXT.lines().position(|line| line.starts_with("SupportedObjects")).unwrap();
    let range = json!({ "start": { "line": line, "character": 17 }, "end": { "line": line, "character": 18 } });
    let asked = json!({ "textDocument": { "uri": URI }, "range": range, "context": { "diagnostics": [] } });
    let actions = editor.ask("textDocument/codeAction", asked);
    let quick = &actions[0];
    assert_eq!((&quick["title"], &quick["kind"]), (&"write 1".into(), &"quickfix".into()), "{actions}");
    assert_eq!(quick["edit"]["changes"][URI][0], json!({ "range": range, "newText": "1" }));
    assert_eq!(actions.as_array().unwrap().last().unwrap()["kind"], "source.fixAll");
    // Formatting has the same result as `--fix`.
    let options = json!({ "tabSize": 4, "insertSpaces": true });
    let edits = editor.ask("textDocument/formatting", json!({ "textDocument": { "uri": URI }, "options": options }));
    let edit = &edits[0];
    let at = |end: &str| {
        let (line, character) =
            (edit["range"][end]["line"].as_u64().unwrap(), edit["range"][end]["character"].as_u64().unwrap());
        TEXT.split_inclusive('\n').take(line as usize).map(str::len).sum::<usize>() + character as usize
    };
    let fixed = format!("{}{}{}", &TEXT[..at("start")], edit["newText"].as_str().unwrap(), &TEXT[at("end")..]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("encoder.eds");
    std::fs::write(&file, TEXT).unwrap();
    crate::running::run(&["eds", "check", "--fix", file.to_str().unwrap()]);
    assert_eq!(fixed, std::fs::read_to_string(&file).unwrap());
    editor.end();
}

#[test]
fn what_is_wrong_is_refused_and_ends_nothing() {
    let mut editor = Editor::start(&["utf-16"]);
    let unknown = json!({ "textDocument": { "uri": "file:///other.eds" }, "position": { "line": 0, "character": 0 } });
    assert_eq!(editor.reply("textDocument/hover", unknown), Err(-32602));
    editor.open("\u{0}[1000\n=\n[\n1A00sub");
    editor.found();
    let beyond = json!({ "textDocument": { "uri": URI }, "position": { "line": 999, "character": 999 } });
    assert_eq!(editor.ask("textDocument/hover", beyond), Value::Null);
    assert_eq!(
        editor.reply("textDocument/hover", json!({ "textDocument": { "uri": URI }, "position": 7 })),
        Err(-32602)
    );
    assert_eq!(editor.reply("textDocument/rename", json!({ "textDocument": { "uri": URI } })), Err(-32602));
    assert_eq!(editor.reply("textDocument/inlayHint", json!({ "textDocument": { "uri": URI } })), Err(-32601));
    assert_eq!(editor.reply("workspace/executeCommand", json!({ "command": "format" })), Err(-32601));
    editor.tell("textDocument/didChange", json!({ "nonsense": 1 }));
    editor.end();
}

/// An object gets another index everywhere; sections fold; objects of all open files are found by name.
#[test]
fn objects_are_renamed_folded_and_found() {
    let mut editor = Editor::start(&["utf-8"]);
    editor.open(TEXT);
    editor.found();
    let begin = editor.ask("textDocument/prepareRename", place("1=0x1018", 5));
    assert_eq!(begin["end"]["character"].as_u64().unwrap() - begin["start"]["character"].as_u64().unwrap(), 4);
    let renamed = |to: &str| {
        let mut asked = place("1=0x1018", 5);
        asked["newName"] = to.into();
        asked
    };
    let edit = editor.ask("textDocument/rename", renamed("0x2018"));
    let edits = edit["changes"][URI].as_array().unwrap();
    assert_eq!(edits.len(), TEXT.matches("1018").count());
    assert!(edits.iter().all(|edit| edit["newText"] == "2018"));
    for wrong in ["vendor", "20180", "1018"] {
        assert_eq!(editor.reply("textDocument/rename", renamed(wrong)), Err(-32602), "{wrong}");
    }
    let folds = editor.ask("textDocument/foldingRange", json!({ "textDocument": { "uri": URI } }));
    let sections = TEXT.lines().filter(|line| line.starts_with('[')).count();
    assert!(folds.as_array().unwrap().len() <= sections && folds.as_array().unwrap().len() > 3, "{folds}");
    let found = editor.ask("workspace/symbol", json!({ "query": "vendor" }));
    let names: Vec<_> = found.as_array().unwrap().iter().map(|symbol| symbol["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["1018sub1 Vendor-ID"]);
    editor.end();
}

/// The server ends when the editor disconnects.
#[test]
fn without_an_editor_it_ends() {
    let mut editor = Editor::start(&["utf-16"]);
    editor.to = None;
    assert!(editor.server.wait().unwrap().code().is_some_and(|status| status <= 2));
}

/// The extension for Visual Studio Code: the files that its manifest names exist, and it starts this command.
#[test]
fn the_extension_is_whole() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("editors/vscode");
    let read = |name: &str| -> String { std::fs::read_to_string(folder.join(name)).unwrap() };
    let manifest: Value = serde_json::from_str(&read("package.json")).unwrap();
    for field in ["name", "displayName", "description", "version", "publisher", "license"] {
        assert!(manifest[field].as_str().is_some_and(|text| !text.is_empty()), "{field}");
    }
    let is_name = |character: char| character.is_ascii_lowercase() || character == '-';
    assert!(manifest["name"].as_str().unwrap().chars().all(is_name));
    assert!(manifest["engines"]["vscode"].as_str().unwrap().starts_with('^'));
    let locked: Value = serde_json::from_str(&read("package-lock.json")).unwrap();
    let own = &locked["packages"][""];
    assert_eq!((&own["version"], &own["dependencies"]), (&manifest["version"], &manifest["dependencies"]));
    let contributes = &manifest["contributes"];
    assert_eq!(contributes["languages"][0]["id"], contributes["grammars"][0]["language"]);
    assert_eq!(contributes["languages"][0]["extensions"], json!([".eds", ".dcf"]));
    for named in [&contributes["languages"][0]["configuration"], &contributes["grammars"][0]["path"]] {
        serde_json::from_str::<Value>(&read(named.as_str().unwrap())).unwrap();
    }
    let grammar: Value = serde_json::from_str(&read(contributes["grammars"][0]["path"].as_str().unwrap())).unwrap();
    assert_eq!(grammar["scopeName"], contributes["grammars"][0]["scopeName"]);
    let main = read(manifest["main"].as_str().unwrap());
    assert!(main.contains("args: [\"lsp\"]"));
    assert!(main.contains(&format!("language: {}", contributes["languages"][0]["id"])));
    let setting = contributes["configuration"]["properties"].as_object().unwrap().keys().next().unwrap();
    let (section, name) = setting.split_once('.').unwrap();
    assert!(main.contains(&format!("getConfiguration(\"{section}\").get(\"{name}\")")));
}
