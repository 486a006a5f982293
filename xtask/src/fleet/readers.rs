//! The examples of other programs that read a lake: they find what canvass-fleet itself answers.

use super::TARGET;
use crate::packages::{Package, install};
use crate::run::run;
use crate::venv::Venv;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// Where the Python libraries are.
pub const PYTHON: &str = "target/fleet-venv/bin/python";
/// What is installed there.
pub const VENV: Venv = Venv {
    folder: "target/fleet-venv",
    python: PYTHON,
    requirements: "fleet/requirements.txt",
    probe: "import can, duckdb, pandas, polars, pyarrow",
};

/// Apache Spark by itself: it is larger than all others, and needs Java.
const SPARK: Venv = Venv {
    folder: "target/spark-venv",
    python: "target/spark-venv/bin/python",
    requirements: "fleet/requirements-spark.txt",
    probe: "import pyspark",
};
const JAVA: Package = Package { program: "java", probe: &["-version"], package: "openjdk-17-jre-headless" };

/// The examples with what runs them, each of which prints what the statement below gives.
const EXAMPLES: [(&str, &str); 4] = [
    ("docs/examples/fleet-duckdb.py", PYTHON),
    ("docs/examples/fleet-polars.py", PYTHON),
    ("docs/examples/fleet-pandas.py", PYTHON),
    ("docs/examples/fleet-spark.py", SPARK.python),
];
const STATEMENT: &str = "SELECT arrow_cast(service, 'Utf8') AS service, count(*) AS frames FROM messages \
                         GROUP BY service ORDER BY service";

/// Installs all of them.
///
/// # Errors
/// If something can't be installed.
pub fn install_all() -> Result<()> {
    install(&[JAVA])?;
    VENV.install()?;
    SPARK.install()
}

/// Makes a lake and has all of them read it.
///
/// # Errors
/// If one of them finds something else.
pub fn read() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let lake = folder.path().join("lake").display().to_string();
    let fleet = format!("{TARGET}/debug/canvass-fleet");
    run(&fleet, &["ingest", "traces/samples", "docs/examples", "--into", &lake])?;
    let expected = output(&fleet, &["sql", STATEMENT, "--lake", &lake, "--format", "csv"])?;
    ensure!(expected.lines().count() > 5, "the lake has only {expected}");
    for (example, python) in EXAMPLES {
        let found = output(python, &[example, &lake])?;
        ensure!(found == expected, "{example} finds\n{found}and canvass-fleet\n{expected}");
        eprintln!("{example}: the same {} rows", expected.lines().count() - 1);
    }
    Ok(())
}

/// What a program prints.
fn output(program: &str, words: &[&str]) -> Result<String> {
    eprintln!("$ {program} {}", words.join(" "));
    let ended = Command::new(program).args(words).output().with_context(|| format!("can't run {program}"))?;
    let told = String::from_utf8_lossy(&ended.stderr);
    ensure!(ended.status.success(), "{program} ended with {}: {told}", ended.status);
    // A library of Python for Windows ends lines in its own way.
    Ok(String::from_utf8(ended.stdout)?.replace("\r\n", "\n"))
}
