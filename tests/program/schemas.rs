//! The outputs of the commands follow the JSON Schemas in `docs/schemas`.

use crate::running::run;
use jsonschema::Validator;
use serde_json::Value;
use std::path::Path;

/// The validator of the contract that a document names.
fn validator(contract: &str) -> Validator {
    let name = contract.trim_start_matches("canvass/").replace('/', "-");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/schemas/{name}.json"));
    let schema = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    jsonschema::validator_for(&serde_json::from_str(&schema).unwrap()).unwrap()
}

/// Validates each document against the schema that the first document names, and returns the documents.
fn holds(command: &[&str]) -> Vec<Value> {
    let ended = run(command);
    let documents: Result<Vec<Value>, _> = serde_json::Deserializer::from_str(&ended.stdout).into_iter().collect();
    let documents = documents.unwrap_or_else(|error| panic!("{command:?}: {error}: {}", ended.stderr));
    let first = documents.first().unwrap_or_else(|| panic!("{command:?} prints nothing: {}", ended.stderr));
    let validator = validator(first["schema"].as_str().unwrap());
    for document in &documents {
        let wrong: Vec<String> =
            validator.iter_errors(document).map(|error| format!("{}: {error}", error.instance_path())).collect();
        assert!(wrong.is_empty(), "{command:?}: {wrong:?}");
    }
    documents
}

#[test]
fn runs_on_devices_are_as_their_schemas_say() {
    let models = run(&["list", "models", "--format", "json"]).stdout;
    for model in serde_json::from_str::<Vec<Value>>(&models).unwrap() {
        let bus = format!("sim:{}", model["id"].as_str().unwrap());
        // One model has no node-ID as delivered.
        let node = model["node"].as_u64().unwrap_or(5).to_string();
        holds(&["test", &bus, "--node", &node, "--select", "301", "--format", "json"]);
        holds(&["fuzz", &bus, "--node", &node, "--runs", "5", "--seed", "1", "--format", "json"]);
    }
    let broken = "sim:reference-301+sdo-toggle-unchecked";
    holds(&["test", broken, "--select", "301/sdo", "--repeat", "2", "--format", "json"]);
    let fuzzed = holds(&["fuzz", broken, "--runs", "300", "--seed", "1", "--target", "sdo", "--format", "json"]);
    assert!(!fuzzed[0]["violations"].as_array().unwrap().is_empty());
    holds(&["selftest", "--select", "301/nmt/back-to-back", "--format", "json"]);
    holds(&["selftest", "--alone", "--count", "1", "--select", "301/nmt/back-to-back", "--format", "json"]);
    let shuffled = holds(&["test", broken, "--select", "301/sdo/abort", "--shuffle", "3", "--format", "json"]);
    assert_eq!(shuffled[0]["shuffle"], 3);
}

#[test]
fn results_of_results_are_as_their_schemas_say() {
    let folder = tempfile::tempdir().unwrap();
    let result = |name: &str, bus: &str| {
        let path = folder.path().join(name).display().to_string();
        let report = format!("json={path}");
        run(&["test", bus, "--select", "301/sdo", "--report", &report]);
        path
    };
    let old = result("old.json", "sim:reference-301");
    let new = result("new.json", "sim:reference-301+sdo-toggle-unchecked");
    let compared = holds(&["compare", &old, &new, "--format", "json"]);
    assert!(!compared[0]["changes"].as_array().unwrap().is_empty());
    holds(&["history", &old, &new, "--format", "json"]);
}

#[test]
fn captures_and_descriptions_are_as_their_schemas_say() {
    let capture = "docs/examples/commissioning.log";
    let device = "63=kuebler-sendix-58x8";
    holds(&["decode", capture, "--device", device, "--format", "json"]);
    holds(&["diagnose", capture, "--device", device, "--format", "json"]);
    holds(&["decode", capture, "--node", "127", "--quality", "json", "--quality-out", "-"]);
    holds(&["eds", "check", "analyzer/tests/eds/list-count.eds", "--format", "json"]);
}

/// The validators refuse wrong documents; otherwise the tests would prove nothing.
#[test]
fn what_lacks_a_member_or_has_another_type_is_refused() {
    let result = &holds(&["test", "sim:reference-301", "--select", "301/nmt/back-to-back", "--format", "json"])[0];
    let validator = validator("canvass/test/1");
    let refused = |change: fn(&mut Value)| {
        let mut changed = result.clone();
        change(&mut changed);
        !validator.is_valid(&changed)
    };
    assert!(refused(|result| result["cases"][0]["verdict"] = "good".into()));
    assert!(refused(|result| result["seed"] = "0".into()));
    assert!(refused(|result| result["schema"] = "canvass/test/2".into()));
    assert!(refused(|result| drop(result.as_object_mut().unwrap().remove("summary"))));
}
