//! What a firmware does otherwise than the services of this device, by named hooks: each service asks at the place where
//! firmwares differ, and the honest answer is that of the standard.
//!
//! One file for each family of services. A hook whose answer is yes or no is a row of [`hooks`]; others are functions.
//! Faults that show in single frames are in `mischief` instead, those of the object dictionary in `overlay`.

mod broadcast;
mod checks;
mod emcy;
mod encoder;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod layer_setting;
mod liberties;
mod nmt;
mod pdo;
mod sdo;
mod store;

/// Defines hooks: `NAME with FAULT` is true for a firmware that has the fault, `NAME unless FAULT` for one that has not;
/// `or LIBERTY` does the same for a liberty; `NAME by LIBERTY` and `NAME but LIBERTY` are about a liberty alone.
macro_rules! hooks {
    ($($name:ident $how:ident $what:ident $(or $liberty:ident)?,)*) => {
        impl Firmware {
            $(pub(in crate::device) const fn $name(&self) -> bool { hooks!(@ self $how $what $($liberty)?) })*
        }
    };
    (@ $self:ident with $fault:ident) => { $self.has(Fault::$fault) };
    (@ $self:ident unless $fault:ident) => { !$self.has(Fault::$fault) };
    (@ $self:ident with $fault:ident $liberty:ident) => { $self.has(Fault::$fault) || $self.takes(Liberty::$liberty) };
    (@ $self:ident unless $fault:ident $liberty:ident) => { !$self.has(Fault::$fault) && !$self.takes(Liberty::$liberty) };
    (@ $self:ident by $liberty:ident) => { $self.takes(Liberty::$liberty) };
    (@ $self:ident but $liberty:ident) => { !$self.takes(Liberty::$liberty) };
}
use hooks;

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    /// Where faults may be named: the hooks, the filter of frames, and the overlay of the dictionary.
    const HERE: [&str; 4] = ["firmware", "mischief", "mischief.rs", "overlay.rs"];

    fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let name = entry.file_name().into_string().unwrap();
            match entry.file_type().unwrap().is_dir() {
                _ if HERE.contains(&name.as_str()) => {}
                true => sources(&entry.path(), found),
                false => found.push((name, fs::read_to_string(entry.path()).unwrap())),
            }
        }
    }

    #[test]
    fn services_name_no_faults() {
        let mut found = Vec::new();
        sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/device"), &mut found);
        assert!(found.len() > 30);
        for (name, text) in found {
            assert!(!text.contains("Fault::"), "{name} names a fault: give it a hook in device/firmware");
        }
    }
}
