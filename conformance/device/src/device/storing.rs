//! Storing: the commands of 1010h and 1011h, objects that are stored when they are written, and 1020h. Every other
//! change of the configuration erases the date in 1020h.

use super::context::Context;
use super::lss_slave::UNCONFIGURED;
use super::service::{Event, Service};
use super::store::{Groups, StoreCommand, StoredNetwork};
use crate::{Fault, Liberty};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_traces::Timestamp;

/// The service that stores parameters; the stored values are in the [`Context`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Storing;

impl Service for Storing {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        let Event::Written(at, value) = event else { return };
        if let Some(command) = StoreCommand::of(at, &context.objects.model.sheet().storage) {
            begin(now, command, context);
        }
        let goes_on = context.has(Fault::LaterValuesStored) && context.store.holds_something();
        if stores_by_itself(context) && !context.has(Fault::StoreWithoutEffect) || goes_on {
            let node = context.node_or_placeholder();
            context.store.save_at_once(at, &context.objects.parameters, node);
        }
        persist_at_once(at, value, context);
        forget_verification(at, context);
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if let Some(node) = context.node.filter(|_| now >= context.store.timeout()) {
            let retained = context.objects.application.as_ref().map(|application| application.retained());
            context.store.finish(now, &context.objects.parameters, retained, node);
        }
    }

    fn timeout(&self, context: &Context) -> Timestamp {
        context.store.timeout()
    }
}

/// Whether the firmware stores parameters as soon as they are written.
const fn stores_by_itself(context: &Context) -> bool {
    let by_itself = context.takes(Liberty::StoresByItself) || context.takes(Liberty::StoresBothWays);
    by_itself && !context.takes(Liberty::NoStore)
}

fn begin(now: Timestamp, command: StoreCommand, context: &mut Context) {
    let node = context.node_or_placeholder();
    if matches!(command, StoreCommand::Restore(_)) && context.has(Fault::RestoreAtOnce) {
        context.objects.parameters.restore(node);
    }
    let sheet = context.objects.model.sheet();
    let done = now + sheet.timing.store();
    if command.is_save() {
        if sheet.quirks.silent_while_storing {
            context.silent_until = done;
        }
        context.objects.take_waiting();
    }
    // Without LSS the device could never get a node-ID again, so it keeps its node-ID.
    let restores_node_id = context.takes(Liberty::NodeIdRestored) && !context.takes(Liberty::NoLss);
    if command == StoreCommand::Restore(Groups::PARAMETERS) && restores_node_id {
        let network = context.store.network();
        context.store.save_network(StoredNetwork { node_id: Some(UNCONFIGURED), ..network });
    }
    let breaks_start = if command.is_save() { Fault::StoreBreaksStart } else { Fault::RestoreBreaksStart };
    context.breaks_next_start |= context.has(breaks_start);
    context.store.begin(done, command, &context.objects.firmware);
}

/// Stores an object that the sheet lists as stored when written; resets the objects that depend on this write.
fn persist_at_once(at: Multiplexer, value: u64, context: &mut Context) {
    let node = context.node_or_placeholder();
    let reset = context.objects.resets(at, value);
    if !reset.is_empty() {
        context.objects.reset(reset, node);
        for &index in reset {
            context.store.forget_number(Multiplexer::new(index, 0), &context.objects.parameters);
        }
    }
    if context.objects.model.sheet().storage.persist_at_once.contains(&at) {
        context.store.save_number(at, value, &context.objects.parameters);
        if let Some(application) = &context.objects.application {
            context.store.save_retained(application.retained());
        }
    }
}

/// Erases the date and time in 1020h after a change of the configuration.
fn forget_verification(at: Multiplexer, context: &mut Context) {
    let is_command = StoreCommand::of(at, &context.objects.model.sheet().storage).is_some();
    let kept = context.has(Fault::ConfigurationDateKept);
    if !matches!(at.index.0, object::PREDEFINED_ERROR_FIELD | object::VERIFY_CONFIGURATION) && !is_command && !kept {
        context.objects.parameters.set_number(object::VERIFY_CONFIGURATION, 1, 0);
        context.objects.parameters.set_number(object::VERIFY_CONFIGURATION, 2, 0);
    }
}
