"""What can go wrong, one class per party at fault.

`exit_status` is what the command line returns.
"""

from collections.abc import Mapping

UNREADABLE = (ValueError, RecursionError)
"""What decoders raise: their own errors, those of UTF-8, and what nests too deep."""


class RefdemError(Exception):
    """Base of every error that refdem raises on purpose: says where, what was given, what was
    expected, what to do.
    """

    exit_status = 2


class UsageError(RefdemError):
    """The caller requested something that does not exist or is out of bounds."""


class OutOfRangeError(UsageError, ValueError):
    """A field of a file or an option is well typed and makes no sense.

    As a ValueError it is what msgspec turns into its own error, with the place in the file.
    """


class SceneError(RefdemError):
    """A scene is not physical or not well formed."""


class EngineMissingError(RefdemError):
    """An engine was requested by name and is not installed."""


class StoreError(RefdemError):
    """The store or an output folder cannot be read or written."""


class ClusterError(RefdemError):
    """A cluster does not answer, or its workers are not fit to run what is asked."""


class EngineError(RefdemError):
    """An engine crashed, hung or broke the contract of its adapter."""

    exit_status = 3


class HangError(EngineError):
    """An engine did not end in its time."""


class LeakError(EngineError):
    """An engine's answer depends on what it was asked before."""


class UnsupportedError(RefdemError):
    """An engine cannot express the scene; the message names the missing feature."""


class NotCertifiedError(RefdemError):
    """A truth value cannot be proved; the message says up to where it can.

    Where a motion can be followed no further, `time` [s] is up to when it is certified, `state` has
    the balls there, by name, and `code` says which end it is:

    singular    the motion is proved to be infinite, or not analytic, at a finite time;
    end         the motion itself is over, by its own rules;
    grazing     a switch comes too near zero, and balls cannot tell whether it is met;
    corner      two switches come at one time, or too near to each other;
    separatrix  the start lies on a boundary between kinds of motion, or too near to it;
    vertical    angles are requested where they are undefined; the motion itself continues;
    jump        the requested time is that of an impact, at which velocities have two values; the
                motion itself continues;
    precision   the bits are used up: more of them might go further;
    time        the steps, or the time, that are followed are used up: the motion goes on.
    """

    def __init__(
        self,
        message: str,
        *,
        code: str = "",
        time: float | None = None,
        state: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(message)
        self.code, self.time, self.state = code, time, dict(state or {})
