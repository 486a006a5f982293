use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::wire::lss::{ConfigureCommand, Request, Response};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Lss],
    make: Some(|_| Box::new(NotStored { changed: None })),
};

static METADATA: Metadata = Metadata {
    id: "lss/not-stored",
    severity: Severity::Warning,
    title: "a node-ID or bit rate was changed and not stored",
    what: "An LSS slave has taken a new node-ID or bit rate, and is switched back to waiting, or the capture ends, \
           without a successful store.",
    why: "At the next power-on the device is back at its old node-ID and bit rate, often after the technician has left.",
    advice: "Send store configuration (17h) before switching back to waiting, unless the master sets the node-ID anew at \
             every start.",
    thresholds: &[],
};

struct NotStored {
    changed: Option<Seen>,
}

impl NotStored {
    fn tell(&mut self, sink: &mut Sink<'_>) {
        if let Some(changed) = self.changed.take() {
            let report = Report::at(changed.time()).evidence(changed.evidence());
            sink.report(report, || "configured and not stored".to_owned());
        }
    }
}

impl Rule for NotStored {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.message() {
            Message::LssRequest(Request::SwitchGlobal { mode: 0 }) => self.tell(sink),
            Message::LssResponse(Response::Configured { command, error: 0, .. }) => {
                self.changed = match command {
                    ConfigureCommand::Store => None,
                    _ => Some(context.seen()),
                };
            }
            _ => {}
        }
    }

    fn interrupted(&mut self) {
        self.changed = None;
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        self.tell(sink);
    }
}
