//! The coverage that the generators reach.

use canvass_analyzer::NodeId;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_fuzzer::coverage::{LssReach, SdoReach};
use canvass_fuzzer::detection::fuzz;
use canvass_fuzzer::{Knowledge, Target};
use canvass_suite::touch::Touch;

/// A minute of an optimised build runs a thousand times more exchanges than this test.
#[test]
fn nearly_all_pairs_of_state_and_command_are_reached() {
    let model = Model::by_id("reference-301").unwrap();
    let allow = Touch::ALL.into_iter().collect();
    let outcome = fuzz(model, Faults::NONE, Target::All, &allow, 3, &mut |done| done < 40_000).unwrap();
    let (reached, reachable) = outcome.coverage.sdo_share(SdoReach { blocks: true, long_values: true });
    assert!(reached * 100 >= reachable * 95, "SDO: {reached} of {reachable}");
    let knowledge = Knowledge::new(NodeId::MIN, Some(model.description()), Some(model.sheet()));
    let (reached, reachable) = outcome.coverage.lss_share(&LssReach::of(&knowledge.services, true, &allow));
    assert!(reached * 100 >= reachable * 95, "LSS: {reached} of {reachable}");
}
