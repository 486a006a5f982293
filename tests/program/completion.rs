//! The completions that a shell gets.

use crate::running::{command, finished, run};

/// The completions that bash would offer for the last of these words.
fn offered(words: &[&str]) -> Vec<String> {
    let mut asked = command(&[&["--", "canvass"], words].concat());
    asked.env("COMPLETE", "bash").env("_CLAP_IFS", "\n").env("_CLAP_COMPLETE_INDEX", words.len().to_string());
    let answered = finished(asked.output().unwrap());
    assert_eq!(answered.status, 0, "{}", answered.stderr);
    answered.stdout.lines().map(str::to_owned).collect()
}

/// A folder in the notation of the system's shells.
const FOLDER: (&str, &str) =
    if cfg!(windows) { (r"63=docs\exam", r"63=docs\examples\") } else { ("63=docs/exam", "63=docs/examples/") };

#[test]
fn values_are_known() {
    for (words, expected) in [
        (&["test", "sim:kuebler-sendix-m"][..], "sim:kuebler-sendix-m58"),
        (&["test", "sim:reference-301+boot-up-tw"], "sim:reference-301+boot-up-twice"),
        (&["test", "--device", "kuebler-sendix-m"], "kuebler-sendix-m58"),
        (&["decode", "--device", "5=kuebler-sendix-m"], "5=kuebler-sendix-m58"),
        (&["test", "--select", "301/nmt/back"], "301/nmt/back-to-back"),
        (&["test", "--exclude", "305,301/nmt/back"], "305,301/nmt/back-to-back"),
        (&["fuzz", "--allow", "nvm,node"], "nvm,node-id"),
        (&["test", "--allow", "al"], "all"),
        (&["test", "--timeout", "boot"], "boot-up="),
        (&["selftest", "--fault", "boot-up-tw"], "boot-up-twice"),
        (&["explain", "bus/malf"], "bus/malformed"),
        (&["explain", "pcapn"], "pcapng"),
        (&["diagnose", "--threshold", "bus/load.per"], "bus/load.percent="),
        (&["diagnose", "--format", "mark"], "markdown"),
        (&["diagnose", "--device", FOLDER.0], FOLDER.1),
    ] {
        let offered = offered(words);
        assert!(offered.iter().any(|word| word == expected), "{words:?}: {offered:?}");
    }
}

#[test]
fn every_shell_has_a_script() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run(&["completions", shell]);
        assert!(script.status == 0 && script.stdout.contains("COMPLETE"), "{shell}: {}", script.stderr);
    }
    assert_eq!(run(&["completions", "nosuch"]).status, 2);
}

#[test]
fn manual_pages_say_what_the_exit_status_means() {
    for page in [&["man"][..], &["man", "test"], &["man", "sdo read"], &["man", "sdo", "read"]] {
        let shown = run(page);
        assert!(shown.status == 0 && shown.stdout.contains("Exit status: 0 good"), "{page:?}: {}", shown.stderr);
    }
    assert!(run(&["man", "sdo read"]).stdout.contains("canvass\\-sdo\\-read"));
    assert_eq!(run(&["man", "sdo dance"]).status, 2);
}
