//! Pictures of device descriptions: the output of a check, of `eds show`, and an editor with the language server.

use super::{FOLDER, photograph, terminal};
use crate::measure::release;
use crate::packages::{Package, install};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

const EDITOR: Package = Package { program: "nvim", probe: &["--version"], package: "neovim" };
const TERMINAL: Package = Package { program: "tmux", probe: &["-V"], package: "tmux" };

const RIGHT: &str = "conformance/device/models/reference-406.eds";
/// The faults of the description in the pictures.
const DAMAGES: [(&str, &str); 3] = [
    ("CreationTime=02:00PM\n", "CreationTime=21:30\n"),
    ("[1017]\nParameterName=Producer heartbeat time\n", "[1017]\nParameterName=Guard time\n"),
    ("DefaultValue=0x64000108\n", "DefaultValue=0x64000110\n"),
];
/// Options for a separate tmux server, so that no session of the user is touched.
const TMUX: [&str; 3] = ["-L", "canvass-screenshot", "-f/dev/null"];

/// Takes the pictures.
///
/// # Errors
/// If a program can't be run, or its output is not the expected one.
pub fn descriptions() -> Result<()> {
    install(&[EDITOR, TERMINAL])?;
    let mut text = fs::read_to_string(RIGHT)?;
    for (right, wrong) in DAMAGES {
        ensure!(text.contains(right), "{RIGHT} has no {right:?}");
        text = text.replacen(right, wrong, 1);
    }
    let file = format!("{FOLDER}/encoder.eds");
    fs::write(&file, text.replacen("FileName=reference-406.eds", "FileName=encoder.eds", 1))?;
    check(&file)?;
    shown(&file)?;
    editor(&file)
}

fn check(file: &str) -> Result<()> {
    let told = canvass(&["eds", "check", "--ignore", "eds/pdo/either-direction", file])?;
    ensure!(told.contains("eds/pdo/length") && told.contains("eds/file/time"), "the check says {told}");
    of_terminal(&told, "docs/eds-check.png", (1000, 640))
}

fn shown(file: &str) -> Result<()> {
    let told = canvass(&["eds", "show", file, "6004"])?;
    of_terminal(&told, "docs/eds-show.png", (760, 410))?;
    let page = format!("{FOLDER}/description.html");
    let html = Command::new(release("canvass")).args(["eds", "show", RIGHT, "--format", "html"]).output()?;
    fs::write(&page, html.stdout)?;
    photograph(&page, "docs/eds-page.png", (1000, 700))
}

/// The output of canvass on a terminal with colours.
fn canvass(args: &[&str]) -> Result<String> {
    let output = Command::new(release("canvass")).args(["--color", "always"]).args(args).output()?;
    ensure!(output.status.code().is_some_and(|status| status < 2), "canvass {args:?} ended with {}", output.status);
    let name = format!("{FOLDER}/");
    Ok(String::from_utf8_lossy(&output.stdout).replace(&name, ""))
}

fn of_terminal(text: &str, picture: &str, size: (u16, u16)) -> Result<()> {
    let page = format!("{FOLDER}/terminal.html");
    fs::write(&page, terminal::page(text))?;
    photograph(&page, picture, size)
}

/// Takes a picture of Neovim with the findings of a line, and the description of the object under its cursor.
fn editor(file: &str) -> Result<()> {
    let program = fs::canonicalize(release("canvass"))?;
    let settings = format!("{FOLDER}/init.lua");
    // The space below the cursor makes Neovim show the description of an object above it, where it hides no finding.
    let start = "vim.o.number = true; vim.o.ruler = false; vim.o.laststatus = 0\n\
        vim.o.hlsearch = false; vim.o.scrolloff = 10\n\
        vim.cmd('highlight SignColumn ctermbg=NONE | highlight LineNr ctermfg=8')\n\
        vim.cmd('highlight NormalFloat ctermbg=0 ctermfg=15')\n\
        vim.diagnostic.config({ severity_sort = true })\n\
        local client = vim.lsp.start_client({ name = 'canvass', cmd = { PROGRAM, 'lsp' } })\n\
        vim.api.nvim_create_autocmd('BufReadPost', { callback = function(of) vim.lsp.buf_attach_client(of.buf, client) end })\n";
    fs::write(&settings, start.replace("PROGRAM", &format!("{:?}", program.to_string_lossy())))?;
    let command = format!("nvim --clean -u {settings} {file}");
    tmux(&["new-session", "-d", "-x", "104", "-y", "30", &command])?;
    let seen = session();
    // The server is ended also after an error.
    tmux(&["kill-server"])?;
    of_terminal(&seen?, "docs/eds-editor.png", (940, 560))
}

/// Goes to a section, requests its description, and returns the screen.
fn session() -> Result<String> {
    tmux(&["send-keys", r"/^\[1017\]", "Enter", "z", "b"])?;
    seen("the name of another")?;
    tmux(&["send-keys", "l", "l", ":lua vim.lsp.buf.hover()", "Enter"])?;
    seen("CiA 301 7.5.2.20")?;
    // Clears the line of the last command.
    tmux(&["send-keys", ":echo", "Enter"])?;
    seen("CiA 301 7.5.2.20")
}

/// Returns the screen as soon as it contains this text.
fn seen(wanted: &str) -> Result<String> {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        let screen = tmux(&["capture-pane", "-e", "-p"])?;
        let screen = String::from_utf8_lossy(&screen.stdout).into_owned();
        if screen.contains(wanted) {
            return Ok(screen);
        }
        if Instant::now() > until {
            bail!("the editor does not show {wanted:?} but\n{screen}");
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn tmux(args: &[&str]) -> Result<Output> {
    let output = Command::new("tmux").args(TMUX).args(args).output().context("can't run tmux")?;
    ensure!(output.status.success(), "tmux {args:?}: {}", String::from_utf8_lossy(&output.stderr));
    Ok(output)
}
