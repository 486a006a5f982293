use super::*;
use canvass_traces::{ErrorClass, Flags};
use proptest::prelude::*;

fn id() -> impl Strategy<Value = CanId> {
    prop_oneof![
        (0..0x800_u32).prop_map(CanId::standard_masked),
        (0..0x2000_0000_u32).prop_filter_map("29 bits", CanId::extended)
    ]
}

/// Any frame that a capture can hold.
fn frame() -> impl Strategy<Value = Record> {
    let untimed = |frame| Record::new(Timestamp::ZERO, ChannelId(0), frame);
    let data = |most| proptest::collection::vec(any::<u8>(), 0..=most);
    let classical = (id(), data(8)).prop_filter_map("data", move |(id, data)| Frame::new(id, &data).map(untimed));
    let raw = (id(), data(8), 9..16_u8).prop_filter_map("DLC", move |(id, data, dlc)| {
        Frame::new(id, &data).map(|frame| untimed(frame.with_raw_dlc(dlc)))
    });
    let remote = (id(), 0..=8_u8).prop_filter_map("remote", move |(id, len)| Frame::remote(id, len).map(untimed));
    let error = (0..0x200_u32, data(8))
        .prop_filter_map("error", move |(class, data)| Frame::error(ErrorClass(class), &data).map(untimed));
    let fd =
        (id(), 0..4_u8, proptest::sample::select(&Frame::FD_LENGTHS[..])).prop_filter_map("FD", |(id, flags, n)| {
            let data = vec![0xA5; usize::from(n)];
            Record::fd(Timestamp::ZERO, ChannelId(0), id, Flags::from_bits(flags).with(Flags::FDF), &data)
        });
    let header =
        any::<(u8, bool, bool, u8, u32)>().prop_map(|(vcid, sec, rrs, sdt, af)| XlHeader { vcid, sec, rrs, sdt, af });
    let xl = (0..0x800_u32, header, data(300)).prop_filter_map("XL", |(priority, xl, data)| {
        Record::xl(Timestamp::ZERO, ChannelId(0), CanId::standard_masked(priority), xl, &data)
    });
    prop_oneof![4 => classical, 1 => raw, 1 => remote, 1 => error, 1 => fd, 1 => xl]
}

fn record() -> impl Strategy<Value = Record> {
    let direction = proptest::sample::select(&[Direction::Unknown, Direction::Rx, Direction::Tx][..]);
    (frame(), any::<u64>(), 0..300_u16, direction, any::<u64>()).prop_map(
        |(mut record, time, channel, direction, number)| {
            record.timestamp = Timestamp(time);
            record.channel = ChannelId(channel);
            record.with_direction(direction).at(number, 0)
        },
    )
}

proptest! {
    #[test]
    fn records_come_back_as_they_were(records in proptest::collection::vec(record(), 0..20)) {
        let (mut packed, mut before) = (Vec::new(), Before::default());
        records.iter().for_each(|record| push(record, &mut before, &mut packed));
        let (mut rest, mut before) = (&packed[..], Before::default());
        let back: Vec<_> = std::iter::from_fn(|| take(&mut rest, &mut before)).collect();
        prop_assert_eq!(back, records);
    }

    #[test]
    fn any_bytes_do_no_harm(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let (mut rest, mut before) = (&bytes[..], Before::default());
        while take(&mut rest, &mut before).is_some() {}
    }
}
