//! The primitives of a device: the layouts of all wire types, and the recognition of a device's frames.

use canvass_analyzer::Service;
use canvass_analyzer::wire::emcy::Emcy;
use canvass_analyzer::wire::error_control::{ErrorControl, GUARDING};
use canvass_analyzer::wire::layer_setting::{Protocol, SLAVE_CAN_ID};
use canvass_analyzer::wire::sdo::{BlockSegment, REQUEST_BASE, RESPONSE_BASE, Request, Response};
use canvass_analyzer::wire::sync::Sync;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_analyzer::wire::{Fields, Layout, Wire, emcy, error_control, lmt, lss, pdo, sync, time};
use canvass_traces::Frame;

/// A service primitive that a device sends.
#[derive(Clone, Copy, Debug)]
pub struct Primitive {
    /// The service.
    pub service: Service,
    /// The layout of the primitive's fields.
    pub layout: &'static Layout,
}

impl Primitive {
    /// `sdo/initiate-upload`.
    pub fn id(&self) -> String {
        let service = match self.service {
            // Boot-up, heartbeats and guarding have the same form.
            Service::Heartbeat => "error-control",
            other => other.name(),
        };
        format!("{service}/{}", hyphened(self.layout.name))
    }

    /// All primitives, except those that no right device sends, such as a response that the standard does not define.
    pub fn all() -> Vec<Self> {
        let of = |service, layouts: &[&'static Layout]| {
            let known = layouts.iter().filter(|layout| layout.name != "unknown");
            known.map(|layout| Self { service, layout }).collect::<Vec<_>>()
        };
        [
            of(Service::Sdo, Response::LAYOUTS),
            of(Service::Sdo, BlockSegment::LAYOUTS),
            of(Service::Heartbeat, ErrorControl::LAYOUTS),
            of(Service::Emcy, Emcy::LAYOUTS),
            of(Service::Pdo, &[&pdo::PDO]),
            of(Service::Sync, Sync::LAYOUTS),
            of(Service::Time, TimeOfDay::LAYOUTS),
            of(Service::Lss, lss::Response::LAYOUTS),
            of(Service::Lmt, lmt::Response::LAYOUTS),
        ]
        .concat()
    }

    /// Whether this is the primitive with this service and layout.
    pub fn is(&self, service: Service, layout: &Layout) -> bool {
        self.service == service && self.layout.name == layout.name
    }
}

/// A name in the form of a part of an id.
pub(crate) fn hyphened(name: &str) -> String {
    name.to_lowercase().replace(' ', "-")
}

/// The state of the bus that is needed to recognise the frames of a device.
#[derive(Clone, Debug)]
pub struct Recognition {
    protocol: Protocol,
    /// Whether segments of a block upload follow, which have no command specifier.
    is_block: bool,
    /// Whether a remote frame has asked for the state.
    is_guarded: bool,
}

impl Recognition {
    pub const fn new(protocol: Protocol) -> Self {
        Self { protocol, is_block: false, is_guarded: false }
    }

    /// Takes a frame to the device with this node-ID.
    pub fn heard(&mut self, frame: &Frame, node: u16) {
        let Some(id) = frame.id().as_standard() else { return };
        if frame.is_remote() {
            self.is_guarded |= id == error_control::CAN_ID_BASE + node;
        } else if id == REQUEST_BASE + node {
            let request = Request::read(frame.data());
            self.is_block = matches!(request, Ok(Request::StartBlockUpload | Request::ConfirmBlockUpload { .. }));
        }
    }

    /// The service and layout of a frame from the device with this node-ID.
    pub fn sent(&mut self, frame: &Frame, node: u16) -> Option<(Service, &'static Layout)> {
        let id = frame.id().as_standard().filter(|_| !frame.is_remote())?;
        let layout_of = |service, layout| Some((service, layout));
        match id {
            _ if id == RESPONSE_BASE + node => layout_of(Service::Sdo, self.of_server(frame.data())?),
            _ if id == error_control::CAN_ID_BASE + node => {
                let message = ErrorControl::read(frame.data()).ok()?;
                let is_guarding = std::mem::take(&mut self.is_guarded) && !message.is_boot_up();
                layout_of(Service::Heartbeat, if is_guarding { &GUARDING } else { message.layout() })
            }
            _ if id == emcy::CAN_ID_BASE + node => layout_of(Service::Emcy, Emcy::read(frame.data()).ok()?.layout()),
            sync::CAN_ID => layout_of(Service::Sync, Sync::read(frame.data()).ok()?.layout()),
            time::CAN_ID => layout_of(Service::Time, TimeOfDay::read(frame.data()).ok()?.layout()),
            SLAVE_CAN_ID => match self.protocol {
                Protocol::Lss => layout_of(Service::Lss, lss::Response::read(frame.data()).ok()?.layout()),
                Protocol::Lmt => layout_of(Service::Lmt, lmt::Response::read(frame.data()).ok()?.layout()),
            },
            // The PDOs of the predefined connection set; an EMCY may have been moved outside of it.
            0x180..0x580 if !frame.is_empty() => layout_of(Service::Pdo, &pdo::PDO),
            _ => None,
        }
    }

    fn of_server(&self, data: &[u8]) -> Option<&'static Layout> {
        let response = Response::read(data).ok()?;
        // The last block may have been confirmed, after which the end of the transfer follows.
        let is_end = matches!(response, Response::EndBlockUpload { .. } | Response::Abort(_));
        if self.is_block && !is_end {
            return Some(BlockSegment::read(data).ok()?.layout());
        }
        Some(response.layout())
    }
}
