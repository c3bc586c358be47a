"""What an identification says beside its table."""

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.fitted.identified import Events
from stickslip.fitted.identify_words import event_messages, fit_messages


@pytest.mark.parametrize("reduced", [1.0, 1.7])
def test_chi_squared_is_printed_and_a_law_that_does_not_explain_is_sent_to_discover(reduced):
    covered = {"minus": (0.0, 1.0), "plus": (0.0, 1.0)}
    text = " ".join(fit_messages({}, covered, SimpleNamespace(reduced=reduced), "3 windows", {}))
    assert f"chi-squared {reduced:g} per degree of freedom" in text
    assert ("does not explain the readings" in text and "`stickslip discover`" in text) == (reduced > 1.2)


def test_a_kind_that_both_directions_chose_is_not_said_to_be_what_one_of_them_shows():
    one = np.ones(3)
    events = Events(t=one, static=2 * one, kinetic=one, amplitude=one, rms=1e-3 * one, run=0 * one)
    (said,) = [
        words
        for words in event_messages("hyperbolic", "plus", -7.0, events, " N", None, shared=True)
        if "BIC" in words
    ]
    assert "hyperbolic law, chosen by BIC of both directions together" in said
    assert "(here BIC, Coulomb minus hyperbolic: -7.0)" in said
    assert "falls with speed" not in said
