"""Findings as JUnit XML, for continuous integration: a finding is a test case."""

import re
from collections import Counter
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from refdem.core.finding import BROKEN, FAILING, Finding, Record
from refdem.report.contents import Contents

SKIPPED = ("unsupported", "undecided")
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(contents: Contents) -> bytes:
    """The XML: failures for what closes a gate or breaks a run; skipped, with the reason, for
    unsupported and undecided.
    """
    findings = list(contents.findings())
    counts: dict[str, int] = {str(outcome): count for outcome, count in contents.counts().items()}
    root = Element("testsuites", name="refdem")
    sharing = Counter(id(record) for record, _ in findings)
    numbers = {
        "tests": len(findings),
        "failures": sum(counts.get(x, 0) for x in FAILING),
        "errors": counts.get("error", 0),
        "skipped": sum(counts.get(x, 0) for x in SKIPPED),
    }
    attributes = {key: str(value) for key, value in numbers.items()}
    name = _text(contents.campaign.name)
    attributes["time"] = f"{sum(record.seconds for record in contents.records):.6f}"
    suite = SubElement(root, "testsuite", name=name, attrib=attributes)
    for record, finding in findings:
        # The findings of a record share its runs.
        _testcase(suite, record, finding, record.seconds / sharing[id(record)])
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _testcase(suite: Element, record: Record, finding: Finding, seconds: float) -> None:
    """Adds a finding to the suite as a test case, with its share of the seconds in the engine.

    The test case of a finding that passed has no child element.
    """
    place = _text(f"{record.label}/{record.engine}")
    name = _text(record.id(finding))
    item = SubElement(suite, "testcase", classname=place, name=name, time=f"{seconds:.6f}")
    message = _text(finding.sentence)
    if finding.outcome in BROKEN:
        if finding.outcome == "error":
            tag = "error"
        else:
            tag = "failure"
        element = SubElement(item, tag, type=finding.outcome, message=message)
        element.text = _text(finding.basis)
    elif finding.outcome in SKIPPED:
        SubElement(item, "skipped", type=finding.outcome, message=message)


def _text(text: str) -> str:
    """Text without the characters that XML 1.0 does not allow."""
    return _FORBIDDEN.sub("\ufffd", text)
