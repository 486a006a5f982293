//! Container images: the program and nothing else. Each file is an image as the Open Container Initiative describes it,
//! and has beside it what `docker load` reads.

use super::{FOLDER, VERSION, hash, name, scratch, system};
use crate::run::run;
use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The time of everything in an image, so that the same program gives the same image.
const DATE: &str = "1970-01-01T00:00:00Z";

/// An image holds the programs for Linux.
pub fn prepare() -> Result<()> {
    ensure!(system::AARCH64.program().exists(), "it holds the programs for Linux: cargo xtask dist linux");
    Ok(())
}

/// An image for each processor.
pub fn make() -> Result<Vec<String>> {
    system::LINUX.iter().map(|system| image(system)).collect()
}

/// The folder of an image under construction: blobs that are named by their hash.
struct Layout(PathBuf);

impl Layout {
    /// Keeps a blob; returns how others refer to it.
    fn add(&self, kind: &str, bytes: &[u8]) -> Result<Value> {
        let hash = hash(bytes);
        fs::write(self.0.join("blobs/sha256").join(&hash), bytes)?;
        Ok(json!({ "mediaType": kind, "digest": format!("sha256:{hash}"), "size": bytes.len() }))
    }

    fn write(&self, file: &str, value: &Value) -> Result<()> {
        fs::write(self.0.join(file), serde_json::to_vec_pretty(value)?).context(file.to_owned())
    }
}

/// The path of a blob in an image.
fn path(reference: &Value) -> Result<String> {
    let digest = reference["digest"].as_str().context("a digest")?;
    Ok(format!("blobs/{}", digest.replace(':', "/")))
}

fn image(system: &system::System) -> Result<String> {
    let layout = Layout(scratch("image")?);
    fs::create_dir_all(layout.0.join("blobs/sha256"))?;
    let layer = fs::read(layer(system)?)?;
    let layers = [layout.add("application/vnd.oci.image.layer.v1.tar", &layer)?];
    let config = serde_json::to_vec(&config(system, &hash(&layer)))?;
    let config = layout.add("application/vnd.oci.image.config.v1+json", &config)?;
    let kind = "application/vnd.oci.image.manifest.v1+json";
    let manifest = json!({ "schemaVersion": 2, "mediaType": kind, "config": config, "layers": layers });
    let mut entry = layout.add(kind, &serde_json::to_vec(&manifest)?)?;
    entry["platform"] = json!({ "os": "linux", "architecture": system.container });
    entry["annotations"] = json!({ "org.opencontainers.image.ref.name": VERSION });
    let index = "application/vnd.oci.image.index.v1+json";
    layout.write("oci-layout", &json!({ "imageLayoutVersion": "1.0.0" }))?;
    layout.write("index.json", &json!({ "schemaVersion": 2, "mediaType": index, "manifests": [entry] }))?;
    // What Docker reads of an image that it did not fetch by itself.
    let tag = format!("canvass:{VERSION}");
    let loaded = json!([{ "Config": path(&config)?, "RepoTags": [tag], "Layers": [path(&layers[0])?] }]);
    layout.write("manifest.json", &loaded)?;
    let file = format!("{}.oci.tar", name(&format!("linux-{}", system.container)));
    tar(&layout.0, &Path::new(FOLDER).join(&file))?;
    Ok(file)
}

/// The only layer: the program, a place to work, and one for temporary files.
fn layer(system: &system::System) -> Result<PathBuf> {
    let work = scratch("layer")?;
    let root = work.join("root");
    for folder in ["usr/bin", "tmp", "work"] {
        fs::create_dir_all(root.join(folder))?;
    }
    fs::copy(system.program(), root.join("usr/bin/canvass")).context("the program")?;
    // Whoever runs the image may write there, also without being root.
    run("chmod", &["1777", &root.join("tmp").to_string_lossy(), &root.join("work").to_string_lossy()])?;
    let file = work.join("layer.tar");
    tar(&root, &file)?;
    Ok(file)
}

/// How the image is run, and what is in it.
fn config(system: &system::System, layer: &str) -> Value {
    let labels = json!({
        "org.opencontainers.image.title": "canvass",
        "org.opencontainers.image.description": "CANopen trace analyzer and protocol conformance tester",
        "org.opencontainers.image.version": VERSION,
        "org.opencontainers.image.revision": system::commit(),
        "org.opencontainers.image.licenses": "MIT OR Apache-2.0",
    });
    json!({
        "created": DATE,
        "os": "linux",
        "architecture": system.container,
        "config": {
            "Entrypoint": ["/usr/bin/canvass"],
            "Env": ["PATH=/usr/bin", "TMPDIR=/tmp"],
            "WorkingDir": "/work",
            "Labels": labels,
        },
        "rootfs": { "type": "layers", "diff_ids": [format!("sha256:{layer}")] },
        "history": [{ "created": DATE, "created_by": "cargo xtask dist" }],
    })
}

/// Packs what is in a folder. The same files give the same bytes.
fn tar(folder: &Path, file: &Path) -> Result<()> {
    let order = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0", "--format=ustar"];
    let (folder, file) = (folder.to_string_lossy(), file.to_string_lossy());
    run("tar", &[&order[..], &["--transform=s,^\\./,,", "-C", &folder, "-cf", &file, "."]].concat())
}
