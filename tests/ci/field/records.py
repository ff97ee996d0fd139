"""Records of a code's gate as the tests of the field need them."""

from refdem.core.finding import Finding, Level, Record


def record(
    *findings: Finding, engine: str = "ode", label: str = "pendulum", method: str = "m"
) -> Record:
    """A record of one method."""
    return Record(
        case=label.partition("[")[0],
        label=label,
        parameters={},
        engine=engine,
        version="1",
        method=method,
        is_reference=False,
        runs=(),
        findings=findings,
    )


def errors(quantity: str, *pairs: tuple[float, float]) -> Finding:
    """A finding of check `error` on levels, each half the step, of these errors and seconds."""
    levels = tuple(
        Level(level=0.5**n, error=error, bound=1.0, seconds=seconds, counts=True)
        for n, (error, seconds) in enumerate(pairs)
    )
    return Finding(
        check="error",
        quantity=quantity,
        outcome="pass",
        sentence="",
        levels=levels,
        order_claimed=1.0,
    )
