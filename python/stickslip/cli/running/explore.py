"""What is done by `stickslip explore`: a model with sliders, in the browser."""

from __future__ import annotations

from pathlib import Path

from stickslip.cli.printed import console, say_written
from stickslip.declared.formula.dimension import dimensions
from stickslip.declared.model import Model, load_model, model_file
from stickslip.declared.quantity import quantity
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import read_quantity, scales
from stickslip.errors import InputError
from stickslip.files import chosen
from stickslip.measured.case import Case, load_case
from stickslip.measured.recording import Recording

SCREEN = (1440, 1200)  # pixels of a screenshot


def perform(
    model: Path, belt_speed: str | None, name: str | None, port: int, screenshot: Path | None, force: bool
) -> None:
    """Do what `stickslip explore` is asked for."""
    shown, run = _opened(model, name)
    from stickslip.shown.explore.scene import curves, refuse  # bokeh is slow to import

    refuse(shown)
    speed = _speed(shown, run, belt_speed)
    curves(shown, speed)  # what cannot be drawn is said here, in one line
    from stickslip.shown.explore.page import Page
    from stickslip.shown.explore.server import serve

    if screenshot is not None:
        from stickslip.shown.explore.screenshot import take

        with chosen([screenshot], {"MODEL": model}, force=force, key="--screenshot"):
            take(Page(shown, speed, run, Path.cwd()).layout(), "stickslip explore", screenshot, SCREEN)
        say_written([screenshot])
        return

    def made(document: object) -> None:
        document.add_root(Page(shown, speed, run, Path.cwd()).layout())  # type: ignore[attr-defined]
        document.title = "stickslip explore"  # type: ignore[attr-defined]

    server, address = serve(made, port)
    console.print(
        f"Open {address} in a browser of this machine; Ctrl-C ends it.", soft_wrap=True, markup=False
    )
    try:
        server.io_loop.start()
    except KeyboardInterrupt:
        console.print("ended")
    finally:
        server.stop()


def _opened(path: Path, name: str | None) -> tuple[Model, Recording | None]:
    """A model, or what a case declares with one of its runs."""
    file = path / "rig.toml" if path.is_dir() and (path / "rig.toml").is_file() else path
    if file.name != "rig.toml":
        if name is not None:
            raise InputError("a model has no runs; give a case's rig.toml", key="--run", value=name)
        return load_model(model_file(path)), None
    case = load_case(file)
    return Model(case.rig, friction=case.friction, channels=case.channels), _run(case, name)


def _run(case: Case, name: str | None) -> Recording:
    names = [one.name for one in case.runs]
    if name is None:
        return case.runs[0]
    if name not in names:
        raise InputError(f"not a run of the case; its runs are {', '.join(names)}", key="--run", value=name)
    return case.runs[names.index(name)]


def _speed(model: Model, run: Recording | None, given: str | None) -> float:
    if given is not None and isinstance(model.rig, GeneralRig):
        return _general_speed(model, given)
    if given is not None:
        return read_quantity(
            given, "belt", scales(model.rig, model.channels)["belt"], model.rig, "--belt-speed"
        )
    if run is None:
        raise InputError("missing: give the belt's speed to begin with, like '14 mm/s'", key="--belt-speed")
    return run.belt_speed


def _general_speed(model: Model, given: str) -> float:
    """The speed of the belt or the drive of a rig of bodies, in SI."""
    from stickslip.shown.explore.scene import units

    needed = units(model)["belt"].unit
    size, unit = quantity("--belt-speed", given)
    if unit is not None and dimensions(unit) != dimensions(needed):
        raise InputError(f"must be in a unit like {needed}", key="--belt-speed", value=given)
    return size
