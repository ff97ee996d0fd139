"""Findings as SARIF 2.1.0, the form in which code hosts show results beside a change."""

import hashlib
import json
from pathlib import PurePath
from urllib.parse import quote

from refdem.core.finding import BROKEN, Finding, Record
from refdem.core.outside import one_line
from refdem.report.contents import Contents

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def sarif(contents: Contents, described_in: PurePath) -> bytes:
    """The document: a rule for each check that found something broken, and a result for each such
    finding, at the refdem.toml that describes the program.

    SARIF requires a location in a file, but a finding concerns a motion. The location is therefore
    the refdem.toml whose claims are judged. A path outside the current folder is given as a full
    address.
    """
    broken = [(record, finding) for record, finding in contents.findings() if _is_broken(finding)]
    checks = sorted({finding.check for _, finding in broken})
    driver = {
        "name": "refdem",
        "version": contents.campaign.refdem,
        "rules": [_rule(check) for check in checks],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [
            _result(record, finding, checks.index(finding.check), _address(described_in))
            for record, finding in broken
        ],
    }
    document = {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}
    return (json.dumps(document, indent=2) + "\n").encode()


def _is_broken(finding: Finding) -> bool:
    """True if the finding closes a gate."""
    return finding.outcome in BROKEN


def _rule(check: str) -> dict[str, object]:
    """The rule that stands for a check."""
    return {"id": check, "shortDescription": {"text": f"The check {check} of refdem."}}


def _result(record: Record, finding: Finding, rule: int, address: str) -> dict[str, object]:
    """The result of one finding; its fingerprint stays the same from run to run."""
    name = record.id(finding)
    place = {"artifactLocation": {"uri": address}, "region": {"startLine": 1}}
    return {
        "ruleId": finding.check,
        "ruleIndex": rule,
        "level": "error",
        "message": {"text": one_line(f"{name}: {finding.outcome}. {finding.sentence}")},
        "locations": [{"physicalLocation": place}],
        "partialFingerprints": {"finding/v1": hashlib.sha256(name.encode()).hexdigest()},
    }


def _address(path: PurePath) -> str:
    """The address of a file: relative as it is, absolute with its scheme."""
    if path.is_absolute():
        return path.as_uri()
    return quote(path.as_posix())
