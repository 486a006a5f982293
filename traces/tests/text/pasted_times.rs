//! Times, channels and columns of pasted lines that are easily misread.

use crate::pasted::{asks, directions, gives, micros, open_with, tells};
use canvass_traces::*;

const REQUEST: &str = "605#4000100000000000";
const ANSWER: &str = "585#4300100092010200";
const BEAT: &str = "705#05";
const BOTH: &[&str] = &[REQUEST, ANSWER];

#[test]
fn times_with_decimal_commas() {
    let given_commas = |text: &str| {
        let given = gives(text, &[REQUEST, ANSWER, BEAT]);
        assert_eq!(micros(&given), [100_100, 101_000, 500_000], "{text}");
    };
    given_commas(
        "0,100100\t605\t8\t40\t00\t10\t00\t00\t00\t00\t00\n0,101000\t585\t8\t43\t00\t10\t00\t92\t01\t02\t00\n0,500000\t705\t1\t05\n",
    );
    given_commas("0,100100 605 8 40 00 10 00 00 00 00 00\n0,101000 585 8 43 00 10 00 92 01 02 00\n0,500000 705 1 05\n");
    given_commas(
        "Time;ID;DLC;Data\n0,100100;605;8;40 00 10 00 00 00 00 00\n0,101000;585;8;43 00 10 00 92 01 02 00\n0,500000;705;1;05\n",
    );
    let given = gives(
        "2023-05-01 10:00:00,100 INFO Tx 605 8 40 00 10 00 00 00 00 00\n2023-05-01 10:00:00,101 INFO Rx 585 8 43 00 10 00 92 01 02 00\n2023-05-01 10:00:01,500 INFO Rx 705 1 05\n",
        &[REQUEST, ANSWER, BEAT],
    );
    let gaps: Vec<u64> = micros(&given).windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert_eq!(gaps, [1_000, 1_399_000]);
    assert!(given.channels.iter().all(|name| name == "1"), "{:?}", given.channels);
    gives("605,40 00 10 00 00 00 00 00\n585,43 00 10 00 92 01 02 00\n705,05\n", &[REQUEST, ANSWER, BEAT]);
}

#[test]
fn a_time_of_a_table_that_is_no_time_is_told() {
    tells(
        "Time,ID,DLC,Data\n0.1001,605,8,4000100000000000\n0.1O10,585,8,4300100092010200\n0.5002,705,1,05\n",
        &[REQUEST, BEAT],
        &[3],
    );
}

#[test]
fn names_of_messages_and_nodes_are_no_channels() {
    for text in [
        "0.100100 605 RSDO5 Rx 8 40 00 10 00 00 00 00 00\n0.101000 585 TSDO5 Rx 8 43 00 10 00 92 01 02 00\n",
        "0.100100 drive_1 605 8 40 00 10 00 00 00 00 00\n0.101000 drive_2 585 8 43 00 10 00 92 01 02 00\n",
    ] {
        assert_eq!(gives(text, BOTH).channels, ["1"], "{text}");
    }
    let given = gives(
        "1 605 8 40 00 10 00 00 00 00 00\n2 585 8 43 00 10 00 92 01 02 00\n1 705 1 05\n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(given.channels, ["1", "2"]);
    assert!(given.interpretation.unwrap().contains("channel"));
}

#[test]
fn small_numbers_may_be_times() {
    let growing = "0 605 8 40 00 10 00 00 00 00 00\n1 585 8 43 00 10 00 92 01 02 00\n20 705 1 05\n40 705 1 05\n";
    let frames: &[&str] = &[REQUEST, ANSWER, BEAT, BEAT];
    asks(growing, [("time[ms],id,len,data", frames), ("channel,id,len,data", frames)]);
    let given = open_with(growing, Some("time[ms],id,len,data")).unwrap();
    assert_eq!(micros(&given), [0, 1_000, 20_000, 40_000]);
}

#[test]
fn the_columns_of_a_question_keep_what_is_known() {
    let text = "385 8 0 1 12 0 0 11 3 0\n1541 4 12 0 10 1\n1797 1 5\n385 8 0 2 10 0 0 12 3 0\n";
    let error = open_with(text, None).err().unwrap();
    let OpenError::Ambiguous { ref question, .. } = error else { panic!("{error}") };
    assert!(question.columns().iter().all(|columns| columns.contains("id[dec]")), "{error}");
}

#[test]
fn prose_does_not_decide_the_unit() {
    let rows = "0.100100 605 8 40 00 10 00 00 00 00 00\n0.101000 585 8 43 00 10 00 92 01 02 00\n0.500000 705 1 05\n";
    for prose in
        ["Master: SDO timeout (ms): 500", "DT 4711: drive does not answer", "The cycle time of id 5 is 3 ms (ms)"]
    {
        let given = gives(&format!("{prose}\n\n{rows}"), &[REQUEST, ANSWER, BEAT]);
        assert_eq!(micros(&given), [100_100, 101_000, 500_000], "{prose}");
    }
    let given = gives(
        "time[ms] delta[s] id len data\n100.0 0.1 605 8 40 00 10 00 00 00 00 00\n200.0 0.1 585 8 43 00 10 00 92 01 02 00\n",
        BOTH,
    );
    assert_eq!(micros(&given), [100_000, 200_000]);
}

#[test]
fn a_clock_that_starts_again_has_no_differences() {
    let restart = "10.100000 605 8 40 00 10 00 00 00 00 00\n10.101000 585 8 43 00 10 00 92 01 02 00\n10.500000 705 1 05\n1.100000 605 8 40 00 10 00 00 00 00 00\n1.101000 585 8 43 00 10 00 92 01 02 00\n";
    let given = gives(restart, &[REQUEST, ANSWER, BEAT, REQUEST, ANSWER]);
    assert_eq!(micros(&given), [10_100_000, 10_101_000, 10_500_000, 1_100_000, 1_101_000]);
    let differences = "0.100000 705 1 05\n0.001000 705 1 05\n0.300000 705 1 05\n0.002000 705 1 05\n0.400000 705 1 05\n0.001000 705 1 05\n";
    let given = gives(differences, &[BEAT; 6]);
    assert_eq!(micros(&given), [100_000, 101_000, 401_000, 403_000, 803_000, 804_000]);
    let short = "0.500000 705 1 05\n0.100000 705 1 05\n";
    asks(short, [("time[s],id,len,data", &[BEAT, BEAT]), ("delta[s],id,len,data", &[BEAT, BEAT])]);
    assert_eq!(micros(&open_with(short, Some("delta[s],id,len,data")).unwrap()), [500_000, 600_000]);
}

#[test]
fn long_gaps_do_not_change_the_unit() {
    let text = "10.123 085 8 00 50 01 00 00 00 00 00\n100.456 085 8 00 00 00 00 00 00 00 00\n301.001 085 8 10 81 11 00 00 00 00 00\n";
    let frames: &[&str] = &["085#0050010000000000", "085#0000000000000000", "085#1081110000000000"];
    asks(text, [("time[s],id,len,data", frames), ("time[ms],id,len,data", frames)]);
    let given = gives(
        "1000 ms 605 8 40 00 10 00 00 00 00 00\n1250 ms 585 8 43 00 10 00 92 01 02 00\n1300 ms 705 1 05\n",
        &[REQUEST, ANSWER, BEAT],
    );
    assert_eq!(micros(&given), [1_000_000, 1_250_000, 1_300_000]);
    let given = gives("12.500 ms: 605 8 40 00 10 00 00 00 00 00\n12.512 ms: 585 8 43 00 10 00 92 01 02 00\n", BOTH);
    assert_eq!(micros(&given), [12_500, 12_512]);
}

#[test]
fn dates_and_times_of_the_day() {
    let given = gives(
        "Date,Time,ID,DLC,Data\n2023-05-01,10:00:00.100,605,8,40 00 10 00 00 00 00 00\n2023-05-01,10:00:00.500,585,8,43 00 10 00 92 01 02 00\n",
        BOTH,
    );
    assert_eq!(micros(&given)[1] - micros(&given)[0], 400_000);
    let may_first = 1_682_899_200_u64;
    assert_eq!(micros(&given)[0], (may_first + 36_000) * 1_000_000 + 100_000);
    assert_eq!(given.base, TimeBase::Local);
    let given = gives(
        "2023-05-01T10:00:00.100Z 605 8 40 00 10 00 00 00 00 00\n2023-05-01T10:00:00.101Z 585 8 43 00 10 00 92 01 02 00\n",
        BOTH,
    );
    assert_eq!(given.base, TimeBase::Utc);
    let date = "05/06/2023 10:00:00.100 605 8 40 00 10 00 00 00 00 00\n05/06/2023 10:00:00.101 585 8 43 00 10 00 92 01 02 00\n";
    asks(date, [("date[mdy],id,len,data", BOTH), ("date[dmy],id,len,data", BOTH)]);
    let day = |columns: &str| micros(&open_with(date, Some(columns)).unwrap())[0] / 86_400_000_000;
    assert_eq!((day("date[mdy],id,len,data"), day("date[dmy],id,len,data")), (19_483, 19_513));
    gives(&date.replace("05/06", "25/06"), BOTH);
}

#[test]
fn a_list_without_head_has_no_times() {
    let given = gives("585h\t\t8\t43 00 10 00 92 01 02 00\t100.1\t12\n705h\t\t1\t05\t1000.0\t7\n", &[ANSWER, BEAT]);
    assert_eq!(given.base, TimeBase::None);
    assert!(given.records.iter().all(|record| record.comment().is_none()));
    assert!(given.interpretation.unwrap().contains("last frame of each id"));
}

#[test]
fn arrows_of_a_monitor_are_no_directions() {
    let given = gives(
        "10:00:00.100 -> Standard ID: 0x605       DLC: 8  Data: 0x40 0x00 0x10 0x00 0x00 0x00 0x00 0x00\n10:00:00.101 -> Standard ID: 0x585       DLC: 8  Data: 0x43 0x00 0x10 0x00 0x92 0x01 0x02 0x00\n",
        BOTH,
    );
    assert_eq!(directions(&given), [Direction::Unknown; 2]);
}

#[test]
fn times_of_zlg_and_addresses() {
    let given = gives(
        "0\t0x605\t10:00:00.100.1\tSend\tData\tStandard\t8\t40 00 10 00 00 00 00 00\n1\t0x585\t10:00:00.101.3\tReceive\tData\tStandard\t8\t43 00 10 00 92 01 02 00\n",
        BOTH,
    );
    assert_eq!(micros(&given), [36_000_100_100, 36_000_101_300]);
    gives("192.168.1.10 605 8 40 00 10 00 00 00 00 00\n192.168.1.10 585 8 43 00 10 00 92 01 02 00\n", BOTH);
}
#[test]
fn columns_keep_the_details_that_were_given() {
    let text =
        "05/06/2023 10:00:00.100 00000605 8 40 0 10 0 0 0 0 0\n05/06/2023 10:00:00.101 00000585 8 43 0 10 0 92 1 2 0\n";
    let mut columns: Option<String> = None;
    for _ in 0..3 {
        let error = open_with(text, columns.as_deref()).err().unwrap();
        let OpenError::Ambiguous { question, .. } = error else { panic!("{error}") };
        columns = Some(question.columns()[0].to_owned());
    }
    assert_eq!(columns.as_deref(), Some("date[mdy],id[11],len,data[hex]"));
    assert_eq!(open_with(text, columns.as_deref()).unwrap().frames, BOTH);
    let table = "time,id,dlc,data\n1.0,1541,8,4000100000000000\n2.0,1413,8,4300100092010200\n";
    assert!(
        open_with(table, Some("id[dec],data")).err().unwrap().to_string().contains("--columns time[ms],id[dec],data")
    );
    assert_eq!(open_with(table, Some("time[ms],id[dec],data")).unwrap().frames, BOTH);
}
