"""The two reasons for which an adapter refuses a motion, each with the feature that is missing.

An engine cannot express a feature if its own users could not have it, however they drive the
engine. What they could have and the adapter leaves out is a gap of the adapter, to be closed.
"""

ENGINE_CANNOT = "the engine does not support "
ADAPTER_LACKS = "the adapter does not support yet: "


def engine_cannot(feature: str) -> str:
    """The refusal of a feature that the engine itself does not have."""
    return ENGINE_CANNOT + feature


def adapter_lacks(feature: str) -> str:
    """The refusal of a feature that the engine has and its adapter does not use."""
    return ADAPTER_LACKS + feature
