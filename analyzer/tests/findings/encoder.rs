use crate::traffic::{Traffic, hex, machine};

#[test]
fn an_alarm_and_a_warning() {
    let mut alarm = machine();
    alarm.sdo(15_100, 3, "4003650000000000", "4B03650001000000");
    let finding = alarm.finds("encoder/alarm", Some(3), 15_103);
    assert!(finding.message.contains("bit 0") && finding.message.contains("position error"), "{}", finding.message);
    let mut warning = machine();
    warning.sdo(15_100, 3, "4005650000000000", "4B05650010000000");
    let finding = warning.finds("encoder/warning", Some(3), 15_103);
    assert!(finding.message.contains("battery"), "{}", finding.message);
}

/// Node 4 is no encoder, so its 6503h has another meaning.
#[test]
fn other_profiles_have_other_objects() {
    machine().sdo(15_100, 4, "4003650000000000", "4B03650001000000").only(&[]);
}

#[test]
fn a_jump_of_the_position() {
    let mut traffic = machine();
    traffic.remove(|ms, frame| ms == 15_000 && frame.cob_id() == Some(0x183));
    traffic.micros(15_000_400, &format!("183#{}", hex(9_000_000)));
    let finding = traffic.finds("encoder/position-jump", Some(3), 15_000);
    assert_eq!(finding.count, 2, "there and back");
}

/// A wrap at the end of the range, 6002h = 0100 0000h, is no jump.
#[test]
fn the_end_of_the_range() {
    let mut traffic = machine();
    traffic.remove(|_, frame| frame.cob_id() == Some(0x183));
    for n in 0..1000_u64 {
        let position = (0x0100_0000 + 0x2000_u64 - n * 16) % 0x0100_0000;
        traffic.micros(1_020_400 + n * 20_000, &format!("183#{}", hex(position)));
    }
    traffic.remove(|ms, frame| ms > 21_020 && frame.cob_id() == Some(0x080));
    traffic.only(&["pdo/sync-missing"]);
}

fn with_speed() -> Traffic {
    let mut traffic = machine();
    traffic.remove(|_, frame| matches!(frame.cob_id(), Some(0x283 | 0x183)));
    let ok = "60";
    traffic.sdo(600, 3, "2F011A0000000000", &format!("{ok}011A0000000000"));
    traffic.sdo(610, 3, "23011A0120000460", &format!("{ok}011A0100000000"));
    traffic.sdo(620, 3, "23011A0210013060", &format!("{ok}011A0200000000"));
    traffic.sdo(630, 3, "2F011A0002000000", &format!("{ok}011A0000000000"));
    traffic
}

#[test]
fn a_position_that_stands_still_at_speed() {
    let mut frozen = with_speed();
    frozen.every(1_007, 30_000, 50, |n| {
        let position = if n < 200 { n * 100 } else { 20_000 };
        format!("283#{}6400", hex(position))
    });
    frozen.finds("encoder/position-frozen", Some(3), 11_007);
    let mut standing = with_speed();
    standing.every(1_007, 30_000, 50, |_| format!("283#{}0100", hex(20_000))).only(&[]);
}

#[test]
fn a_position_outside_its_range() {
    let mut traffic = machine();
    traffic.sdo(15_100, 3, "4004600000000000", "4304600000000002");
    traffic.finds("encoder/position-outside-range", Some(3), 15_103);
}

#[test]
fn a_preset_in_operation() {
    let mut traffic = machine();
    traffic.sdo(15_100, 3, "2303600000000000", "6003600000000000");
    traffic.finds("encoder/parameter-changed", Some(3), 15_103);
}

/// A draw-wire encoder with two channels: one counts up as the other counts down.
fn draw_wire(b: impl Fn(u64) -> u64) -> Traffic {
    let mut traffic = Traffic::default();
    traffic.sdo(100, 4, "4000100000000000", "4300100096010000");
    traffic.sdo(110, 4, "40001A0000000000", "4F001A0002000000");
    traffic.sdo(120, 4, "40001A0100000000", "43001A0110002060");
    traffic.sdo(130, 4, "40001A0200000000", "43001A0210002060");
    traffic.at(200, "000#0104");
    traffic.every(300, 10_000, 100, |n| {
        let (a, b) = ((100 + n) as u16, b(n) as u16);
        format!("184#{:04X}{:04X}", a.swap_bytes(), b.swap_bytes())
    });
    traffic
}

#[test]
fn redundant_channels() {
    draw_wire(|n| 47_000 - 100 - n).only(&[]);
    draw_wire(|n| if n < 50 { 47_000 - 100 - n } else { 40_000 }).finds("encoder/redundant-channels", Some(4), 5_300);
}

/// No mapping is known: the constant sum of the halves shows that they are channels.
#[test]
fn redundant_channels_without_a_mapping() {
    let traffic = |b: fn(u64) -> u64| {
        let mut traffic = Traffic::default();
        traffic.sdo(100, 4, "4000100000000000", "4300100096010000").at(200, "000#0104");
        traffic.every(300, 10_000, 100, |n| {
            let (a, b) = ((100 + n) as u16, b(n) as u16);
            format!("184#{:04X}{:04X}", a.swap_bytes(), b.swap_bytes())
        });
        traffic
    };
    traffic(|n| 47_000 - 100 - n).only(&[]);
    traffic(|n| n * 7919 % 40_000).only(&[]);
    traffic(|n| if n < 50 { 47_000 - 100 - n } else { 46_850 }).finds("encoder/redundant-channels", Some(4), 7_400);
}

/// With 0.01 mm a step, the rod moves half a metre in 20 ms.
#[test]
fn a_jump_of_a_linear_position() {
    let linear = |jump: u64| {
        let mut traffic = Traffic::default();
        traffic.sdo(100, 4, "4000100000000000", "4300100096010800").sdo(110, 4, "4001650000000000", "4301650010270000");
        traffic.sdo(120, 4, "40001A0000000000", "4F001A0001000000").sdo(130, 4, "40001A0100000000", "43001A0120000460");
        traffic.at(200, "000#0104");
        traffic.every(300, 10_000, 20, move |n| {
            format!("184#{}", hex(100_000 + n * 20 + if n >= 250 { jump } else { 0 }))
        });
        traffic
    };
    linear(0).only(&[]);
    linear(200_000).finds("encoder/position-jump", Some(4), 5_300);
}

/// Scaling is off, so the range is that of the sensor: 4096 steps times 4096 revolutions.
#[test]
fn a_position_outside_the_physical_range() {
    let mut traffic = machine();
    traffic.sdo(600, 3, "4001650000000000", "4301650000100000").sdo(610, 3, "4002650000000000", "4302650000100000");
    traffic.sdo(620, 3, "4000650000000000", "4B00650000000000");
    traffic.sdo(15_100, 3, "4004600000000000", "4304600000000001");
    traffic.finds("encoder/position-outside-range", Some(3), 15_103);
}
