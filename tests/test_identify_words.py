"""What an identification says beside its table."""

from types import SimpleNamespace

import pytest

from stickslip.fitted.identify_words import fit_messages


@pytest.mark.parametrize("reduced", [1.0, 1.7])
def test_chi_squared_is_printed_and_a_law_that_does_not_explain_is_sent_to_discover(reduced):
    covered = {"minus": (0.0, 1.0), "plus": (0.0, 1.0)}
    text = " ".join(fit_messages({}, covered, SimpleNamespace(reduced=reduced), "3 windows", {}))
    assert f"chi-squared {reduced:g} per degree of freedom" in text
    assert ("does not explain the readings" in text and "`stickslip discover`" in text) == (reduced > 1.2)
