//! The serial ports of this computer and what is plugged into them.

use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// A serial port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PortInfo {
    /// Its device file.
    pub path: PathBuf,
    /// Its name in /dev/serial/by-id, which stays the same whatever else is plugged in.
    pub by_id: Option<PathBuf>,
    /// Manufacturer and product, as a USB adapter says them, or what the driver is called.
    pub adapter: String,
    /// Serial number of a USB adapter.
    pub serial: Option<String>,
    /// How long an FTDI adapter holds bytes back at most, ms. `pneudrive-host` sets it to 1 where
    /// it may; `None` where the driver has no such setting.
    pub latency_timer_ms: Option<u32>,
}

/// The serial ports that have hardware, by name.
///
/// # Errors
/// The system does not list its terminals.
pub fn ports() -> std::io::Result<Vec<PortInfo>> {
    below("/sys/class/tty".as_ref(), "/dev".as_ref())
}

/// The same from other places: `class` in the manner of /sys/class/tty, `devices` of /dev.
fn below(class: &Path, devices: &Path) -> std::io::Result<Vec<PortInfo>> {
    let mut ports = Vec::new();
    for entry in fs::read_dir(class)? {
        let entry = entry?;
        let place = entry.path();
        // Consoles and pseudo-terminals have no device.
        let Ok(device) = fs::canonicalize(place.join("device")) else { continue };
        let driver = fs::canonicalize(device.join("driver")).ok();
        let Some(driver) = driver.and_then(|driver| Some(driver.file_name()?.to_string_lossy().into_owned()))
        else {
            continue;
        };
        // A PC's UARTs are there whether they exist or not: without a type, they do not.
        if read(&place.join("type")).is_some_and(|kind| kind == "0") {
            continue;
        }
        let path = devices.join(entry.file_name());
        let usb = device.ancestors().find(|above| above.join("idVendor").exists());
        let says = |name: &str| usb.and_then(|usb| read(&usb.join(name)));
        let adapter = match (says("manufacturer"), says("product")) {
            (Some(maker), Some(product)) => format!("{maker} {product}"),
            (None, Some(name)) | (Some(name), None) => name,
            (None, None) if usb.is_some() => format!("USB, driver {driver}"),
            (None, None) => format!("built-in, driver {driver}"),
        };
        ports.push(PortInfo {
            by_id: by_id(&devices.join("serial/by-id"), &path),
            adapter,
            serial: says("serial"),
            latency_timer_ms: read(&device.join("latency_timer")).and_then(|ms| ms.parse().ok()),
            path,
        });
    }
    ports.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(ports)
}

/// The link in `links` that leads to `port`.
fn by_id(links: &Path, port: &Path) -> Option<PathBuf> {
    let port = fs::canonicalize(port).ok()?;
    let links = fs::read_dir(links).ok()?.filter_map(Result::ok).map(|entry| entry.path());
    links.into_iter().find(|link| fs::canonicalize(link).is_ok_and(|target| target == port))
}

fn read(file: &Path) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let plain: String = text.trim().chars().filter(|c| !c.is_control()).collect();
    (!plain.is_empty()).then_some(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// As Linux 6.1 shows an FTDI cable, an Arduino (no latency timer), a board's UART, a UART that
    /// does not exist, and a console.
    #[test]
    fn adapters_are_listed_with_their_names_and_latency() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        let file = |path: &str, text: &str| {
            fs::create_dir_all(at(path).parent().unwrap()).unwrap();
            fs::write(at(path), text).unwrap();
        };
        let link = |from: &str, to: &str| {
            fs::create_dir_all(at(from).parent().unwrap()).unwrap();
            symlink(at(to), at(from)).unwrap();
        };
        for driver in ["ftdi_sio", "cdc_acm", "uart-pl011", "serial8250"] {
            fs::create_dir_all(at(&format!("drivers/{driver}"))).unwrap();
        }
        file("devices/usb1/1-1/idVendor", "0403\n");
        file("devices/usb1/1-1/manufacturer", "FTDI\n");
        file("devices/usb1/1-1/product", "USB-RS485 Cable\n");
        file("devices/usb1/1-1/serial", "FT1ABC\n");
        file("devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "16\n");
        link("devices/usb1/1-1/1-1:1.0/ttyUSB0/driver", "drivers/ftdi_sio");
        file("devices/usb1/1-2/idVendor", "2341\n");
        file("devices/usb1/1-2/1-2:1.0/x", "");
        link("devices/usb1/1-2/1-2:1.0/driver", "drivers/cdc_acm");
        file("devices/uart/x", "");
        link("devices/uart/driver", "drivers/uart-pl011");
        file("devices/none/x", "");
        link("devices/none/driver", "drivers/serial8250");
        link("class/ttyUSB0/device", "devices/usb1/1-1/1-1:1.0/ttyUSB0");
        link("class/ttyACM0/device", "devices/usb1/1-2/1-2:1.0");
        link("class/ttyAMA0/device", "devices/uart");
        file("class/ttyAMA0/type", "32\n");
        link("class/ttyS0/device", "devices/none");
        file("class/ttyS0/type", "0\n");
        file("class/tty1/x", "");
        file("dev/ttyUSB0", "");
        link("dev/serial/by-id/usb-FTDI_cable", "dev/ttyUSB0");

        let ports = below(&at("class"), &at("dev")).unwrap();
        let names: Vec<_> =
            ports.iter().map(|port| port.path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["ttyACM0", "ttyAMA0", "ttyUSB0"]);
        assert_eq!((ports[0].adapter.as_str(), ports[0].latency_timer_ms), ("USB, driver cdc_acm", None));
        assert_eq!(ports[1].adapter, "built-in, driver uart-pl011");
        assert_eq!(ports[2].adapter, "FTDI USB-RS485 Cable");
        assert_eq!((ports[2].serial.as_deref(), ports[2].latency_timer_ms), (Some("FT1ABC"), Some(16)));
        assert_eq!(ports[2].by_id, Some(at("dev/serial/by-id/usb-FTDI_cable")));
        assert!(below(&at("nowhere"), &at("dev")).is_err());
    }
}
