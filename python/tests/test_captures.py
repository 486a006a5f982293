"""Captures as objects and as tables of other libraries."""

import canvass
import duckdb
import pandas
import polars
import pyarrow
import pytest

DEVICE = {63: "kuebler-sendix-58x8"}


def test_frames(commissioning):
    frames = list(canvass.read(commissioning))
    assert len(frames) == 39
    first = frames[0]
    assert (first.can_id, first.data, first.channel, first.time_ns) == (0x73F, b"\0", "can0", 1738061235000000000)
    assert not (first.is_extended or first.is_remote or first.is_error or first.is_fd) and first.length == 1
    assert repr(first) == "<Frame 1738061235.000000 can0 73F#00>"


def test_messages(commissioning):
    messages = list(canvass.decode(commissioning, device=DEVICE))
    assert len(messages) == 39
    boot_up = messages[0]
    assert (boot_up.service, boot_up.node, boot_up.meaning) == ("boot-up", 63, "boot-up")
    read = next(message for message in messages if message.service == "sdo" and message.index == 0x1008)
    assert read.object == "Manufacturer device name" and read.frame.data


def test_tables_of_every_library(commissioning):
    capture = canvass.read(commissioning, device=DEVICE)
    table = pyarrow.table(capture.frames)
    assert table.num_rows == 39 and table.column_names == capture.frames.columns
    signals = polars.DataFrame(capture.signals)
    angles = signals.filter(polars.col("scaled_unit") == "°")["scaled"].to_list()
    assert angles == pytest.approx([863.173828125, 863.2177734375])
    frame = pyarrow.table(capture.messages).to_pandas()
    assert isinstance(frame, pandas.DataFrame) and (frame.service == "sdo").sum() == 23
    events = pyarrow.table(capture.events)
    assert duckdb.sql("SELECT count(*) FROM events WHERE event = 'boot-up'").fetchone() == (2,)
    # A capture is read from its beginning each time.
    assert pyarrow.table(capture.frames) == table


def test_a_table_of_many_batches_has_every_row(tmp_path):
    path = tmp_path / "long.log"
    path.write_text("".join(f"({n / 1000:.6f}) can0 {0x180 + n % 100:03X}#{n:08X}\n" for n in range(150_000)))
    table = pyarrow.table(canvass.read(path).frames)
    assert table.num_rows == 150_000 and len(table.to_batches()) == 3
    assert table["data"][149_999].as_py() == (149_999).to_bytes(4, "big")
    assert [frame.can_id for frame in canvass.read(path)][:3] == [0x180, 0x181, 0x182]


def test_damages_are_noted(tmp_path):
    path = tmp_path / "damaged.log"
    path.write_text("(1.0) can0 701#05\n(1.1) can0 70\n(1.2) can0 701#05\n")
    capture = canvass.read(path)
    assert len(list(capture)) == 2
    assert capture.damage_count == 1 and f"{path}:2" in capture.damages[0]


def test_mistakes_are_errors(tmp_path):
    with pytest.raises(OSError, match="no-such"):
        canvass.read(tmp_path / "no-such.log")
    with pytest.raises(ValueError, match="expected one of"):
        canvass.read(tmp_path, format="no-format")
    with pytest.raises(OSError, match="neither a built-in model"):
        canvass.read("a.log", device={5: "no-such-model"})
    with pytest.raises(ValueError, match="at least one"):
        canvass.read()


def test_diagnosis(commissioning):
    diagnosis = canvass.diagnose(commissioning)
    finding = next(finding for finding in diagnosis.errors if finding.rule == "emcy/raised")
    assert finding.node == 5 and "4310h" in str(finding) and finding.evidence[0].id == 0x85
    with pytest.raises(AttributeError, match="expected one of"):
        finding.colour
    with pytest.raises(canvass.CanvassError, match="no-such") as error:
        canvass.diagnose("no-such.log")
    assert error.value.status == 2


def test_descriptions(tmp_path):
    description = canvass.Description("kuebler-sendix-58x8")
    vendor = description[0x1018, 1]
    assert (vendor.type, vendor.access, vendor.default) == ("UNSIGNED32", "ro", "19")
    assert (0x1018, 1) in description and 0x2FFF not in description and len(description) > 100
    wrong = tmp_path / "wrong.eds"
    wrong.write_text("[DeviceInfo]\nVendorName=\n")
    assert canvass.Description(wrong).check()
