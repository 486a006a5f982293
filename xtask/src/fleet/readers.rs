//! Examples of other programs that read a lake: their results must equal those of canvass-fleet.

use super::TARGET;
use crate::packages::{Package, install};
use crate::run::run;
use crate::venv::Venv;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// The Python with the libraries.
pub const PYTHON: &str = "target/fleet-venv/bin/python";
/// The Python environment of all readers but Spark.
pub const VENV: Venv = Venv {
    folder: "target/fleet-venv",
    python: PYTHON,
    requirements: "fleet/requirements.txt",
    probe: "import can, duckdb, pandas, polars, pyarrow",
};

/// Apache Spark, separately: it is larger than all others, and needs Java.
const SPARK: Venv = Venv {
    folder: "target/spark-venv",
    python: "target/spark-venv/bin/python",
    requirements: "fleet/requirements-spark.txt",
    probe: "import pyspark",
};
const JAVA: Package = Package { program: "java", probe: &["-version"], package: "openjdk-17-jre-headless" };

/// The examples with their interpreters; each must print the result of [`STATEMENT`].
const EXAMPLES: [(&str, &str); 4] = [
    ("docs/examples/fleet-duckdb.py", PYTHON),
    ("docs/examples/fleet-polars.py", PYTHON),
    ("docs/examples/fleet-pandas.py", PYTHON),
    ("docs/examples/fleet-spark.py", SPARK.python),
];
const STATEMENT: &str = "SELECT arrow_cast(service, 'Utf8') AS service, count(*) AS frames FROM messages \
                         GROUP BY service ORDER BY service";

/// Installs the readers: both Python environments, and Java.
///
/// # Errors
/// If an installation fails.
pub fn install_all() -> Result<()> {
    install(&[JAVA])?;
    VENV.install()?;
    SPARK.install()
}

/// Makes a lake and lets each example read it.
///
/// # Errors
/// If a result differs.
pub fn read() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let lake = folder.path().join("lake").display().to_string();
    let fleet = format!("{TARGET}/debug/canvass-fleet");
    run(&fleet, &["ingest", "traces/samples", "docs/examples", "--into", &lake])?;
    let expected = output(&fleet, &["sql", STATEMENT, "--lake", &lake, "--format", "csv"])?;
    ensure!(expected.lines().count() > 5, "the lake has only {expected}");
    for (example, python) in EXAMPLES {
        let found = output(python, &[example, &lake])?;
        ensure!(found == expected, "{example}: expected the rows of canvass-fleet\n{expected}found\n{found}");
        eprintln!("{example}: the same {} rows", expected.lines().count() - 1);
    }
    Ok(())
}

/// The output of a program.
fn output(program: &str, words: &[&str]) -> Result<String> {
    eprintln!("$ {program} {}", words.join(" "));
    let ended = Command::new(program).args(words).output().with_context(|| format!("can't run {program}"))?;
    let told = String::from_utf8_lossy(&ended.stderr);
    ensure!(ended.status.success(), "{program} ended with {}: {told}", ended.status);
    // Python for Windows writes CR LF.
    Ok(String::from_utf8(ended.stdout)?.replace("\r\n", "\n"))
}
