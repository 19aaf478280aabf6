"""CasADi's functions of calls without most of their copies.

CasADi copies what is given to a place of its own, what is found from such a place to where it belongs, and
from one to another where a function that is idle at zero leaves its first arguments as they are. Here what is
only read is read where it lies, a result is put where it belongs, and an idle function exchanges two
pointers.
"""

import re
from itertools import pairwise

from warmlink.fmus.packaging.native.straight_code import number_at, wanted_in_part

_FUNCTION = re.compile(r"^static int (casadi_f\d+)\(.*?^\}\n", re.DOTALL | re.MULTILINE)

_IDLE = re.compile(
    r"^/\* \w+:\((?P<given>\S*)\)->\((?P<taken>\S*)\) \*/\n"
    r"static int (?P<name>casadi_f\d+)\(.*\) \{\n"
    r"  if \(arg\[0\] \? casadi_to_int\(\*arg\[0\]\) : 0\) \{\n"
    r"    if \((?P<run>casadi_f\d+)\(arg\+1, res, iw, w, 0\)\) return 1;\n"
    r"  \} else \{\n"
    r"    if \((?P<skip>casadi_f\d+)\(arg\+1, res, iw, w, 0\)\) return 1;\n"
    r"  \}\n  return 0;\n\}\n\n?",
    re.MULTILINE,
)
"""A function that runs where its first argument says so."""

_SKIP = r"/\* \w+_skip:\(\S*\)->\(\S*\) \*/\nstatic int {}\(.*?^\}}\n\n?"
"""What runs otherwise and returns its first arguments."""

_CALL = re.compile(
    r"((?:  arg1\[\d+\]=.*;\n)+)((?:  res1\[\d+\]=.*;\n)+)"
    r"  if \((casadi_f\d+)\(arg1, res1, iw, w, 0\)\) return 1;\n"
)


def without_copies(text: str) -> str:
    """CasADi's C with fewer copies."""
    idle = {}
    in_part = wanted_in_part(text)
    for found in _IDLE.finditer(text):
        skip = re.search(_SKIP.format(found["skip"]), text, re.DOTALL | re.MULTILINE)
        if skip:
            idle[found["name"]] = found["run"], [_size(each) for each in found["taken"].split(",")]
            text = text.replace(found[0], "").replace(skip[0], "")
            if found["name"] in in_part:
                in_part.add(found["run"])

    def copying_less(found: re.Match[str]) -> str:
        function = _read_in_place(found[0])
        if found[1] not in in_part:  # else a result may have no place where it could be put at once
            function = _found_in_place(function)
        return _exchanging(function, idle)

    return _FUNCTION.sub(copying_less, text)


def _size(described: str) -> int:
    """How many numbers an argument or result holds, as `o1[90]` or `o2` describe it."""
    return int(described.partition("[")[2].rstrip("]") or 1)


def _read_in_place(function: str) -> str:
    """A function that hands on what it is given, rather than a copy."""
    for given, place in re.findall(r"^  casadi_copy\((arg\[\d+\]), \d+, (w\d+)\);\n", function, re.MULTILINE):
        copy = re.compile(rf"^  casadi_copy\({re.escape(given)}, \d+, {place}\);\n", re.MULTILINE)
        read = re.compile(rf"^(  arg1\[\d+\]=|  w\d+ = casadi_dot\(\d+, ){place}(?=[;,])", re.MULTILINE)
        if len(read.findall(function)) == len(re.findall(rf"\b{place}\b", function)) - 2:
            function = read.sub(rf"\g<1>{given}", copy.sub("", function))
    return function


def _found_in_place(function: str) -> str:
    """A function whose calls put what is found where it belongs."""
    lines = function.splitlines(keepends=True)
    for k, line in enumerate(lines):
        copy = re.match(r"  (?:if \(res\[0\]\) )?casadi_copy\((w\d+), \d+, (res\[\d+\](?:\+\d+)?)\);\n", line)
        if not copy:
            continue
        place, target = copy.groups()
        first = next((i for i in range(k, -1, -1) if _writes(lines[i], place)), None)
        if first is None or not re.match(r"  res1\[", lines[first]):
            continue
        last = next((i for i in range(k, len(lines)) if _writes(lines[i], place)), len(lines))
        used = [i for i in range(first, last) if i != k and re.search(rf"\b{place}\b", lines[i])]
        if all(re.match(rf"  (?:arg|res)1\[\d+\]={place};\n", lines[i]) for i in used):
            for i in used:
                lines[i] = lines[i].replace(f"={place};", f"={target};")
            lines[k] = ""
    return "".join(lines)


def _writes(line: str, place: str) -> bool:
    """Whether a line writes a whole vector anew."""
    return bool(re.match(rf"  (?:res1\[\d+\]={place};|rr={place};|casadi_clear\({place}, )", line))


def _exchanging(function: str, idle: dict[str, tuple[str, list[int]]]) -> str:
    """A function that exchanges pointers where an idle function leaves vectors as they are."""
    starts = {name: int(start) for name, start in re.findall(r"\*(w\d+)=w\+(\d+)", function)}
    order = sorted(starts, key=lambda name: starts[name])
    room = {name: starts[after] - starts[name] for name, after in pairwise(order)}

    def left(given: str, taken: str, size: int, once: bool, rest: str) -> str:
        """C that leaves a result as it was given, before the rest of the function.

        Only a vector that was given `once`, not for other results too, can be exchanged.
        """
        if taken == "0":
            return ""
        if size == 1:
            return f"    {number_at(taken)}={number_at(given)};\n"
        later = next(
            (line for line in rest.splitlines(keepends=True) if re.search(rf"\b{given}\b", line)), ""
        )
        aliased = re.search(rf"^  wr\d+ ?= ?{given}\b", function, re.MULTILINE)
        done_with = once and (not later or _writes(later, given))
        if aliased or not done_with or given not in room or room[given] != room.get(taken):
            return f"    casadi_copy({given}, {size}, {taken});\n"
        return f"    {{ casadi_real *other={given}; {given}={taken}; {taken}=other; }}\n"

    def called(found: re.Match[str]) -> str:
        if found[3] not in idle:
            return found[0]
        run, sizes = idle[found[3]]
        given, taken = (re.findall(r"=(.*);", part) for part in found.groups()[:2])
        rest = function[found.end() :]
        kept = given[1 : len(sizes) + 1]
        moves = [
            left(vector, place, size, kept.count(vector) == 1, rest)
            for vector, place, size in zip(kept, taken, sizes, strict=True)
        ]
        return (
            f"  if ({number_at(given[0])} != 0) {{\n{found[1]}{found[2]}"
            f"    if ({run}(arg1+1, res1, iw, w, 0)) return 1;\n  }} else {{\n{''.join(moves)}  }}\n"
        )

    return _CALL.sub(called, function)
