"""Several macOS libraries, one for each architecture, in one file.

Format: Apple's <mach-o/fat.h> and <mach-o/loader.h>. A table of architectures, big end first, then each
library at a multiple of its page size.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

UNIVERSAL, MACH_O_64 = 0xCAFEBABE, 0xFEEDFACF
_ALIGNMENT = 14
"""Power of two; 16 KiB are a page on aarch64, and a multiple of one on x86_64."""


def universal_binary(libraries: Sequence[bytes]) -> bytes:
    """One file of several thin 64-bit Mach-O libraries.

    Raises
    ------
    ValueError
        If one of them is not a thin 64-bit Mach-O file.
    """
    page = 1 << _ALIGNMENT
    head = struct.pack(">II", UNIVERSAL, len(libraries))
    body = b""
    start = page
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_O_64:
            raise ValueError("not a thin 64-bit Mach-O library")
        head += struct.pack(">IIIII", processor, variant, start, len(library), _ALIGNMENT)
        padded = library + bytes(-len(library) % page)
        body += padded
        start += len(padded)
    return head + bytes(page - len(head)) + body
