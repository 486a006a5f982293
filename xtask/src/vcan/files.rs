//! The files in the memory of the emulated machine. The machine has no disk and no access to the disk of this computer:
//! waiting for a disk takes a different time in each run, while everything else in the machine follows a clock that
//! counts instructions.

use super::kernel::Kernel;
use super::{FOLDER, Job};
use crate::peers::PYTHON;
use crate::run::{quoted, run};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Programs that the tests start.
const PROGRAMS: [&str; 3] = ["ip", "chrt", "nice"];
/// Other people's programs that the tests start.
const PEERS: [&str; 6] = ["cansend", "candump", "cangen", "canplayer", "slcan_attach", "python"];
/// Folders of this project that the tests read.
const PROJECT: [&str; 3] = ["docs/examples", "conformance/device/models", "tests/vcan"];
/// The packages of the Python environment that the tests need: each text begins the name of a folder or file.
const PACKAGES: [&str; 7] = ["can", "packaging", "pyserial", "python_can", "serial", "typing_extensions", "wrapt"];
/// Parts of Python's library that the tests do not need, in any folder: unpacking them takes the machine longer than
/// booting its kernel. Each text begins the name of a folder or file.
const UNNEEDED: [&str; 18] = [
    "_ctypes_test",
    "_test",
    "_tkinter",
    "config-",
    "curses",
    "distutils",
    "ensurepip",
    "idlelib",
    "lib2to3",
    "pydoc_data",
    "site-packages",
    "test",
    "tkinter",
    "turtle",
    "unittest",
    "venv",
    "wsgiref",
    "xmlrpc",
];

/// Makes the archive of all files, which the kernel unpacks into its memory. `names`: the tests of each machine.
/// `settings`: variables of the tests' environment.
pub fn archive(kernel: &Kernel, job: &Job, names: &[Vec<String>], settings: &[(&str, &str)]) -> Result<PathBuf> {
    let root = std::env::current_dir()?;
    let stage = root.join(FOLDER).join("stage");
    let _ = fs::remove_dir_all(&stage);
    for folder in ["bin", "dev", "modules", "out", "proc", "root", "run", "sys", "tests", "tmp"] {
        fs::create_dir_all(stage.join(folder))?;
    }
    let mut files = Files::default();
    fs::copy(found("busybox")?, stage.join("bin/busybox"))?;
    for program in PROGRAMS {
        files.add_program(&found(program)?)?;
    }
    if job.needs_peers {
        for program in PEERS {
            files.add_program(&if program == "python" { root.join(PYTHON) } else { found(program)? })?;
        }
        files.add_python(&root)?;
    }
    for folder in PROJECT {
        files.add_folder(&root.join(folder), &|_| true)?;
    }
    for binary in [&job.program, &job.starts] {
        files.add_needs_of(binary)?;
        strip(binary, &stage)?;
    }
    for library in files.0.extract_if(.., |path| is_library_of_python(path)) {
        strip(&library, &stage)?;
    }
    let init = root.join("tests/vcan/init");
    fs::copy(&init, stage.join("init"))?;
    fs::set_permissions(stage.join("init"), fs::Permissions::from_mode(0o755))?;
    let mut order = String::new();
    for module in kernel.modules()? {
        let name = module.file_name().unwrap_or_default().to_string_lossy().into_owned();
        fs::copy(&module, stage.join("modules").join(&name))?;
        order += &format!("{name}\n");
    }
    fs::write(stage.join("modules/order"), order)?;
    for (machine, names) in names.iter().enumerate() {
        fs::write(stage.join("tests").join(machine.to_string()), names.join("\n") + "\n")?;
    }
    let [program, starts, project] = [&job.program, &job.starts, &root].map(|path| quoted(&path.to_string_lossy()));
    let [before, after] = job.arguments.each_ref().map(|words| quoted(words));
    let mut text = format!("program={program}\nstarts={starts}\nproject={project}\nbefore={before}\nafter={after}\n");
    for (name, value) in settings {
        text += &format!("export {name}={}\n", quoted(value));
    }
    fs::write(stage.join("settings"), text)?;
    files.pack(&stage, &root.join(FOLDER).join("files.cpio"))
}

/// Whether a file is Python's shared library. If the user has built Python, three quarters of this file are symbols for
/// debuggers.
fn is_library_of_python(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libpython"))
}

/// Paths of files and folders of this machine, which are the same in the archive.
#[derive(Default)]
struct Files(BTreeSet<PathBuf>);

impl Files {
    /// Adds a file or folder with the folders above it.
    fn add(&mut self, path: &Path) {
        self.0.extend(path.ancestors().filter(|above| above.parent().is_some()).map(Path::to_owned));
    }

    fn add_program(&mut self, path: &Path) -> Result<()> {
        self.add(path);
        self.add_needs_of(path)
    }

    /// Adds the libraries of a program or library, as its loader finds them.
    fn add_needs_of(&mut self, path: &Path) -> Result<()> {
        let output = Command::new("ldd").arg(path).output().context("ldd")?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        for library in text.split_whitespace().filter(|word| word.starts_with('/')) {
            self.add(Path::new(library.trim_end_matches(':')));
        }
        Ok(())
    }

    /// Adds a folder with all files whose names `wanted` accepts.
    fn add_folder(&mut self, folder: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<()> {
        self.add(folder);
        for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if !wanted(&path.file_name().unwrap_or_default().to_string_lossy()) {
                continue;
            }
            if path.is_dir() {
                self.add_folder(&path, wanted)?;
            } else {
                self.add(&path);
                if path.extension().is_some_and(|extension| extension == "so") {
                    self.add_needs_of(&path)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the interpreter's library and the packages of the environment.
    fn add_python(&mut self, root: &Path) -> Result<()> {
        let ask =
            "import sys, sysconfig as s; print(s.get_path('stdlib'), s.get_path('purelib'), sys.prefix, sep='\\n')";
        let output = Command::new(root.join(PYTHON)).args(["-c", ask]).output().context(PYTHON)?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let [library, packages, prefix] = text.lines().collect::<Vec<_>>()[..] else {
            anyhow::bail!("{PYTHON} does not say where its library is");
        };
        let needed =
            |name: &str| !name.contains(".opt-") && UNNEEDED.iter().all(|unneeded| !name.starts_with(unneeded));
        self.add_folder(Path::new(library), &needed)?;
        for entry in fs::read_dir(packages).with_context(|| packages.to_owned())? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if !PACKAGES.iter().any(|package| name.starts_with(package)) {
                continue;
            }
            if path.is_dir() { self.add_folder(&path, &needed)? } else { self.add(&path) }
        }
        self.add(&Path::new(prefix).join("pyvenv.cfg"));
        Ok(())
    }

    /// Packs the files, and the folder `stage` over them. Links are followed, which costs less than keeping the links
    /// in all paths.
    fn pack(&self, stage: &Path, archive: &Path) -> Result<PathBuf> {
        let mut out = fs::File::create(archive)?;
        let list: Vec<String> = self.0.iter().map(|path| path.to_string_lossy().into_owned()).collect();
        let names = list.iter().map(|path| path.trim_start_matches('/')).collect::<Vec<_>>().join("\n");
        for (folder, names) in [(Path::new("/"), names), (stage, found_below(stage)?)] {
            let args = ["--create", "--format=newc", "--dereference", "--quiet"];
            let mut cpio = Command::new("cpio");
            cpio.args(args).current_dir(folder).stdin(Stdio::piped()).stdout(out.try_clone()?);
            let mut cpio = cpio.spawn().context("cpio")?;
            cpio.stdin.take().context("cpio has no input")?.write_all(names.as_bytes())?;
            let status = cpio.wait()?;
            ensure!(status.success(), "cpio ended with {status}");
        }
        out.flush()?;
        Ok(archive.to_owned())
    }
}

/// All paths below a folder, relative to it.
fn found_below(folder: &Path) -> Result<String> {
    let output = Command::new("find").arg(".").current_dir(folder).output().context("find")?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The path of a program.
fn found(program: &str) -> Result<PathBuf> {
    let path = std::env::var("PATH").unwrap_or_default() + ":/usr/sbin:/sbin";
    let mut paths = path.split(':').map(|folder| Path::new(folder).join(program));
    paths.find(|path| path.is_file()).with_context(|| format!("{program} is not installed"))
}

/// Copies a binary without symbols for debuggers, under the same path.
fn strip(binary: &Path, stage: &Path) -> Result<()> {
    let copy = stage.join(binary.strip_prefix("/")?);
    fs::create_dir_all(copy.parent().context("a binary has a folder")?)?;
    run("strip", &["-o", &copy.to_string_lossy(), &binary.to_string_lossy()])
}
