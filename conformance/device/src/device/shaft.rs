//! Errors of the application: excessive speed, a wrong position, a hot sensor.

use super::condition::Condition;
use super::context::Context;
use super::encoder::TEMPERATURE;
use super::objects::Objects;
use super::service::{Event, Service};
use crate::Fault;
use canvass_traces::{Duration, Timestamp};

/// Interval for comparing the speed of a turning shaft with its limit.
const WATCH: Duration = Duration::from_millis(100);

/// Monitors the shaft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shaft {
    /// Time of the next comparison of the speed.
    due: Timestamp,
}

impl Shaft {
    /// A monitor that is off.
    pub const fn new() -> Self {
        Self { due: Timestamp::MAX }
    }

    /// Starts monitoring: the speed of a turning shaft can cross its limit without any write.
    pub fn watch(&mut self, now: Timestamp, context: &Context) {
        let warns = context.objects.model.sheet().encoder.is_some_and(|encoder| encoder.speed_warning_rpm.is_some());
        let watched = warns && context.objects.is_moving() && context.phase.is_running();
        self.due = if watched { now + WATCH } else { Timestamp::MAX };
    }
}

impl Service for Shaft {
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
    let Objects { parameters, encoder, .. } = &context.objects;
    let shaft = encoder.as_ref().map(|it| (it.is_overspeed(now, parameters), it.has_position_error()));
    if let Some((low, high)) = encoder.as_ref().and_then(|it| it.temperature_limits(parameters)) {
        let outside = !(low..=high).contains(&TEMPERATURE) && !context.has(Fault::WarningWithoutEmcy);
        context.report(Condition::Temperature { now: TEMPERATURE, low, high }, outside);
    }
    if let Some((too_fast, wrong_position)) = shaft {
        context.report(Condition::Overspeed, too_fast);
        context.report(Condition::Position, wrong_position);
    }
}
