"""The law of a block on a belt that nobody declared, and what is said where another one is likelier."""

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


def with_law(case: Case, tell: Callable[[str], None]) -> tuple[Case, tuple[str, ...]]:
    """
    Return a case with the law that its train runs make likelier, where it declares none, and what is said of that.

    Parameters
    ----------
    case : of a `BlockOnBelt`
    tell : told what is being done
    """
    if case.declared_law is not None:
        return case, ()
    tell("choosing the law, as none is declared")
    law = _falling(case)
    if law is None:
        return case, ()
    words = "no law is declared: one that falls with the speed of slip (hyperbolic) explains the train runs better"
    return replace(case, friction=law, undeclared=()), (f"{words} than a Coulomb law, and is taken",)


def law_to_declare(case: Case, found: Found, tell: Callable[[str], None]) -> tuple[str, ...]:
    """
    Return what is said where a Coulomb law is declared, what was found leaves much, and a law that falls is likelier.

    Parameters
    ----------
    case, found : of a `BlockOnBelt`, and what its search found
    tell : told what is being done
    """
    unexplained = found.residual_after.chi2 > POLICY.noise_left
    if not unexplained or not isinstance(case.declared_law, CoulombFriction):
        return ()
    tell("trying a law that falls with the speed of slip")
    names = tuple(one.name for one in fields(PaperFriction))
    if _falling(replace(case, friction=PaperFriction(), undeclared=names)) is None:
        return ()
    words = "one that falls with the speed of slip explains the train runs better: leave [friction] out, or declare it"
    return (f"the declared law is Coulomb's; {words} (kind = 'hyperbolic'), and search again",)


def _falling(case: Case) -> HyperbolicFriction | None:
    """The law that falls with the speed of slip, where it is likelier than Coulomb's."""
    try:
        law = identify(case).law
    except StickslipError:
        return None
    return law if isinstance(law, HyperbolicFriction) else None
