"""Contacts that start together, and contacts that are there before the motion begins."""

from refdem.stress.measures.parameters import parameter_sweep
from refdem.stress.scenes.overlap_at_start import CASE as OVERLAP
from refdem.stress.scenes.simultaneous import CASE as SIMULTANEOUS
from refdem.stress.sweep import Battery

BATTERY = Battery(
    id="contacts",
    title="Simultaneous contacts and initial overlap",
    question=(
        "How many contacts may begin at the same instant, and with how small or"
        " deep an overlap may a motion start?"
    ),
    sweeps=(
        parameter_sweep(
            name="hits at once",
            case=SIMULTANEOUS,
            along="spheres",
            points=("2", "3", "4", "5", "6", "8", "12", "24"),
            given=lambda x: {"hits": f"{x}"},
            promised="4",
            basis="contacts that begin within round-off of each other are one event",
        ),
        parameter_sweep(
            name="shallower overlap",
            case=OVERLAP,
            along="overlap [m]",
            points=("1/2", "1e-1", "1e-2", "1e-4", "1e-6", "1e-9", "1e-12", "1e-15"),
            given=lambda x: {"overlap": f"{x}"},
            promised="1e-12",
            basis="an initial overlap is a contact from the start",
        ),
        parameter_sweep(
            name="deeper overlap",
            case=OVERLAP,
            along="overlap [m]",
            points=("1/64", "1/16", "1/4", "1/2", "3/4", "7/8"),
            given=lambda x: {"overlap": f"{x}"},
            promised="1/2",
            basis="the contact force is linear up to the centres",
        ),
    ),
)
