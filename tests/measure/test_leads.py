"""The leads: each integrates the same motion, and its products are counted."""

from dataclasses import replace

import pytest

from tt_precise.measure import leads
from tt_precise.measure.leads import Lead


def test_every_lead_is_one_of_a_kind() -> None:
    every = [(lead.arithmetic, lead.name) for lead in leads.leads()]
    assert len(every) == len(set(every))
    assert [lead.name for lead in leads.leads() if lead.kept].count(leads.TODAY) == 3


@pytest.mark.parametrize(
    "lead",
    [
        Lead("today", ""),
        Lead("spin", "", spin="variable"),
        Lead("jellett", "", spin="jellett"),
        Lead("scaled", "", scale=(0.25, 8.0)),
    ],
    ids=lambda lead: lead.name,
)
def test_leads_integrate_the_same_motion(lead: Lead) -> None:
    """kz at the end, which every frame and scale of these leaves alone."""
    lead = replace(lead, options={"compact_mode": True})
    found = leads.build(lead)
    # kz, cos theta, of the golden data at 8 s
    assert found.run() > 1000
    assert abs(found.adaptive.state[2] - -0.9999713347579279956799832785703276) < 1e-13


def test_eliminating_the_spin_saves_its_three_products() -> None:
    today, without = (
        leads.products(
            leads.build(Lead("", "", spin=spin, options={"compact_mode": True})).adaptive
        )
        for spin in ("", "jellett")
    )
    assert today - without == 3
