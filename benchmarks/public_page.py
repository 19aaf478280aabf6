"""The page on other people's files: how many run, how close to another tool, and why others do not run."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from benchmarks.public_files import SAME, Seen


def version(package: str) -> str | None:
    """Version of an installed distribution; None where it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


_OTHERS = {
    "same numbers": "the same numbers",
    "same to the FMU's tolerance": "the same to the FMU's tolerance",
    "differs, settled by a third": "differs, settled by a third tool",
    "differs, with a word": "differs, with a remark",
    "DIFFERS WITHOUT A WORD": "differs, without a word",
    "runs here alone": "runs here, not in the other tool",
    "refused with a sentence": "runs in the other tool, refused here",
    "REFUSED WITHOUT A SENTENCE": "refused here without a sentence",
    "refused by both": "runs in neither",
}
"""Headings, by outcomes."""


def _reason(said: str) -> str:
    """Give the sentence for which a file was refused, without what differs from file to file."""
    sentence = next((line for line in reversed(said.splitlines()) if line.startswith("warmlink: ")), said)
    for pattern, reason in _REASONS.items():
        if re.search(pattern, sentence):
            return reason
    return (sentence.partition(": modelDescription.xml: ")[2] or sentence.removeprefix("warmlink: "))[:110]


_REASONS = {
    "holds no library for": "no library for this platform inside",
    "has no component; there is nothing": "a system of no FMUs, which there is nothing to run of",
    r"does not load: \S+: cannot open shared object": "its library needs another that is not installed here",
    "the SSP holds no": "an FMU or file that the SSP names is not in it",
    "offers model exchange of FMI 1": "model exchange of FMI 1.0",
    "offers ScheduledExecution": "scheduled execution alone, which FMPy does not run either",
    "lacks its attribute|not a readable zip|declares the variable": "a file that breaks the standard",
    "does not load": "its library does not load here",
    "resource file|fmi3GetInt32 answered error": "its own resource is not in it",
    "not finite at": "an output is not finite",
}


def files_section(found: Sequence[Seen], root: Path) -> list[str]:
    """Lines on other people's files: counts, differences, and why files run nowhere or here alone."""
    counts = Counter(each.outcome for each in found)
    versions = [f"{name} {version(name)}" for name in ("FMPy", "libcosimpy") if version(name)]
    lines = [
        "",
        "## Other people's files",
        "",
        f"{len(found)} files of public repositories, each run here and by another tool with the same steps: "
        f"FMUs by FMPy, systems by libcosim ({', '.join(versions)}). A difference is the largest one of any "
        "output in any row, as a share of the output's largest value; models for model exchange are "
        "integrated to 1e-10 by both.",
        "",
        "| what came of it | files |",
        "|---|---|",
        *(f"| {told} | {counts[name]} |" for name, told in _OTHERS.items() if counts[name]),
        "",
        "| kind | run here | same numbers | largest difference of these |",
        "|---|---|---|---|",
    ]
    kinds = sorted({re.sub(r"of \d+ FMUs", "of FMUs", each.kind) for each in found if each.kind})
    for kind in kinds:
        of_it = [each for each in found if re.sub(r"of \d+ FMUs", "of FMUs", each.kind) == kind]
        ran = [each for each in of_it if not each.outcome.lower().startswith("refused")]
        same = [each for each in ran if each.outcome == "same numbers"]
        known = [each.difference for each in same if each.difference is not None]
        worst = f"{max(known):.1g}" if len(known) == len(same) and known else f"below {SAME:g}"
        lines.append(f"| {kind} | {len(ran)} of {len(of_it)} | {len(same)} | {worst} |")
    reasons = Counter(_reason(each.said) for each in found if each.outcome.lower().startswith("refused"))
    lines += ["", "| why a file does not run here | files |", "|---|---|"]
    lines += [f"| {reason} | {count} |" for reason, count in reasons.most_common()]
    odd = [each for each in found if each.outcome not in ("same numbers", "refused by both")]
    lines += ["", "| file that is not simply equal | what came of it | more |", "|---|---|---|"]
    for each in odd:
        more = " ".join(each.said.replace("|", "/").split())[:160]
        lines.append(f"| {each.file.relative_to(root)} | {_OTHERS[each.outcome]} | {more} |")
    return lines
