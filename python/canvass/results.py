"""The results of the program, as objects: each has the fields of the program's JSON output as attributes."""

from __future__ import annotations

from typing import Any, Iterator, Optional


class Result:
    """A JSON object whose members are attributes; those that are objects themselves are results, too."""

    def __init__(self, document: dict):
        self._document = document

    def __getattr__(self, name: str) -> Any:
        # A copy that has no document yet asks for names of Python itself.
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _wrapped(self._document[name])
        except KeyError:
            known = ", ".join(self._document)
            raise AttributeError(f"no field {name!r}: expected one of {known}") from None

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]

    def __getitem__(self, name: str) -> Any:
        return _wrapped(self._document[name])

    def __contains__(self, name: str) -> bool:
        return name in self._document

    def __iter__(self) -> Iterator[str]:
        return iter(self._document)

    def __dir__(self) -> list:
        return [*super().__dir__(), *self._document]

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._document!r}>"

    def to_dict(self) -> dict:
        """The JSON object itself."""
        return self._document


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Result(value)
    if isinstance(value, list):
        return [_wrapped(item) for item in value]
    return value


class Finding(Result):
    """A finding in a capture."""

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"


class Diagnosis(Result):
    """What is wrong in a capture."""

    @property
    def findings(self) -> list[Finding]:
        """The findings."""
        return [Finding(finding) for finding in self._document["findings"]]

    @property
    def errors(self) -> list[Finding]:
        """The findings of severity *error*."""
        return [finding for finding in self.findings if finding.severity == "error"]


class Case(Result):
    """The result of a conformance case."""

    @property
    def passed(self) -> bool:
        """Whether the verdict is *pass* or *tolerated*."""
        return self._document["verdict"] in ("pass", "tolerated")

    @property
    def failed(self) -> bool:
        """Whether the verdict is *fail* or *error*."""
        return self._document["verdict"] in ("fail", "error")

    def frames(self, most: int = 12) -> str:
        """The last frames of the evidence, as text."""
        shown = self._document["evidence"][-most:]
        lines = (
            f"{frame['t'] / 1e9:.6f} {frame['id']:03X} {frame['data']:<16}  {frame['text']}" for frame in shown
        )
        return "\n".join(lines)

    @property
    def why(self) -> str:
        """Why the case has not passed, in words; empty if it has."""
        reason = self._document["reason"]
        if not isinstance(reason, dict):
            return reason or ""
        return f"{reason['duty']}: expected {reason['expected']}, found {reason['actual']}"

    def __str__(self) -> str:
        return f"{self._document['verdict']} {self._document['id']}" + (f": {self.why}" if self.why else "")


class Run(Result):
    """The result of a run on a device.

    ``status`` is the program's exit status: 0 if the device passed, 1 if it did not or was not left as it was found.
    """

    def __init__(self, document: dict, status: int):
        super().__init__(document)
        self.status = status


class TestRun(Run):
    """The result of a conformance run."""

    __test__ = False

    @property
    def cases(self) -> list[Case]:
        """The cases, in the order in which they ran."""
        return [Case(case) for case in self._document["cases"]]

    @property
    def failures(self) -> list[Case]:
        """The cases that failed."""
        return [case for case in self.cases if case.failed]

    @property
    def inconclusive(self) -> list[Case]:
        """The cases that could not be decided."""
        return [case for case in self.cases if case.verdict == "inconclusive"]

    @property
    def passed(self) -> bool:
        """Whether the device passed: at least one case passed, none failed or was undecided, no case was left out, and
        the device was left as it was found."""
        return self.status == 0 and any(case.passed for case in self.cases)

    @property
    def why(self) -> str:
        """Why the device has not passed, one reason per line; empty if it has."""
        if self.passed:
            return ""
        reasons = [str(case) for case in [*self.failures, *self.inconclusive]]
        if self._document["cancelled"]:
            reasons.append("the run was interrupted")
        reasons += map(str, self._document["notices"])
        return "\n".join(reasons) or "no case passed"

    def case(self, id: str) -> Optional[Case]:
        """The case with this id, if it was chosen."""
        return next((case for case in self.cases if case.id == id), None)


class Violation(Result):
    """A rule that the device broke while it was fuzzed."""

    def __str__(self) -> str:
        return f"{self.id}: expected {self.expected}, found {self.actual} ({self.clause})"


class FuzzRun(Run):
    """The result of a run of the fuzzer."""

    @property
    def violations(self) -> list[Violation]:
        """What the device did wrong, each kind once."""
        return [Violation(violation) for violation in self._document["violations"]]

    @property
    def passed(self) -> bool:
        """Whether no violation was confirmed, the device answered to the end, and the run was complete."""
        return self.status == 0

    @property
    def why(self) -> str:
        """Why the device has not passed, one reason per line; empty if it has."""
        if self.passed:
            return ""
        reasons = [str(violation) for violation in self.violations if violation.confirmed]
        if self.dead:
            reasons.append("the device no longer answers")
        if self.cancelled:
            reasons.append("the run was interrupted")
        if self.ended_by:
            reasons.append(self.ended_by)
        return "\n".join(reasons) or "a violation did not come back when it was repeated (--unconfirmed)"
