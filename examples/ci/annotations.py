"""Turn the checks that failed in `tt-precise check --json` into annotations of a workflow run."""

import json
import sys

with open(sys.argv[1], encoding="utf-8") as file:
    result = json.load(file)
for check in result["checks"]:
    if check["verdict"] == "fail":
        when = "" if check["at"] is None else f" at t = {check['at']:.6g} s"
        said = f"{check['value']}{when}, expected {check['sense']} {check['limit']}"
        title = f"{check['name']} of {result['trajectory']}"
        print(f"::error title={title}::{said} {check['reason']}".strip())
