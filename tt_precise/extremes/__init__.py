"""Cases that test numerical stability at the extremes of parameters, starts and times.

The cases of a topic are functions with ``@case`` in its module; ``case.TOPICS`` lists the topics.
"""

from tt_precise.extremes.case import TOPICS, CaseRecord, ExtremeCase, cases, run_all

__all__ = ["TOPICS", "CaseRecord", "ExtremeCase", "cases", "run_all"]
