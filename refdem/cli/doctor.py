"""refdem doctor: what is here, what is missing, and what to do about it."""

import platform
import sys

import typer


def command() -> None:
    """Checks kernels, engines, store and Python.

    Reports what is missing and how to install or repair it.

    Example: refdem doctor
    """
    import refdem
    from refdem import kernels
    from refdem.core import discovery
    from refdem.core.store import Store, default_path
    from refdem.errors import RefdemError
    from refdem.planning.specification import validation_folder

    healthy = True
    print(
        f"refdem {refdem.__version__}, Python {sys.version.split()[0]} on {platform.system()}"
        f" {platform.machine()}"
    )
    try:
        families = sorted(path.name.split(".")[0][1:] for path in kernels.folder().glob("_*.so"))
        built = [family for family in families if kernels.fingerprint(family)]
        print(f"kernels: {', '.join(built) or 'none: run `make develop`'}")
        store = Store(default_path())
        healthy = store.is_usable
        store.close()
        if healthy:
            print(f"store: {default_path()}")
        else:
            print(f"store: {default_path()} cannot be used: every run is made anew")
    except RefdemError as error:
        healthy = False
        print(f"PROBLEM: {error}")
    campaigns = sorted(path.stem for path in (validation_folder() / "campaigns").glob("*.toml"))
    print(f"campaigns: {', '.join(campaigns)}")
    for name in discovery.names("engines"):
        engine = discovery.engine(name)
        missing = engine.missing()
        if missing is None:
            state = engine.version()
        else:
            state = f"not installed; {missing}"
        print(f"engine {name}: {state}")
    if healthy:
        status = 0
    else:
        status = 2
    raise typer.Exit(status)
