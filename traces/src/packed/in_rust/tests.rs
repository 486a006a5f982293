use super::*;
use crate::packed::in_c;
use proptest::prelude::*;

fn all(reader: io::Result<impl Read>) -> (Vec<u8>, bool) {
    let mut content = Vec::new();
    let read = reader.and_then(|mut reader| reader.read_to_end(&mut content));
    (content, read.is_ok())
}

/// Text that compresses well, and bytes that do not.
fn content() -> impl Strategy<Value = Vec<u8>> {
    let repeated = (proptest::collection::vec(any::<u8>(), 1..40), 1..4000_usize).prop_map(|(part, n)| part.repeat(n));
    prop_oneof![repeated, proptest::collection::vec(any::<u8>(), 0..20_000)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn both_libraries_read_the_same(first in content(), second in content(), level in 1..20) {
        let frame = |content: &[u8]| ::zstd::encode_all(content, level).unwrap();
        // A skippable frame is between the two frames.
        let packed = [frame(&first), vec![0x50, 0x2A, 0x4D, 0x18, 3, 0, 0, 0, 1, 2, 3], frame(&second)].concat();
        let both = [&first[..], &second[..]].concat();
        prop_assert_eq!(all(zstd(&packed[..])), (both.clone(), true));
        prop_assert_eq!(all(in_c::zstd(&packed[..])), (both, true));

        let mut encoder = ::lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
        encoder.write_all(&first).unwrap();
        let packed = encoder.finish().0;
        prop_assert_eq!(all(lz4(&packed[..])), (first.clone(), true));
        prop_assert_eq!(all(in_c::lz4(&packed[..])), (first, true));
    }

    #[test]
    fn a_cut_stream_gives_what_stood_before_and_says_that_it_is_cut(content in content(), at in any::<prop::sample::Index>()) {
        let packed = ::zstd::encode_all(&content[..], 3).unwrap();
        let mut reader = zstd(&packed[..1 + at.index(packed.len() - 1)]).unwrap();
        let mut read = Vec::new();
        let error = reader.read_to_end(&mut read).err();
        prop_assert!(content.starts_with(&read));
        prop_assert_eq!(error.map(|error| error.kind()), Some(io::ErrorKind::UnexpectedEof));
    }

    #[test]
    fn changed_streams_do_no_harm(content in content(), at in any::<prop::sample::Index>(), to in any::<u8>()) {
        let mut packed = ::zstd::encode_all(&content[..], 3).unwrap();
        *at.get_mut(&mut packed) = to;
        let most = 8 << 20;
        let read = zstd(&packed[..]).and_then(|reader| io::copy(&mut reader.take(most), &mut io::sink()));
        prop_assert!(read.is_err() || read.is_ok_and(|n| n <= most));
    }
}
