"""Whether an FMU keeps the standard's schema and rules."""

import re
import zipfile
from pathlib import Path

_IDENTIFIER = r"[A-Za-z_][A-Za-z_0-9]*(\[[0-9]+(,[0-9]+)*\])?"
_STRUCTURED = rf"{_IDENTIFIER}(\.{_IDENTIFIER})*"
PLAIN_NAME = re.compile(rf"{_STRUCTURED}|der\({_STRUCTURED}(,[0-9]+)?\)")
"""Names of variables that either naming convention allows: all but those in quotation marks."""


def validity_problems(path: Path) -> list[str]:
    """What FMPy's `validate_fmu` finds wrong with an FMU; nothing where it is valid.

    FMPy spends nearly all of its time on a grammar of the variables' names, which is left out where all are
    plain.
    """
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    try:
        description = read_model_description(str(path), validate_model_structure=True)
    except Exception:  # FMPy raises whatever it meets; `validate_fmu` says the same in sentences
        return validate_fmu(str(path))
    with zipfile.ZipFile(path) as archive:
        backslash = any("\\" in file.orig_filename for file in archive.filelist)
    if backslash or not all(PLAIN_NAME.fullmatch(each.name) for each in description.modelVariables):
        return validate_fmu(str(path))
    return []
