"""The audit of defaults: what MuJoCo comes with, what the adapter sets, and why."""

from refdem.core.engine import Default

AUDIT = ()
