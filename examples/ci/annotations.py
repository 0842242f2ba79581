"""Turn the summary in `tt-precise check --json` into annotations of a workflow run."""

import json
import sys

# the characters with a meaning in a workflow command
ESCAPED = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A", ":": "%3A", ",": "%2C"})

with open(sys.argv[1], encoding="utf-8") as file:
    result = json.load(file)
title, *lines = result["summary"]
level = "notice" if result["verdict"] == "pass" else "error"
for line in lines or [title]:
    print(f"::{level} title={title.translate(ESCAPED)}::{line.replace('%', '%25')}")
