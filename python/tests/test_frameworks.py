"""The plugin for pytest and the library for Robot Framework."""

import subprocess
import sys

import pytest

MODEL = "sim:kuebler-sendix-58x8"


def test_cases_are_tests(pytester):
    chosen = ["--canvass-select", "301/boot-up,301/nmt/back-to-back"]
    good = pytester.runpytest_subprocess(f"--canvass-bus={MODEL}", *chosen, "-v")
    outcomes = good.parseoutcomes()
    assert outcomes.get("failed", 0) == 0 and outcomes["passed"] >= 4, good.stdout.str()
    good.stdout.fnmatch_lines(["canvass *: device at sim:kuebler-sendix-58x8*", "*301/boot-up/every-time*PASSED*"])
    wrong = pytester.runpytest_subprocess(f"--canvass-bus={MODEL}+boot-up-twice", *chosen, "-rA")
    assert wrong.parseoutcomes()["failed"] >= 1 and wrong.ret == 1
    wrong.stdout.fnmatch_lines(["*CiA 301 7.2.8.3.3*", "*expected boot-up, found 73F with 00, 73F with 00*"])


def test_cases_are_chosen_by_pytest(pytester):
    listed = pytester.runpytest_subprocess(f"--canvass-bus={MODEL}", "-m", "canvass", "-k", "boot-up", "--collect-only", "-q")
    lines = [line for line in listed.stdout.lines if "301/" in line]
    assert lines and all("boot-up" in line for line in lines)
    unknown = pytester.runpytest_subprocess(f"--canvass-bus={MODEL}", "--canvass-select", "301/no-such")
    assert unknown.ret == 4 and "no case has this name" in unknown.stderr.str() + unknown.stdout.str()


def test_documented_deviations_are_expected_failures(pytester):
    done = pytester.runpytest_subprocess(f"--canvass-bus={MODEL}", "--canvass-select", "301/error-behaviour", "-rx")
    outcomes = done.parseoutcomes()
    assert outcomes["xfailed"] >= 1 and "failed" not in outcomes, done.stdout.str()


def test_without_a_bus_the_plugin_is_silent(pytester):
    pytester.makepyfile("def test_nothing(): pass")
    done = pytester.runpytest_subprocess()
    assert done.parseoutcomes() == {"passed": 1} and "canvass 0" not in done.stdout.str()


def test_fixtures(pytester):
    pytester.makepyfile(
        """
        def test_vendor(canopen_device, capture):
            assert canopen_device.sdo.upload(0x1018, 1) == b"\\x13\\0\\0\\0"

        def test_wrong(canopen_device, capture):
            canopen_device.sdo.upload(0x1018, 1)
            assert capture.diagnose().findings == []
            assert canopen_device.sdo.upload(0x1018, 1) == b"\\0"
        """
    )
    done = pytester.runpytest_subprocess(
        f"--canvass-bus={MODEL}", "--canvass-select", "301/boot-up/every-time", "--canvass-captures", "kept"
    )
    assert done.parseoutcomes() == {"passed": 2, "failed": 1}, done.stdout.str()
    done.stdout.fnmatch_lines(["*canvass: the last of * frames*", "*5BF#4318100113000000*", "*diagnosis of the capture*"])
    kept = pytester.path / "kept/test_vendor.log"
    assert "5BF#4318100113000000" in kept.read_text()
    skipped = pytester.runpytest_subprocess("-rs")
    assert skipped.parseoutcomes() == {"skipped": 2} and "--canvass-bus" in skipped.stdout.str()


SUITE = """
*** Settings ***
Library    canvass.robot.Canvass    bus=sim:kuebler-sendix-58x8    node=63

*** Test Cases ***
The Encoder Conforms
    Device Should Conform    301/boot-up
The Vendor Is Known
    ${vendor} =    Read Object    1018:01
    Should Be Equal As Integers    ${vendor}    19
    Write Object    1017:00    100
    Send NMT Command    start    63
A Wrong Boot-Up Is Found
    Use Device    sim:kuebler-sendix-58x8+boot-up-twice    63
    Run Keyword And Expect Error    *fail 301/boot-up*    Device Should Conform    301/boot-up
    ${result} =    Run Conformance Cases    301/boot-up
    Should Not Be Empty    ${result.failures}
A Capture Is Diagnosed
    Run Keyword And Expect Error    *EMCY 4310h*    Capture Should Be Healthy    {capture}
    ${diagnosis} =    Diagnose Capture    {capture}
    Should Be Equal    ${diagnosis.findings[0].severity}    error
The Encoder Withstands
    Use Device    sim:reference-301    10
    Device Should Withstand Fuzzing    seconds=0.3
A Firmware With A Fault Does Not
    Use Device    sim:reference-301+sdo-stray-segment-silent    10
    Run Keyword And Expect Error    *expected a download segment without its transfer*    Device Should Withstand Fuzzing    seconds=2
"""


def test_robot_framework(tmp_path, commissioning):
    suite = tmp_path / "encoder.robot"
    suite.write_text(SUITE.replace("{capture}", str(commissioning)))
    done = subprocess.run([sys.executable, "-m", "robot", "--outputdir", tmp_path, suite], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "6 tests, 6 passed, 0 failed" in done.stdout


def test_the_keywords_are_documented(tmp_path):
    page = tmp_path / "keywords.html"
    done = subprocess.run([sys.executable, "-m", "robot.libdoc", "canvass.robot.Canvass", page], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = page.read_text(encoding="utf-8")
    assert "Device Should Conform" in text and "Diagnose Capture" in text


@pytest.mark.parametrize("module", ["canvass", "canvass.bridge", "canvass.can", "canvass.pytest_plugin", "canvass.robot"])
def test_every_module_is_documented(module):
    import importlib

    assert importlib.import_module(module).__doc__
