//! `canopen-rs` 0.6.1.

use super::{Expected, Outcome, Peer, counts, expect, judge, trace};
use canvass_stacks::canopen_rs::{CanopenRs, EDS, NODE};

const EXPECTED: &Expected = &[];

fn outcome() -> Outcome {
    judge(Peer::new(CanopenRs::new(), EDS, NODE), true)
}

#[test]
fn fails_what_is_documented() {
    let outcome = outcome();
    expect(&outcome, EXPECTED);
    assert_eq!(counts(&outcome), [0; 7]);
    assert_eq!(outcome.notices, Vec::<String>::new());
    assert_eq!(outcome.memorial.deaths(), []);
}

#[test]
fn runs_the_same_each_time() {
    assert_eq!(trace(&outcome()), trace(&outcome()));
}
