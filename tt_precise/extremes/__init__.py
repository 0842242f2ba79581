"""Tests of numerical stability at the extremes of parameters, starts and times.

``cases`` has the table of cases, ``judges`` their expectations, ``run`` runs them in processes,
and any scene at its edges.
"""

from tt_precise.extremes.cases import TOPICS, cases
from tt_precise.extremes.judges import EdgeCase
from tt_precise.extremes.run import CaseRecord, Extremes, run_cases

__all__ = ["TOPICS", "CaseRecord", "EdgeCase", "Extremes", "cases", "run_cases"]
