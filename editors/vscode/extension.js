"use strict";
// Starts `canvass lsp` for EDS and DCF files; everything else is the server's.

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function activate() {
  const command = workspace.getConfiguration("canvass").get("path") || "canvass";
  const server = { command, args: ["lsp"] };
  const documents = { documentSelector: [{ language: "eds" }] };
  client = new LanguageClient("canvass", "canvass", server, documents);
  return client.start();
}

function deactivate() {
  return client && client.stop();
}

module.exports = { activate, deactivate };
