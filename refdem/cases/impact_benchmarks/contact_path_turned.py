"""The contact path once more, the whole pair turned in space: the force turns with it."""

from refdem.cases.impact_benchmarks._path import TurnedPath
from refdem.cases.impact_benchmarks.contact_path import NUMBERS

MEMBER = TurnedPath("Prescribed path of a contact, turned", NUMBERS)
