#!/usr/bin/env python3
"""Says which tests were skipped and how to have them run, from the report that ctest --output-junit wrote.

Tests with the same reason share a line. A test gives its reason in a line "skipped: REASON", or behind GoogleTest's "Skipped"; a
test that passed without one of its parts says "skipped in part: REASON", or "NAME ... skipped 'REASON'" as unittest does.
usage: skipped.py REPORT.xml
"""
import re
import sys
import xml.etree.ElementTree as xml

REASON = re.compile(r"^(?:skipped: |.*: Skipped\n)(.*)$", re.MULTILINE)
IN_PART = re.compile(r"^skipped in part: (.*)$|^.* \.\.\. skipped ['\"](.*)['\"]$", re.MULTILINE)

by_reason = {}
for case in xml.parse(sys.argv[1]).iter("testcase"):
    wanted = IN_PART if case.find("skipped") is None else REASON
    for reason in {found[found.lastindex]: None for found in wanted.finditer(case.findtext("system-out", ""))}:
        by_reason.setdefault(reason, []).append(case.get("name"))
if by_reason:
    print("\nSkipped tests, and why:")
    print("\n".join(f"  {', '.join(names)}: {reason}" for reason, names in by_reason.items()))
