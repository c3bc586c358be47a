"""What is said where a law that falls with the speed of slip is likelier than Coulomb's, and much is left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.discovery.result import Found
from stickslip.errors import StickslipError
from stickslip.likelihoods.identify import identify
from stickslip.likelihoods.policy import POLICY
from stickslip.measured.case import Case


def law_to_declare(case: Case, found: Found, tell: Callable[[str], None]) -> tuple[str, ...]:
    """
    Return what is said where the law is Coulomb's, what was found leaves much, and a law that falls is likelier.

    It is not taken by itself: beside an effect that is lacking the likelier law is no better than that effect's name.

    Parameters
    ----------
    case, found : of a `BlockOnBelt`, and what its search found
    tell : told what is being done
    """
    unexplained = found.residual_after.chi2 > POLICY.noise_left
    law = case.declared_law
    if not unexplained or not (law is None or isinstance(law, CoulombFriction)):
        return ()
    tell("trying a law that falls with the speed of slip")
    names = tuple(one.name for one in fields(PaperFriction))
    if _falling(replace(case, friction=PaperFriction(), undeclared=names)) is None:
        return ()
    words = (
        "the search took a Coulomb law; one that falls with the speed of slip explains the train runs better"
    )
    return (
        f"{words}: declare it (kind = 'hyperbolic', with the numbers that identify gives), and search again",
    )


def _falling(case: Case) -> HyperbolicFriction | None:
    """The law that falls with the speed of slip, where it is likelier than Coulomb's."""
    try:
        law = identify(case).law
    except StickslipError:
        return None
    return law if isinstance(law, HyperbolicFriction) else None
