#!/usr/bin/env node
"use strict";
// Starts the program, which a package for each system brings: npm installs only that of this system.

const { spawn } = require("child_process");
const { constants } = require("os");

const name = `@canvass/${process.platform}-${process.arch}`;
let program;
try {
  program = require.resolve(`${name}/${process.platform === "win32" ? "canvass.exe" : "canvass"}`);
} catch {
  console.error(
    `canvass: expected the package ${name} beside this one, found none. There is a program for linux-x64, linux-arm64 and ` +
      "win32-x64; if this is one of them, install again without --omit=optional.",
  );
  process.exit(2);
}
const child = spawn(program, process.argv.slice(2), { stdio: "inherit" });
// Ctrl-C reaches the program from the terminal itself; it first puts the device back. What else ends this process is passed on.
process.on("SIGINT", () => {});
for (const signal of ["SIGTERM", "SIGHUP"]) process.on(signal, () => child.kill(signal));
child.on("error", (error) => {
  console.error(`canvass: ${program} can't be started: ${error.message}`);
  process.exit(2);
});
child.on("exit", (status, signal) => process.exit(signal ? 128 + constants.signals[signal] : status));
