#!/usr/bin/env python3
"""Says which tests were skipped and how to have them run, from the report that ctest --output-junit wrote.

Tests with the same reason share a line. A test gives its reason in a line "skipped: REASON", or behind GoogleTest's "Skipped"; a
test that passed without one of its parts says "skipped in part: REASON".
usage: skipped.py REPORT.xml
"""
import re
import sys
import xml.etree.ElementTree as xml

REASON = re.compile(r"^(?:skipped: |.*: Skipped\n)(.*)$", re.MULTILINE)
IN_PART = re.compile(r"^skipped in part: (.*)$", re.MULTILINE)

by_reason = {}
for case in xml.parse(sys.argv[1]).iter("testcase"):
    wanted = IN_PART if case.find("skipped") is None else REASON
    if reason := wanted.search(case.findtext("system-out", "")):
        by_reason.setdefault(reason[1], []).append(case.get("name"))
if by_reason:
    print("\nSkipped tests, and why:")
    print("\n".join(f"  {', '.join(names)}: {reason}" for reason, names in by_reason.items()))
