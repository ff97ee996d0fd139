"""The certified store as CSV, made from its JSON Lines: for people's tables and for programs
without a JSON reader.
"""

import csv
import io
from collections.abc import Iterable

from refdem.truth.certified.reader import CertifiedSet

HEADER = (
    "case",
    "parameters",
    "t",
    "quantity",
    "mid",
    "radius",
    "binary64",
    "method",
    "witness",
    "sha256_of_source",
)


def csv_of(sets: Iterable[CertifiedSet]) -> str:
    """A header and a line a value: parameters as `name=value ...`, t empty where nothing depends on
    time, binary64 as C's %a.
    """
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(HEADER)
    for one in sets:
        parameters = " ".join(f"{name}={text}" for name, text in one.parameters.items())
        for value in one.values:
            if value.binary64 is None:
                sure = ""
            else:
                sure = value.binary64.hex()
            if value.t is None:
                t = ""
            else:
                t = str(value.t)
            rows.writerow(
                (
                    one.case,
                    parameters,
                    t,
                    value.quantity,
                    value.mid,
                    value.radius,
                    sure,
                    one.method,
                    one.witness,
                    one.source,
                )
            )
    return out.getvalue()
