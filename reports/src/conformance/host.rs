//! The timing of the tester's own machine in words.

use canvass_suite::runner::HostTiming;
use canvass_traces::Duration;

/// The timing in one or two sentences.
pub(super) fn sentence(host: &HostTiming) -> String {
    let mut text = format!(
        "This machine saw 99 % of the frames within {} of their time on the bus and all within {}; its own were on the bus \
         within {} and {}.",
        bound(host.receive_usually),
        bound(host.receive_always),
        bound(host.transmit_usually),
        bound(host.transmit_always)
    );
    if host.lost > 0 {
        text += &format!(" It lost {} frames.", host.lost);
    }
    let interrupted_for = Duration::from_millis(host.interrupted_for.nanos() / 1_000_000);
    match host.interruptions {
        0 => {}
        1 => text += &format!(" The bus was interrupted once, for {interrupted_for}."),
        times => text += &format!(" The bus was interrupted {times} times, for {interrupted_for} in all."),
    }
    if let Some(trouble) = host.stamps {
        text += &format!(" The adapter's time stamps {trouble}: times that they gave are not judged.");
    }
    text
}

/// An upper bound with two digits, rounded up.
fn bound(span: Duration) -> Duration {
    let mut step = 1;
    while span.0.div_ceil(step) >= 100 {
        step *= 10;
    }
    Duration(span.0.div_ceil(step) * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::StampTrouble;

    #[test]
    fn time_stamps_that_are_wrong_are_told() {
        let told = |stamps| sentence(&HostTiming { stamps, ..HostTiming::default() });
        assert!(!told(None).contains("stamps"));
        assert!(
            told(Some(StampTrouble::Still))
                .ends_with("The adapter's time stamps stand still: times that they gave are not judged.")
        );
    }

    #[test]
    fn bounds_stay_bounds() {
        let shown = |nanos| bound(Duration(nanos)).to_string();
        assert_eq!(
            [0, 99, 100, 4_095, 65_535, 131_071].map(shown),
            ["0 ns", "99 ns", "100 ns", "4.1 µs", "66 µs", "140 µs"]
        );
        assert_eq!(bound(Duration(995)), Duration(1_000));
    }
}
