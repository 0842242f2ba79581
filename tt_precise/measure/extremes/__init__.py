"""Numerical stability at the extremes: everything driven to its edges, a case at a time.

A topic is a module of this folder (or a folder in it); its cases are functions with ``@case``.
"""

from tt_precise.measure.extremes.case import TOPICS, Case, Finding, Outcome, cases
from tt_precise.measure.extremes.run import run_all

__all__ = ["TOPICS", "Case", "Finding", "Outcome", "cases", "run_all"]
