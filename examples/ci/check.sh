#!/usr/bin/env bash
# One trajectory in a job: the table for its summary, an annotation for each failed check, a picture.
#
#     FILE=mine.csv SCENE=reference LIMITS="jellett=1e-9 energy=1e-6" examples/ci/check.sh
#
# DIGITS, UNTIL, COLUMNS (theirs=ours), FRICTION, START, ENGINE (--from), WORLD, AXIS and ALLOW are
# options of `tt-precise check`; LIMITS, COLUMNS and ALLOW may have several entries with blanks between them.
# check.json, summary.md and drift.svg go into OUT, by default here. The exit status is that of the check: 0, 1 failed, 2 unusable.
set -euo pipefail
here=$(dirname "$0")
out=${OUT:-.}
mkdir -p "$out"
rm -f "$out/check.json" "$out/summary.md" "$out/drift.svg"

check=(tt-precise check "${FILE:?a trajectory}" --scene "${SCENE:?a scene}" --json)
check+=(--markdown "$out/summary.md" --plot "$out/drift.svg")
for limit in ${LIMITS:-}; do check+=(--limit "$limit"); done
for column in ${COLUMNS:-}; do check+=(--columns "$column"); done
for name in ${ALLOW:-}; do check+=(--allow "$name"); done
if [[ -n ${ENGINE:-} ]]; then check+=(--from "$ENGINE"); fi
for name in DIGITS UNTIL FRICTION START WORLD AXIS; do
    if [[ -n ${!name:-} ]]; then check+=("--${name,,}" "${!name}"); fi
done

status=0
"${check[@]}" > "$out/check.json" || status=$?

if [[ -s $out/summary.md ]]; then
    cat "$out/summary.md" >> "${GITHUB_STEP_SUMMARY:-/dev/stdout}"
fi
if [[ -s $out/check.json ]]; then
    "${PYTHON:-python3}" "$here/annotations.py" "$out/check.json"
fi
exit "$status"
