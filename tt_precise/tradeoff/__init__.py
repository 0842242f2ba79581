"""Measurements: speed against accuracy, costs of calls, faults that checks detect.

``problem`` says what is integrated and what is right; ``methods`` are the registered integrators
(in the modules ``*_methods``); ``plan`` says which of them run at which settings; ``timing``,
``compiled_trial`` and ``tradeoff`` measure; ``error_growth`` looks at long runs;
``work_precision`` and ``findings`` read the table. ``bars`` has what ``calls`` and whole
``processes`` cost.
``estimates`` measures what it delivers, ``several_doubles`` what it costs, ``faults`` what the
conservation checks catch.
"""
