//! Whether the device can be operational at all. A case that needs it there and fails may have found no more than that it can't.

use super::Bench;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::nmt::Command;

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);

impl Bench<'_> {
    /// Why the device is not operational after a start and the command to go there, which the last case has sent as well; `None`: it
    /// is, or nobody can tell. Comes after the case: what is sent here is no part of it.
    pub(crate) fn kept_out_of_operational(&mut self) -> Option<Reason> {
        if !self.started {
            return None;
        }
        self.watch.forget();
        let kept = self.unjudged(Self::keeps_out);
        self.restore();
        // What ends the look early has ended the case, or will end the next one.
        kept.ok().flatten()
    }

    fn keeps_out(&mut self) -> Result<Option<Reason>, Stop> {
        self.prepare()?;
        self.show_state()?;
        self.command(Command::START)?;
        self.listen(self.timing().reaction)?;
        let found = self.state()?;
        let is_kept = found.is_some_and(|state| state != State::OPERATIONAL);
        Ok(is_kept.then(|| self.not_reached(State::OPERATIONAL, found)))
    }

    /// The device is not in the state that a case needs. An error that it reports may be why.
    pub(super) fn not_reached(&mut self, expected: State, found: Option<State>) -> Reason {
        let mut actual = found.map_or_else(|| "no sign of a state".to_owned(), |state| state.to_string());
        if expected == State::OPERATIONAL
            && let Some(error) = self.reported_error()
        {
            actual = format!("{actual}; it reports an error, which may be why: {error}");
        }
        Reason::new(format!("the device can be brought into {expected}"), expected.to_string(), actual)
    }

    /// The last error that the device has reported, or that its error register shows.
    fn reported_error(&mut self) -> Option<String> {
        if let Some((_, emcy)) = self.watch.emergencies().last() {
            return Some(format!("EMCY {emcy}"));
        }
        let register = self.unjudged(|bench| bench.read_number(ERROR_REGISTER)).ok()?;
        (register != 0).then(|| format!("{ERROR_REGISTER} is {register:02X}h"))
    }
}
