"""The results of the program, as objects: each has the fields of the program's JSON output as attributes."""

from __future__ import annotations

from typing import Any, Iterator, Optional


class Result:
    """A JSON object whose members are attributes; those that are objects themselves are results, too."""

    def __init__(self, document: dict):
        self._document = document

    def __getattr__(self, name: str) -> Any:
        try:
            return _wrapped(self._document[name])
        except KeyError:
            known = ", ".join(self._document)
            raise AttributeError(f"no field {name!r}: expected one of {known}") from None

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


class TestRun(Result):
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
    def passed(self) -> bool:
        """Whether no case failed and the run was not interrupted."""
        return not self._document["cancelled"] and not self.failures

    def case(self, id: str) -> Optional[Case]:
        """The case with this id, if it was chosen."""
        return next((case for case in self.cases if case.id == id), None)


class FuzzRun(Result):
    """The result of a run of the fuzzer."""

    @property
    def passed(self) -> bool:
        """Whether no violation was confirmed."""
        return not any(violation["confirmed"] for violation in self._document["violations"])
