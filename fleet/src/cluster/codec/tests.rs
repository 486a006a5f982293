//! Encoding and decoding gives the same value, and hostile bytes are errors.

use super::*;
use crate::filter::{Condition, Test};
use datafusion_proto::physical_plan::DefaultPhysicalProtoConverter;
use proptest::prelude::*;

fn numbers() -> impl Strategy<Value = i128> {
    prop_oneof![any::<i64>().prop_map(i128::from), any::<u64>().prop_map(i128::from), any::<i128>()]
}

fn conditions() -> impl Strategy<Value = Condition> {
    let texts = || prop::collection::vec(".*", 0..4);
    prop_oneof![
        (prop::option::of(numbers()), prop::option::of(numbers()))
            .prop_map(|(low, high)| Condition::Between(low, high)),
        prop::collection::vec(numbers(), 0..4).prop_map(Condition::OneOf),
        prop::collection::vec(numbers(), 0..4).prop_map(Condition::NoneOf),
        texts().prop_map(Condition::OneOfTexts),
        texts().prop_map(Condition::NoneOfTexts),
        Just(Condition::Null),
        Just(Condition::NotNull),
    ]
}

fn files() -> impl Strategy<Value = Vec<CaptureFile>> {
    let file = (".*", any::<u64>(), any::<i64>()).prop_map(|(name, size, modified)| CaptureFile {
        path: (size % 2 == 0).then(|| format!("/{name}")),
        name: if size % 2 == 0 { format!("bench:/{name}") } else { format!("/{name}") },
        size,
        modified,
    });
    prop::collection::vec(file, 0..5)
}

fn devices() -> impl Strategy<Value = Devices> {
    let rules = [vec![], vec!["product:0x2011=kuebler-sendix-58x8"], vec!["1..3,63=kuebler-sendix-58x8"]];
    let read = |rules: Vec<&str>| Devices::new(rules.iter().map(|rule| rule.parse().unwrap()).collect());
    prop::sample::select(rules.to_vec()).prop_map(read)
}

fn scans() -> impl Strategy<Value = ScanSpec> {
    let columns = prop::collection::vec(0_usize..4, 0..6);
    let tests = (".*", conditions()).prop_map(|(column, condition)| Test { column, condition });
    let (tables, tests) = (prop::sample::select(Table::ALL.to_vec()), prop::collection::vec(tests, 0..3));
    (tables, columns, tests, prop::option::of(any::<usize>()), devices()).prop_map(
        |(table, columns, tests, fetch, devices)| ScanSpec { table, columns, tests, fetch, skips: true, devices },
    )
}

fn physical(plan: Arc<dyn ExecutionPlan>) -> Result<Arc<dyn ExecutionPlan>> {
    let (codec, converter, mut bytes) = (PhysicalCodec::default(), DefaultPhysicalProtoConverter {}, Vec::new());
    let inputs: Vec<_> = plan.children().into_iter().cloned().collect();
    codec.try_encode(plan, &mut bytes, &converter)?;
    codec.try_decode(&bytes, &inputs, &TaskContext::default(), &converter)
}

/// A plan without files.
fn no_files() -> Arc<dyn ExecutionPlan> {
    crate::scan::files::plan(&[]).unwrap()
}

proptest! {
    #[test]
    fn scans_are_the_same(spec in scans()) {
        let read = physical(Arc::new(CaptureScan::new(spec.clone(), no_files()).unwrap())).unwrap();
        prop_assert_eq!(read.downcast_ref::<CaptureScan>().unwrap().spec(), &spec);
    }

    #[test]
    fn ingests_are_the_same(lake in ".*", partitions in prop::collection::vec(files(), 0..4), devices in devices()) {
        let spec = IngestSpec { lake, devices };
        let read = physical(Arc::new(IngestScan::new(spec.clone(), no_files()))).unwrap();
        prop_assert_eq!(read.downcast_ref::<IngestScan>().unwrap().spec(), &spec);
        let sent = SentTable::Ingest { spec, partitions };
        let table = sent.clone().table(&TaskContext::default()).unwrap();
        prop_assert_eq!(SentTable::of(table.as_ref()).unwrap(), Some(sent));
    }

    #[test]
    fn tables_are_the_same(table in prop::sample::select(Table::ALL.to_vec()), files in files(), devices in devices(),
        push_down in any::<bool>()) {
        let sent = SentTable::Captures { table, files: Files::Known(files), devices, push_down };
        let provider = sent.table(&TaskContext::default()).unwrap();
        let (codec, name, mut bytes) = (LogicalCodec::default(), TableReference::bare("t"), Vec::new());
        codec.try_encode_table_provider(&name, Arc::clone(&provider), &mut bytes).unwrap();
        let read = codec.try_decode_table_provider(&bytes, &name, provider.schema(), &TaskContext::default()).unwrap();
        let (before, after) = (SentTable::of(provider.as_ref()).unwrap(), SentTable::of(read.as_ref()).unwrap());
        prop_assert!(before.is_some());
        prop_assert_eq!(before, after);
    }

    #[test]
    fn hostile_bytes_are_errors(spec in scans(), at in any::<prop::sample::Index>(), byte in any::<u8>(),
        noise in prop::collection::vec(any::<u8>(), 0..64)) {
        let mut bytes = Vec::new();
        write(SentPlan::Scan(spec), &mut bytes).unwrap();
        let short = &bytes[..MARK.len() + at.index(bytes.len() - MARK.len())];
        prop_assert!(read::<SentPlan>(short).is_err());
        prop_assert!(read::<SentPlan>(&[MARK, &noise].concat()).is_err());
        // A changed byte may give another plan, but never a panic.
        let place = at.index(bytes.len());
        bytes[place] = byte;
        let converter = DefaultPhysicalProtoConverter {};
        drop(PhysicalCodec::default().try_decode(&bytes, &[no_files()], &TaskContext::default(), &converter));
        drop(LogicalCodec::default().try_decode_table_provider(
            &bytes, &TableReference::bare("t"), Table::Frames.schema(), &TaskContext::default()));
    }
}

#[test]
fn columns_that_there_are_not_and_other_versions_are_errors() {
    let spec = ScanSpec {
        table: Table::Frames,
        columns: vec![1000],
        tests: Vec::new(),
        fetch: None,
        skips: true,
        devices: Devices::default(),
    };
    let mut bytes = Vec::new();
    write(SentPlan::Scan(spec), &mut bytes).unwrap();
    let converter = DefaultPhysicalProtoConverter {};
    let decode =
        |bytes: &[u8]| PhysicalCodec::default().try_decode(bytes, &[no_files()], &TaskContext::default(), &converter);
    assert!(decode(&bytes).is_err());
    let newer = [MARK, br#"{"schema":1000,"what":{"Unheard":{}}}"#].concat();
    assert!(decode(&newer).unwrap_err().to_string().contains("same canvass-fleet on all computers"));
}
