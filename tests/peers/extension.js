"use strict";
// Starts the extension as Visual Studio Code does, with a stand-in for the editor, the real library for language
// clients and the real server. The variable CANVASS names the program, the argument the extension's folder.

const assert = require("node:assert");
const Module = require("node:module");
const path = require("node:path");
const { Editor, Position } = require("./vscode.js");

const TEXT = "[DeviceInfo]\nVendorName=Example\nLSS_Supported=yes\n[1000]\nParameterName=Device type\n";
const URI = "file:///work/encoder.eds";

const editor = new Editor();
const api = editor.api();
const load = Module._load;
Module._load = (name, ...rest) => (name === "vscode" ? api : load(name, ...rest));

/// The next published findings of the file.
function published() {
  return new Promise((resolve) => {
    const subscription = editor.published.event(() => {
      subscription.dispose();
      resolve(editor.findings.get(URI) ?? []);
    });
  });
}

async function main() {
  const folder = path.resolve(process.argv[2]);
  const manifest = require(path.join(folder, "package.json"));
  const language = manifest.contributes.languages[0];
  editor.settings["canvass.path"] = process.env.CANVASS;
  const extension = require(path.join(folder, manifest.main));
  await extension.activate({ subscriptions: [] });

  const findings = published();
  const document = editor.open(URI, language.id, TEXT);
  const flag = (await findings).find((found) => found.code === "eds/field/flag");
  assert.equal(flag.severity, api.DiagnosticSeverity.Warning);
  assert.deepEqual({ ...flag.range.start }, { line: 2, character: 14 });
  console.log(`${(await findings).length > 1 ? "findings" : "one finding"} of ${language.id}`);

  const { selector, provider } = editor.providers.get("Hover");
  assert.equal(api.languages.match(selector, document), 10);
  const shown = await provider.provideHover(document, new Position(3, 2), new api.CancellationTokenSource().token);
  assert.match(shown.contents[0].value, /Device type/);
  console.log("hover");

  const formatting = editor.providers.get("DocumentFormattingEdit").provider;
  const options = { tabSize: 4, insertSpaces: true };
  const none = new api.CancellationTokenSource().token;
  const edits = await formatting.provideDocumentFormattingEdits(document, options, none);
  assert.ok(edits.some((edit) => edit.newText.includes("1")));
  console.log("edits");

  const { provideWorkspaceSymbols } = editor.providers.get("WorkspaceSymbol").provider;
  const symbols = await provideWorkspaceSymbols("device type", none);
  assert.ok(symbols.length >= 1);
  const { provideFoldingRanges } = editor.providers.get("FoldingRange").provider;
  assert.ok((await provideFoldingRanges(document, {}, none)).length >= 1);
  console.log("symbols");

  const gone = published();
  editor.close(document);
  assert.deepEqual(await gone, []);
  await extension.deactivate();
  console.log("ended");
}

main().catch((error) => {
  console.error(error, editor.messages);
  process.exit(1);
});
