//! A master that sets the node-ID of a slave, by LSS or LMT.

use super::Network;
use crate::plan::{MS, Planned};
use crate::sort::Sort;
use canvass_analyzer::wire::layer_setting::{
    ConfigureCommand, Dialect, MASTER_CAN_ID, Request, Response, SLAVE_CAN_ID,
};
use canvass_analyzer::wire::lmt::{self, Lmt, Seven};
use canvass_analyzer::wire::lss::{self, Lss};
use canvass_analyzer::wire::{Fields, Wire};

/// The names of the groups of sorts: requests, responses.
type Groups = (&'static str, &'static str);

impl Network {
    /// Sets the node-ID of the last node, and returns when that is done.
    pub(super) fn set_layer(&mut self, at: u64) -> u64 {
        if self.draw.chance(60) { self.by_lss(at) } else { self.by_lmt(at) }
    }

    /// A request and its response, if it has one.
    fn exchange<D: Dialect>(&mut self, groups: Groups, at: &mut u64, ask: Request<D>, answer: Option<Response<D>>) {
        *at += self.draw.between(5, 20) * MS;
        let sort = Sort::layer_setting(groups.0, ask.layout());
        let cause = self.plan.add(Planned::new(*at, ask.to_frame(MASTER_CAN_ID), sort, 0));
        if let Some(response) = answer {
            let (sort, frame) = (Sort::layer_setting(groups.1, response.layout()), response.to_frame(SLAVE_CAN_ID));
            *at += self.draw.between(1, 5) * MS;
            self.plan.add(Planned::new(*at, frame, sort, 0).because_of(cause));
        }
    }

    /// The commands that both protocols have.
    fn configure<D: Dialect>(&mut self, groups: Groups, at: &mut u64) {
        let done = |command| Some(Response::Configured { command, error: 0, specific: 0 });
        let node_id = self.nodes.last().map_or(1, |node| node.id);
        self.exchange::<D>(groups, at, Request::ConfigureNodeId { node_id }, done(ConfigureCommand::NodeId));
        let timing = Request::ConfigureBitTiming { table: 0, index: 2 };
        self.exchange::<D>(groups, at, timing, done(ConfigureCommand::BitTiming));
        self.exchange::<D>(groups, at, Request::StoreConfiguration, done(ConfigureCommand::Store));
        self.exchange::<D>(groups, at, Request::ActivateBitTiming { delay: 100 }, None);
        *at += 250 * MS;
        self.exchange::<D>(groups, at, Request::SwitchGlobal { mode: 0 }, None);
    }

    fn by_lss(&mut self, mut at: u64) -> u64 {
        let groups = ("lss-request", "lss-response");
        let address = [0x123, 1, 0x0001_0002, self.draw.below(1 << 30) as u32];
        let serial = address[3];
        self.exchange::<Lss>(groups, &mut at, Request::IdentifyNonConfigured, Some(Response::NonConfigured));
        let begin = Request::Fastscan { id: 0, bit_check: 128, sub: 0, next: 0 };
        self.exchange::<Lss>(groups, &mut at, begin, Some(Response::Identified));
        for bound in lss::Bound::ALL {
            let (part, _) = Lss::limits(bound);
            let value = address[part as usize];
            let answer = (bound == lss::Bound::SerialHigh).then_some(Response::Identified);
            self.exchange::<Lss>(groups, &mut at, Request::IdentifyRemote { bound, value }, answer);
        }
        for part in lss::Part::ALL {
            let answer = (part == lss::Part::SerialNumber).then_some(Response::Switched);
            let value = address[part as usize];
            self.exchange::<Lss>(groups, &mut at, Request::SwitchSelective { part, value }, answer);
        }
        let number = Response::Part { part: lss::Part::SerialNumber, value: serial };
        self.exchange::<Lss>(groups, &mut at, Request::Inquire { part: lss::Part::SerialNumber }, Some(number));
        self.exchange::<Lss>(groups, &mut at, Request::InquireNodeId, Some(Response::NodeId(255)));
        self.configure::<Lss>(groups, &mut at);
        at
    }

    fn by_lmt(&mut self, mut at: u64) -> u64 {
        let groups = ("lmt-request", "lmt-response");
        let serial = [0x20, 0x11, 0x22, 0x33, 0x44, 0x55, self.draw.below(90) as u8 / 10 * 16];
        let name = |text| Seven::name(text).unwrap_or(Seven([0; 7]));
        let address = [name("Matrix"), name("Node"), Seven(serial)];
        for bound in lmt::Bound::ALL {
            let (part, _) = Lmt::limits(bound);
            let answer = (bound == lmt::Bound::SerialHigh).then_some(Response::Identified);
            let value = address[part as usize];
            self.exchange::<Lmt>(groups, &mut at, Request::IdentifyRemote { bound, value }, answer);
        }
        for part in lmt::Part::ALL {
            let value = address[part as usize];
            self.exchange::<Lmt>(groups, &mut at, Request::SwitchSelective { part, value }, None);
        }
        self.exchange::<Lmt>(groups, &mut at, Request::SwitchGlobal { mode: 1 }, None);
        let number = Response::Part { part: lmt::Part::SerialNumber, value: Seven(serial) };
        self.exchange::<Lmt>(groups, &mut at, Request::Inquire { part: lmt::Part::SerialNumber }, Some(number));
        self.configure::<Lmt>(groups, &mut at);
        at
    }
}
