"""The gain of a load cell that is wrong: told, corrected in forecasts, and no effect of a model, which has no such."""

import numpy as np

import stickslip as ss
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig import outcome
from stickslip.discovery.general_rig.bench import bench_of
from stickslip.discovery.laboratory.constants import freed
from stickslip.discovery.laboratory.search import with_freed
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.fit import null

BLOCK = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0)},
    link=[ss.Link(between=("block", "ground"), stiffness=40.0, damping=0.3)],
    contact=[ss.Contact(body="block", against="belt")],
)
MODEL = ss.Model(BLOCK, friction=ss.CoulombFriction(static=5.0, kinetic=3.0))


def test_it_is_told_and_corrected() -> None:
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng(0)
    run = ss.simulate(MODEL, belt_speed=0.1, initial=(0.0, 0.0), t_end=t[-1], t_eval=t)
    columns = {
        "t": t,
        "block": run.block + 1e-4 * rng.normal(size=len(t)),
        "v_block": run.state[:, 1] + 1e-3 * rng.normal(size=len(t)),
        "T_block": 0.94 * run.contact_force() + 0.01 * rng.normal(size=len(t)),
    }
    known = Uncertainty.usual(BLOCK, channels=("block", "v_block", "T_block"))
    bench = bench_of(MODEL, [ss.load_recording(columns, BLOCK, belt_speed=0.1)], known)
    alone = Trial((), null(bench.windows(), bench.policy))
    (wrong,) = [one for one in freed(bench, alone.fit, known) if one.name == "T_block"]
    told = with_freed(bench, known, alone, wrong)
    assert told.freed is not None
    assert abs(told.freed.off + 0.06) < 0.01
    made = outcome.model(bench, told, MODEL)
    assert made.effects == ()
    assert abs(outcome.sensors(bench, told)["gain.T_block"] + 0.06) < 0.01
