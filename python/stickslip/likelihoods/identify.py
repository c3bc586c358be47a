"""From recordings to a friction law, of any rig: `identify`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from stickslip.arguments import explained, must_be
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError
from stickslip.fitted import identify as named
from stickslip.fitted.identified import Identified
from stickslip.fitted.identify import Alone, BeltSpeed, Material, Progress
from stickslip.fitted.shooting import Simulator
from stickslip.likelihoods.bodies_identify import identify_bodies
from stickslip.likelihoods.declared_numbers import known
from stickslip.likelihoods.driven_slider.identify import identify_driven
from stickslip.likelihoods.identified_rig import IdentifiedRig
from stickslip.likelihoods.one_thread import one_thread
from stickslip.likelihoods.scattered import scattered
from stickslip.likelihoods.shared import Declared
from stickslip.measured.case import Case, Recording
from stickslip.simulated.simulate import simulate


@one_thread
@explained
def identify(
    source: Case | Recording | Sequence[Recording],
    *,
    rig: AnyRig | None = None,
    friction: FrictionLaw | Mapping[str, FrictionLaw] | None = None,
    noise: Mapping[str, float] | None = None,
    belt_speed: BeltSpeed = "set-point",
    scatter: bool | None = None,
    simulator: Simulator = simulate,
    progress: Progress | None = None,
) -> Identified | IdentifiedRig:
    """Identify the friction law from recordings.

    Where friction differs from event to event, the law, the declared constants and the scatter are fitted together, by
    their marginal likelihood; the law is that of the mean event, and its intervals know of the scatter. Of a driven
    slider friction, damping and mass are fitted together, in coloured noise of the force.

    Parameters
    ----------
    source : Case, Recording or sequence of Recording
        A case's "train" runs are used. Its [uncertainty] says how well the constants are known that are fitted beside
        the law where friction scatters; those of a `rig` given here are exact.
    rig : of any kind, optional
        Required unless `source` is a case, or of a driven slider, whose recordings have theirs.
    friction : optional
        The law's form and the values to start from; the case's, or Table 1, if absent. For a rig of bodies or matrices
        a law, or a table of laws by name; of a driven slider Coulomb's.
    noise : mapping of str to float, optional
        Standard deviation of a reading per channel in the rig's units; the recording's, or estimated, if absent. A rig
        of bodies or matrices takes that of its recordings.
    belt_speed : "set-point" or "plateau"
        Whether v_b is what was set, or what the block was seen to ride at in its sticks.
    scatter : bool, optional
        Whether friction may differ from event to event. Default: where the readings show it. On a rig of bodies or
        matrices it always may.
    simulator : callable
        `stickslip.simulate` or anything with its signature; with another one nothing scatters.
    progress : callable, optional
        Called with what is being done and the share done.

    Returns
    -------
    Identified, or IdentifiedRig of a rig of bodies or matrices

    Raises
    ------
    InputError
        If a channel is missing, a record too short, or no slip is found; if the channels of a case for the rig of
        (2.1) cannot be what it says, or no law of this kind moves its rig like the readings.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)  # N
    >>> t = np.arange(0, 6, 0.002)
    >>> run = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.01, t_end=6, t_eval=t)
    >>> x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)  # mm
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> recording = ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.01)
    >>> found = ss.identify(recording, rig=rig, friction=law)
    >>> for name, one in found.estimates.items():
    ...     print(f"{name}: {one.value:.3f} N, {one.status}")
    static: 2.000 N, identified
    kinetic: 1.200 N, identified
    """
    if friction is not None:
        must_be("friction", friction, (FrictionLaw, Mapping), "like CoulombFriction(static=4, kinetic=2)")
    own = own_rig(source, rig)
    if not isinstance(own, GeneralRig | DrivenSlider):
        declared = known(source) if isinstance(source, Case) and rig in (None, source.rig) else Declared()

        def with_scatter(material: Material, tell: Progress, alone: Alone | None) -> Identified | None:
            return scattered(material, declared, tell, alone, asked=scatter is True)

        return named.identify(
            source,
            rig=rig,
            friction=friction,  # type: ignore[arg-type]  # it looks
            noise=noise,
            belt_speed=belt_speed,
            scatter=scatter,
            simulator=simulator,
            progress=progress,
            scattering=with_scatter if scatter is not False and simulator is simulate else None,
        )
    for key, given, usual in (
        ("noise", noise, None),
        ("scatter", scatter, None),
        ("simulator", simulator, simulate),
        ("belt_speed", belt_speed, "set-point"),
    ):
        if given is not usual and given != usual:
            kind = "a driven slider" if isinstance(own, DrivenSlider) else "a rig of bodies or matrices"
            raise InputError(f"is for a named rig; leave it out for {kind}", key=key)
    for one in [source] if isinstance(source, Case | Recording) else source:
        must_be("source", one, (Case, Recording), "load_case(path) gives a case")
    if isinstance(own, DrivenSlider):
        for one in () if isinstance(source, Case) else [source] if isinstance(source, Recording) else source:
            must_be("source", one, Recording, "like case.train[0]; a case is given by itself")
        return identify_driven(source, rig=rig, friction=friction, progress=progress)
    return identify_bodies(source, rig=own, friction=friction, progress=progress)


def own_rig(source: object, rig: AnyRig | None) -> AnyRig | None:
    """Return the rig to identify: the given one, that of the readings, and always that of a driven slider's."""
    first = source[0] if isinstance(source, (list, tuple)) and source else source
    own = first.rig if isinstance(first, Case | Recording) else None
    return own if rig is None or isinstance(own, DrivenSlider) else rig
