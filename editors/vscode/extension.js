"use strict";
// Starts `canvass lsp` for device descriptions; everything else is the server's.

const { existsSync } = require("fs");
const { join } = require("path");
const { spawnSync } = require("child_process");
const { commands, window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const LANGUAGES = [{ language: "eds" }, { language: "xml", pattern: "**/*.{xdd,xdc,XDD,XDC}" }];
const SETTINGS = "Open settings";
const RETRY = "Try again";

let client;

/** The program: that of the setting, the one that this extension brings, or the one in the PATH. */
function program(context) {
  const set = workspace.getConfiguration("canvass").get("path");
  if (set) return set;
  const brought = join(context.extensionPath, "server", process.platform === "win32" ? "canvass.exe" : "canvass");
  return existsSync(brought) ? brought : "canvass";
}

/** What is wrong with a program, or nothing. */
function wrong(command) {
  const told = spawnSync(command, ["--version"], { encoding: "utf8", timeout: 10000 });
  if (told.error) return `${command} can't be started: ${told.error.message}`;
  if (told.status !== 0) return `${command} --version ended with status ${told.status}`;
  return undefined;
}

async function start(context) {
  const command = program(context);
  const reason = wrong(command);
  if (reason) {
    const message = `${reason}. Install canvass, or name it in the setting canvass.path.`;
    const button = await window.showErrorMessage(message, SETTINGS, RETRY);
    if (button === SETTINGS) await commands.executeCommand("workbench.action.openSettings", "canvass.path");
    if (button === RETRY) await start(context);
    return;
  }
  client = new LanguageClient("canvass", "canvass", { command, args: ["lsp"] }, { documentSelector: LANGUAGES });
  await client.start();
}

async function stop() {
  const old = client;
  client = undefined;
  if (old) await old.stop();
}

function activate(context) {
  const restart = async () => {
    await stop();
    await start(context);
  };
  const changed = (event) => event.affectsConfiguration("canvass.path") && restart();
  context.subscriptions.push(
    workspace.onDidChangeConfiguration(changed),
    commands.registerCommand("canvass.restart", restart),
  );
  // The message about a missing program waits for the user; the start of the editor does not.
  start(context);
}

module.exports = { activate, deactivate: stop };
