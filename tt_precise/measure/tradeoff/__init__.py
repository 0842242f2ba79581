"""Speed against accuracy: every method on one problem, timed in turn, judged by golden data.

``problem`` says what is integrated and what is right; ``methods`` are the registered integrators;
``plan`` says which of them run at which settings; ``timing`` and ``table`` measure;
``growth`` looks at long runs; ``curves`` and ``findings`` read the table.
"""
