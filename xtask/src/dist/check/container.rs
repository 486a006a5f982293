//! The container images: read by skopeo, which knows both forms, then unpacked, and run with the image as the whole file
//! system, by a user without rights.

use super::{archives, bare, clean, exercise, output, sample_in};
use crate::dist::{files, hash, system};
use crate::packages::{self, Package};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const SKOPEO: Package = Package { program: "skopeo", probe: &["--version"], package: "skopeo" };
/// A user and group that no image knows.
const NOBODY: &str = "--userspec=12345:12345";

/// Reads and runs both images.
pub fn run() -> Result<String> {
    packages::install(&[SKOPEO])?;
    archives::install_emulators()?;
    for (system, image) in system::LINUX.iter().zip(files("container")?) {
        for form in ["oci-archive", "docker-archive"] {
            let mut skopeo = Command::new(SKOPEO.program);
            let told = output(skopeo.args(["inspect", "--config"]).arg(format!("{form}:{}", image.display())))?;
            let config: Value = serde_json::from_str(&told).with_context(|| format!("{form}: {told}"))?;
            ensure!(config["architecture"] == system.container, "{form}: {told}");
        }
        let root = unpack(&image)?;
        let sample = sample_in(&root)?;
        if system.emulator.is_none() {
            let user = |words: &[&str]| {
                let mut chroot = bare("chroot");
                chroot.arg(NOBODY).arg(&root).arg("/usr/bin/canvass").args(words);
                chroot
            };
            exercise(&user, sample)?;
        } else {
            let sample = super::absolute(&root.join(&sample[1..]))?;
            exercise(&|words| archives::runner(system, &root.join("usr/bin/canvass"), words), &sample)?;
        }
    }
    Ok("read by skopeo in both forms; run with the image as file system, without rights".to_owned())
}

/// Unpacks the layers of an image, after a look at each hash.
fn unpack(image: &Path) -> Result<PathBuf> {
    let folder = clean("image")?;
    output(bare("tar").arg("-xf").arg(image.canonicalize()?).arg("-C").arg(&folder))?;
    for blob in fs::read_dir(folder.join("blobs/sha256"))? {
        let blob = blob?;
        let found = hash(&fs::read(blob.path())?);
        ensure!(blob.file_name().to_string_lossy() == found, "{} has the hash {found}", blob.path().display());
    }
    let loaded: Value = serde_json::from_slice(&fs::read(folder.join("manifest.json"))?)?;
    let root = folder.join("root");
    fs::create_dir_all(&root)?;
    for layer in loaded[0]["Layers"].as_array().context("layers")? {
        let layer = folder.join(layer.as_str().context("a layer")?);
        output(bare("tar").arg("-xpf").arg(layer).arg("-C").arg(&root))?;
    }
    Ok(root)
}
