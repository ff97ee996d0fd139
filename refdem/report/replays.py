"""Replays of the pages of cases: a script beside each page, which loads when a reader opens it."""

import json
from collections.abc import Iterator

import msgspec

from refdem.core.replay import Replay
from refdem.report.contents import Contents, page
from refdem.report.palette import REFERENCE, engine_colours, styles
from refdem.report.tolerance import rows_of


def files(contents: Contents) -> Iterator[tuple[str, str]]:
    """(file name, text) of every replay of a case in the report.

    It hands over numbers and names; the script of the page writes names as text only.
    """
    references = {sheet.engine for sheet in contents.engines if sheet.is_reference}
    for sheet in contents.cases:
        replay = contents.replays.get(sheet.label)
        if replay is None or not replay.tracks:
            continue
        # Whole numbers become floats, as they are in a replay that was read from its records.
        same = msgspec.convert(msgspec.to_builtins(replay), Replay)
        shown = msgspec.to_builtins(same)
        looks = looks_of(contents, replay)
        for track in shown["tracks"]:
            series = f"{track['engine']} {track['method']}"
            track["colour"], track["shape"] = looks[series]
            track["is_reference"] = track["engine"] in references
            track["is_anchor"] = track["is_reference"] and track["method"] == replay.anchor
        name = page(sheet.label)
        yield f"assets/replay-{name}.js", handed_over("refdemReplay", name, shown)


def looks_of(contents: Contents, replay: Replay) -> dict[str, tuple[str, str]]:
    """Colour and shape of every series (engine and method) of a replay, as in the chart of errors.

    That chart assigns the shapes of an engine in the order of its rows.
    """
    records = [row.record for row in rows_of(contents, replay.label)]
    charted = [(record.engine, record.method) for record in records]
    tracked = [(track.engine, track.method) for track in replay.tracks]
    colours = {engine: REFERENCE for engine, _ in tracked} | engine_colours(contents)
    triples = styles([*charted, *tracked], colours)
    return {series: (colour, shape) for series, colour, shape in triples}


def is_replay(name: str) -> bool:
    """True for the name of a file in assets/ that is the replay of a case."""
    return name.startswith("replay-") and name.endswith(".js")


def handed_over(function: str, name: str, value: object) -> str:
    """The script that calls a function of the page with a name and a value.

    Its text is escaped so that it cannot end the string, or a script element that contains it.
    """
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    for character in ("</", "<!--", "\u2028", "\u2029"):
        text = text.replace(character, f"\\u{ord(character[0]):04x}{character[1:]}")
    return f'{function}("{name}", {text});\n'
