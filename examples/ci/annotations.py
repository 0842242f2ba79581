"""Turn the checks that failed in `tt-precise check --json` into annotations of a workflow run."""

import json
import sys

with open(sys.argv[1], encoding="utf-8") as file:
    result = json.load(file)
for check in result["checks"]:
    if check["verdict"] != "fail":
        continue
    parts = [check["reason"]]
    if check["value"] is not None:
        since = "" if check["since"] is None else f" from t = {check['since']:.6g} s on"
        parts = [
            f"{check['value']:.3g}, expected {check['sense']} {check['limit']:.3g}{since}",
            *parts,
        ]
    parts += [f"cause: {cause['text']}" for cause in result.get("causes", [])]
    title = f"{check['name']} of {result['trajectory']}"
    print(f"::error title={title}::{'; '.join(part for part in parts if part)}")
if result["verdict"] == "incomplete":
    for what in result["unseen"]:
        print(f"::error title={result['trajectory']} is incomplete::could not check {what}")
