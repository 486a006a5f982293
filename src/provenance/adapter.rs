//! The adapter between this computer and a bus, as far as the operating system tells.

use canvass_bus::network::Carrier;
use canvass_bus::pcan::Channel;
use canvass_device::address::BusAddress;
use std::path::{Path, PathBuf};

const PCAN: &str = "PCAN-Basic";

/// The adapter in a few words: `simulated`, `SocketCAN, driver peak_usb, PEAK-System PCAN-USB FD`.
pub fn of(address: &str) -> String {
    match address.parse() {
        Ok(BusAddress::Simulated(_)) => "simulated".to_owned(),
        Ok(BusAddress::SocketCan { interface }) => {
            let device = PathBuf::from(format!("/sys/class/net/{interface}/device"));
            let driver = std::fs::read_link(device.join("driver")).ok();
            let driver = driver.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
            let driver = driver.map_or_else(|| "virtual".to_owned(), |driver| format!("driver {driver}"));
            described("SocketCAN", Some(driver), &device)
        }
        Ok(BusAddress::SlCan { port, .. }) => match port.rsplit_once('/') {
            Some((_, name)) if port.starts_with("/dev/") => {
                described("SLCAN", None, Path::new(&format!("/sys/class/tty/{name}/device")))
            }
            _ => "SLCAN".to_owned(),
        },
        Ok(BusAddress::Python { interface, .. }) => format!("python-can, {interface}"),
        Ok(BusAddress::Network(address)) => match address.carrier {
            Carrier::Socketcand { .. } => "socketcand".to_owned(),
            Carrier::CannelloniTcp { .. } | Carrier::CannelloniUdp { .. } => "cannelloni".to_owned(),
            Carrier::Multicast { .. } => "python-can, udp_multicast".to_owned(),
        },
        Ok(BusAddress::Pcan(opening)) => pcan(opening.channel),
        Err(_) => "unknown".to_owned(),
    }
}

/// A PEAK adapter, with the versions of its driver and firmware: behaviour depends on them.
#[cfg(any(windows, target_os = "linux"))]
fn pcan(channel: Channel) -> String {
    let Ok(installed) = canvass_bus::pcan::installed() else { return PCAN.to_owned() };
    let adapter = installed.channels.into_iter().find(|present| present.channel == channel);
    let kind = installed.version.map_or_else(|| PCAN.to_owned(), |version| format!("{PCAN} {version}"));
    [Some(kind), adapter.and_then(|present| present.adapter)].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

#[cfg(not(any(windows, target_os = "linux")))]
fn pcan(_: Channel) -> String {
    PCAN.to_owned()
}

/// Adds the names that a USB device gives itself. They are in the folder of the interface in sysfs, or in a folder
/// above it.
fn described(kind: &str, driver: Option<String>, device: &Path) -> String {
    let device = std::fs::canonicalize(device).unwrap_or_default();
    let of_usb = device.ancestors().take(4).find_map(|folder| {
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).ok().map(|text| text.trim().to_owned());
        let product = read("product")?;
        let serial = read("serial").map(|serial| format!("serial {serial}"));
        let maker = read("manufacturer").map_or_else(|| product.clone(), |maker| format!("{maker} {product}"));
        Some([Some(maker), serial].into_iter().flatten().collect::<Vec<_>>().join(", "))
    });
    [Some(kind.to_owned()), driver, of_usb].into_iter().flatten().collect::<Vec<_>>().join(", ")
}
