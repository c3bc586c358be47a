"""The page's widgets and plots, and what happens when one is moved. One visitor, one document of Bokeh's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import Button, CheckboxGroup, ColumnDataSource, Div, Slider, TextInput
from bokeh.plotting import figure

from stickslip.declared.model import Model
from stickslip.declared.scale import Scale
from stickslip.errors import StickslipError
from stickslip.measured.recording import Recording
from stickslip.shown.explore.scene import curves, measured, place, units
from stickslip.shown.plot.curves import LIMIT, MEASURED, SIMULATED, label

STEPS = 200  # of a slider
SUFFIX = ".toml"


def reach(value: float) -> tuple[float, float]:
    """From where to where a slider goes: twice the number about it, or 0 to 1."""
    if value == 0:
        return 0.0, 1.0
    return (0.0, 2 * value) if value > 0 else (2 * value, 0.0)


class Page:
    """The state of one visitor: the model as it is now, and the widgets that show it."""

    def __init__(self, model: Model, belt_speed: float, run: Recording | None, folder: Path) -> None:
        self.start, self.folder, self.asked = model, folder, ""
        self.units = units(model)
        self.sources = {name: ColumnDataSource({"x": [], "y": []}) for name in ("signal", "portrait", "law")}
        size, seen = self.units["belt"].size, place(model)
        reached = 2 * abs(size * belt_speed) or 1.0
        self.speed = Slider(
            title=label(f"{seen.moved_by} speed", self.units["belt"].unit),
            start=-reached, end=reached, step=2 * reached / STEPS, value=size * belt_speed, format="0.[00000]",
        )  # fmt: skip
        self.sliders = {name: _slider(name, value) for name, value in model.parameters.items()}
        self.effects = CheckboxGroup(
            labels=[one.full_name if hasattr(one, "full_name") else one.name for one in model.effects],
            active=[*range(len(model.effects))],
        )
        self.said = Div(text="", styles={"min-height": "1.6em"}, name="said")
        self.name = TextInput(
            title=f"save as, in {folder.name or folder}", value="explored.toml", name="file"
        )
        self.button = Button(label="Save the model", name="save")
        self.plots = self._plots(run)
        for one in (self.speed, *self.sliders.values()):
            one.on_change("value", self._moved)
        self.effects.on_change("active", self._moved)
        self.button.on_click(self.save)
        self.draw()

    def model(self) -> Model:
        """The model as the sliders and switches have it."""
        now = self.start.replace({name: float(one.value) for name, one in self.sliders.items()})
        kept = [one for i, one in enumerate(now.effects) if i in self.effects.active]
        return now.with_effects(kept)

    def _moved(self, attr: str, old: object, new: object) -> None:
        """What Bokeh calls when a widget changes."""
        del attr, old, new
        self.draw()

    def draw(self) -> None:
        """Compute anew; what cannot be computed is said, and the last curves stay."""
        try:
            now = curves(self.model(), float(self.speed.value) / self.units["belt"].size)
        except StickslipError as error:
            self.said.text = _escaped(str(error))
            return
        self.sources["signal"].data = {"x": now.t, "y": now.x1}
        self.sources["portrait"].data = {"x": now.x, "y": now.v}
        self.sources["law"].data = {"x": now.v_w, "y": now.force}
        self.said.text = "The block sticks and slips." if now.sticks else "The block does not stick."

    def save(self) -> None:
        """Write the model into the folder of the command; a file that is there is replaced when asked twice."""
        name = str(self.name.value).strip()
        path = self.folder / name
        if Path(name).name != name or path.suffix != SUFFIX or name == SUFFIX:
            self.said.text = "Give a plain file name that ends in .toml."
            return
        if path.exists() and self.asked != name:
            self.asked = name
            self.said.text = _escaped(f"{name} exists; press once more to replace it.")
            return
        self.asked = ""
        try:
            self.model().save(path)
        except (StickslipError, OSError) as error:
            self.said.text = _escaped(str(error))
            return
        self.said.text = _escaped(f"Saved as {name}.")

    def layout(self) -> Any:
        """Sliders at the left, curves at the right; on a phone one below the other."""
        parts = [self.speed, *self.sliders.values()]
        if self.effects.labels:
            parts += [Div(text="effects that act"), self.effects]
        controls = column(*parts, self.name, self.button, width=300, name="controls")
        shown = column(self.said, *self.plots, sizing_mode="stretch_width", min_width=300)
        return row(controls, shown, sizing_mode="stretch_width", styles={"flex-wrap": "wrap", "gap": "1rem"})

    def _plots(self, run: Recording | None) -> list[Any]:
        u: Mapping[str, Scale] = {str(name): scale for name, scale in self.units.items()}
        known = measured(self.start, run) if run is not None else None
        seen = place(self.start)
        shown = f"{seen.name}, less the drive's way" if seen.drift else seen.name
        out = []
        for name, title, x, y, keys in (
            (
                "portrait",
                "phase portrait, second half of the run",
                (shown, "x1"),
                (f"rate of {seen.name}", "x2"),
                ("x", "v"),
            ),
            (
                "law",
                "friction characteristic",
                ("relative velocity v_w", "belt"),
                ("friction force T", "force"),
                None,
            ),
            ("signal", "signal", ("time", "t"), (shown, "x1"), ("t", "x1")),
        ):
            plot = figure(
                title=title, height=300, sizing_mode="stretch_width", name=name,
                x_axis_label=label(x[0], u[x[1]].unit), y_axis_label=label(y[0], u[y[1]].unit),
                tools="pan,box_zoom,wheel_zoom,reset,hover", active_drag="box_zoom",
            )  # fmt: skip
            if known is not None and keys is not None:
                plot.line(
                    known[keys[0]], known[keys[1]], line_color=MEASURED, line_alpha=0.5, line_width=2.5,
                    legend_label="measured",
                )  # fmt: skip
            colour = LIMIT if name == "law" else SIMULATED
            plot.line("x", "y", source=self.sources[name], line_color=colour, line_width=1.6)
            plot.toolbar.logo = None
            out.append(plot)
        return out


def _slider(name: str, value: float) -> Slider:
    low, high = reach(value)
    return Slider(title=name, start=low, end=high, step=(high - low) / STEPS, value=value, format="0.[00000]")


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
