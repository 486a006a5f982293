//! The interface to device profiles: the behaviour that the application of a device adds to the services that every
//! device has.
//!
//! A profile registers itself; the services ask the application of their device and name no profile.

use super::condition::Condition;
use super::context::Context;
use super::errors::Errors;
use super::motion::Motion;
use super::parameters::Parameters;
use super::service::{Event, Service};
use crate::Firmware;
use crate::models::Model;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::emcy::EmcyCode;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_traces::{Duration, Timestamp};
use std::fmt;
use std::sync::LazyLock;

/// A device profile whose devices can be simulated.
pub trait Profile: Sync {
    /// The number of the profile, as in the low word of 1000h.
    fn number(&self) -> u16;

    /// The application of a device of this model; `None` if the model has another profile.
    fn application(&self, model: &Model, motion: &Motion, firmware: &Firmware) -> Option<Box<dyn Application>>;

    /// Changes the values of the object dictionary according to the faults of the firmware.
    fn plant(&self, _: &mut Parameters, _: &Firmware) {}
}

/// A registered profile.
pub struct Registered(pub &'static dyn Profile);

inventory::collect!(Registered);

/// All profiles by number: the order does not depend on the linker.
static PROFILES: LazyLock<Vec<&'static dyn Profile>> = LazyLock::new(|| {
    let mut profiles: Vec<_> = inventory::iter::<Registered>.into_iter().map(|registered| registered.0).collect();
    profiles.sort_by_key(|profile| profile.number());
    profiles
});

/// The behaviour of a device in the objects of its profile. It does no I/O and reads no clock.
pub trait Application: fmt::Debug + Send {
    /// A copy of the application in the same state.
    fn boxed_clone(&self) -> Box<dyn Application>;

    /// The live value of an object from 2000h on; `None` for an object that holds the value last written.
    fn value(&self, now: Timestamp, at: Multiplexer, device: &Surroundings<'_>) -> Option<u64>;

    /// The value of an object in a PDO; `None` if it is the same as [`Application::value`]. `again` is set if the
    /// object occurs in the PDO a second time.
    fn process_value(&self, _: Timestamp, _: Multiplexer, _again: bool, _: &Surroundings<'_>) -> Option<u64> {
        None
    }

    /// Checks a written value by rules in addition to the limits in the device description.
    ///
    /// # Errors
    /// The abort code for a value that is inconsistent with others.
    fn check(&self, _: Multiplexer, _value: u64, _: &Surroundings<'_>) -> Result<(), AbortCode> {
        Ok(())
    }

    /// Whether a faulty firmware accepts a value beyond a limit that another object sets.
    fn overlooks_limits(&self, _: Multiplexer) -> bool {
        false
    }

    /// Handles the effects of a write other than the new value of the object.
    fn on_written(&mut self, _: Timestamp, _: Multiplexer, _value: u64, _: &Surroundings<'_>) {}

    /// Whether writing the object makes the firmware hang.
    fn wedges(&self, _: Multiplexer, _value: u64) -> bool {
        false
    }

    /// The objects that a write of this value resets to their defaults; stored values of these objects are erased too.
    fn resets(&self, _: Multiplexer, _value: u64) -> &'static [u16] {
        &[]
    }

    /// Whether a faulty firmware does not copy the value of the object to the objects linked with it. A write passes
    /// the written value as `_value`; the loading or reading of parameters passes `None`.
    fn breaks_link(&self, _: Multiplexer, _value: Option<u64>) -> bool {
        false
    }

    /// The object that holds the period of the first TPDO in milliseconds, if the profile has one.
    fn cyclic_timer(&self) -> Option<u16> {
        None
    }

    /// Whether a write of the object changes the configuration of TPDOs.
    fn changes_tpdos(&self, _: Multiplexer) -> bool {
        false
    }

    /// Sets the motion of the measured quantity from now on.
    fn set_motion(&mut self, _: Motion) {}

    /// Whether measured values change by themselves.
    fn is_moving(&self) -> bool {
        false
    }

    /// The value that the device stores in addition to the parameters.
    fn retained(&self) -> i64 {
        0
    }

    /// Restores the stored value; 0 if none was stored.
    fn restore(&mut self, _retained: i64) {}

    /// Whether the device enters operational by itself.
    fn starts_in_operational(&self, _: &Surroundings<'_>) -> bool {
        false
    }

    /// Interval of the checks for errors that come and go without a write; `None` if there are no such errors.
    fn watch(&self) -> Option<Duration> {
        None
    }

    /// The errors that the application can have, and whether each is present.
    fn errors(&self, _: Timestamp, _: &Surroundings<'_>) -> ApplicationErrors {
        ApplicationErrors::default()
    }
}

impl Clone for Box<dyn Application> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// The parts of the device that an application may use.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The values of the object dictionary.
    pub parameters: &'a Parameters,
    pub(super) errors: &'a Errors,
}

impl Surroundings<'_> {
    /// Whether a parameter to be stored was outside its limits.
    pub(crate) fn has_refused_parameter(&self) -> bool {
        self.errors.is_present(Condition::Parameter)
    }
}

/// An error of the application.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ApplicationError {
    /// The identity of the error; errors with equal numbers are the same error, whatever their other fields.
    pub number: u16,
    /// The error code of the EMCY message.
    pub code: EmcyCode,
    /// Bits of the error register besides those that CiA 301 couples to the code.
    pub register: u8,
    /// Bytes 3 to 7 of the EMCY message.
    pub manufacturer: [u8; 5],
    /// The sub-index of 1029h that sets the device's reaction.
    pub behaviour: Option<u8>,
}

/// Errors of an application, each with whether it is present. An array avoids an allocation at every change.
pub type ApplicationErrors = [Option<(ApplicationError, bool)>; 4];

/// The application of a device of this model; `None` if no profile has one for it.
pub(super) fn of(model: &Model, motion: &Motion, firmware: &Firmware) -> Option<Box<dyn Application>> {
    PROFILES.iter().find_map(|profile| profile.application(model, motion, firmware))
}

/// Changes the object dictionary according to the firmware's faults in the objects of profiles.
pub(super) fn plant(parameters: &mut Parameters, firmware: &Firmware) {
    PROFILES.iter().for_each(|profile| profile.plant(parameters, firmware));
}

/// Monitors the errors of the application and reports their changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorWatch {
    /// Time of the next check.
    due: Timestamp,
}

impl ErrorWatch {
    /// The state without monitoring.
    pub const fn new() -> Self {
        Self { due: Timestamp::MAX }
    }

    /// Starts monitoring: the measured quantity can cross a limit without any write.
    pub fn watch(&mut self, now: Timestamp, context: &Context) {
        let interval = context.objects.application.as_ref().and_then(|application| application.watch());
        let watched = interval.filter(|_| context.phase.is_running());
        self.due = watched.map_or(Timestamp::MAX, |interval| now + interval);
    }
}

impl Service for ErrorWatch {
    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Initialise => self.due = Timestamp::MAX,
            Event::Started => self.watch(now, context),
            Event::Changed => find_errors(now, context),
            _ => {}
        }
    }

    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        if now >= self.due {
            find_errors(now, context);
            self.watch(now, context);
        }
    }

    fn timeout(&self, _: &Context) -> Timestamp {
        self.due
    }
}

fn find_errors(now: Timestamp, context: &mut Context) {
    let objects = &context.objects;
    let Some(application) = &objects.application else { return };
    let errors = application.errors(now, &objects.surroundings());
    for (error, present) in errors.into_iter().flatten() {
        context.report(Condition::Application(error), present);
    }
}
