"""Measurements: speed against accuracy, what checks catch, other people's engines.

``problem`` says what is integrated and what is right; ``methods`` are the registered integrators
(in the modules ``*_methods``); ``plan`` says which of them run at which settings; ``timing``,
``compiled_trial`` and ``tradeoff`` measure; ``error_growth`` looks at long runs;
``work_precision`` and ``findings`` read the table. ``settings_table`` makes the table behind
``integrate(digits=...)``, ``estimates`` measures what it delivers, ``faults`` what the conservation
checks catch, ``engines`` runs other people's simulators.
"""
