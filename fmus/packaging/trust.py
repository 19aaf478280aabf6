"""Who may change what lies in a folder: what is kept between runs is code and runs with the user's rights."""

import os
import stat
from functools import lru_cache
from pathlib import Path


def others_may_write(root: Path, folder: Path | None = None) -> bool:
    """Whether another user than this one and root may change what a cache holds; False on Windows.

    From the file system's root down to the `folder` in the cache, each folder has to belong to one of the two
    and to nobody else to write in. Where one cannot be entered by others, whatever lies below is out of their
    reach; the cache's own rights, at its `root`, count all the same. What does not exist holds nothing.
    """
    if not hasattr(os, "getuid"):
        return False
    try:
        facts = root.stat()
    except OSError:
        return False
    return _found(root, folder or root, facts.st_mode, facts.st_uid, facts.st_ctime_ns)


@lru_cache(maxsize=64)
def _found(root: Path, folder: Path, *_facts: int) -> bool:
    """What `others_may_write` gives; looked for once in a process while the folder is as it is."""
    own, top, place = os.getuid(), Path(os.path.realpath(root)), Path(os.path.realpath(folder))
    closed = False
    for each in (*reversed(place.parents), place):
        try:
            facts = each.stat()
        except OSError:
            return False
        # Where names are sticky, as in /tmp, what is there already is its owner's alone.
        sticky = each != place and each != top and facts.st_mode & stat.S_ISVTX
        shared = _shared(facts, own) and not sticky
        if (shared or facts.st_uid not in (0, own)) and (not closed or each == top):
            return True
        closed = closed or not facts.st_mode & (stat.S_IXGRP | stat.S_IXOTH)
    return False


def _shared(facts: os.stat_result, own: int) -> bool:
    """Whether the rights of a folder let others write; many systems give each user a group of one's own."""
    alone = facts.st_gid == os.getgid() == own
    return bool(facts.st_mode & stat.S_IWOTH) or bool(facts.st_mode & stat.S_IWGRP and not alone)
