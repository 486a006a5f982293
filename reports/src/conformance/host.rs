//! How well the tester's own machine kept up, in words.

use canvass_conformance::runner::HostTiming;

/// One or two sentences.
pub(super) fn sentence(host: &HostTiming) -> String {
    let mut text = format!(
        "This machine saw 99 % of the frames within {} of their time on the bus and all within {}; its own were on the bus \
         within {} and {}.",
        host.receive_usually, host.receive_always, host.transmit_usually, host.transmit_always
    );
    if host.lost > 0 {
        text += &format!(" It lost {} frames.", host.lost);
    }
    if host.interruptions > 0 {
        text += &format!(" The bus was interrupted {} times.", host.interruptions);
    }
    text
}
