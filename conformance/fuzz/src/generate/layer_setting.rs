//! The common parts of LSS and LMT dialogues.

use super::Script;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::layer_setting::{Dialect, MASTER_CAN_ID, Numbered, Request};

impl Script<'_> {
    /// Adds a message of the master.
    pub(super) fn tell<D: Dialect>(&mut self, request: Request<D>) {
        self.ask(request.to_frame(MASTER_CAN_ID));
    }

    /// Adds "switch global", now and then to a reserved mode.
    pub(super) fn switch<D: Dialect>(&mut self) {
        let mode = self.dice.one_of([0, 0, 1, 1, 1, 2, 255]);
        self.tell(Request::<D>::SwitchGlobal { mode });
    }

    /// Adds an inquiry in the current state, whatever it is.
    pub(super) fn inquire<D: Dialect>(&mut self) {
        if self.dice.flip() {
            self.switch::<D>();
        }
        self.inquire_part::<D>();
    }

    /// Adds an inquiry of one part of the address.
    pub(super) fn inquire_part<D: Dialect>(&mut self) {
        let part = D::Part::ALL[self.dice.below(D::Part::ALL.len())];
        self.tell(Request::<D>::Inquire { part });
    }

    /// Adds all bounds of "identify remote slave".
    pub(super) fn identify_within<D: Dialect>(&mut self, bounds: impl IntoIterator<Item = D::Value>) {
        for (&bound, value) in D::Bound::ALL.iter().zip(bounds) {
            self.tell(Request::<D>::IdentifyRemote { bound, value });
        }
    }

    /// Adds a message of these bytes, now and then cut short.
    pub(super) fn odd_layer_frame(&mut self, bytes: [u8; 8]) {
        let len = if self.dice.one_in(4) { self.dice.below(8) } else { 8 };
        self.ask(Self::data(MASTER_CAN_ID, &bytes[..len]));
    }
}
