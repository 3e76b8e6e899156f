"""Temporary folder of compiled kernels for a user who cannot write to any of numba's.

numba looks for a writable folder in NUMBA_CACHE_DIR, beside the sources, and in the user's cache, and without one does
not even import a kernel. A service's user, or one in a container, often has none: no home, and an installation that
belongs to root.
"""

import os
import shutil
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import tendond

VARIABLE = "NUMBA_CACHE_DIR"
TEMPORARY = "tendond-kernels-"
"""Prefix of the temporary folder's name."""

KERNELS = ("*.nbi", "*.nbc")
NOWHERE = "no writable folder for compiled kernels: set NUMBA_CACHE_DIR to one"


class _Watch:
    """Finder that calls `prepare` when numba is about to be imported: most commands need no kernels."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name == "numba":
            sys.meta_path.remove(self)
            prepare(self._say)


def prepare_for_numba(say: Callable[[str], None]) -> None:
    """Call `prepare` as soon as numba is imported, which looks at its environment then."""
    if "numba" not in sys.modules and not any(isinstance(one, _Watch) for one in sys.meta_path):
        sys.meta_path.insert(0, _Watch(say))


def prepare(say: Callable[[str], None]) -> None:
    """Provide a folder that numba can write to, with the existing kernels.

    Args:
        say: prints a line for people.
    """
    folders = sorted(path.parent for path in (Path(tendond.__file__).parent / "model").rglob("__init__.py"))
    beside = folders[0] / "__pycache__"
    given = os.environ.get(VARIABLE)
    if any(is_writable(folder) for folder in (*([Path(given)] if given else []), beside, _users())):
        return
    folder = _temporary()
    if folder is None:
        return  # a command that needs a kernel says so: see `NOWHERE`
    if not any(folder.iterdir()):
        with suppress(OSError):  # if this fails they are compiled again
            for one in folders:
                _copy(one / "__pycache__", folder / numbas_name(one))
            for one in Path(given).iterdir() if given and Path(given).is_dir() else []:
                _copy(one, folder / one.name)
        say(f"compiled kernels are kept in {folder}: no other folder is writable; set {VARIABLE} to a permanent one")
    os.environ[VARIABLE] = str(folder)


def is_writable(folder: Path) -> bool:
    """Check that a folder can be written to, or created."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def numbas_name(sources: Path) -> str:
    """Return the name that numba gives, in NUMBA_CACHE_DIR, to the folder of a source folder's kernels."""
    import hashlib  # takes a tenth of the time of --help

    return f"{sources.name}_{hashlib.sha1(str(sources).encode()).hexdigest()}"


def _users() -> Path:
    """Return the user's own cache, where numba looks last."""
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "numba"


def _temporary() -> Path | None:
    """Create a folder that later runs find again; private to this user, since it holds machine code."""
    import tempfile  # takes a tenth of the time of --help

    try:
        folder = Path(tempfile.gettempdir()) / f"{TEMPORARY}{os.getuid()}"
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077:
            return folder
        return Path(tempfile.mkdtemp(prefix=TEMPORARY))
    except OSError:
        return None


def _copy(kernels: Path, folder: Path) -> None:
    """Copy the kernels of one folder of sources."""
    for pattern in KERNELS:
        for one in kernels.glob(pattern):
            folder.mkdir(exist_ok=True)
            shutil.copyfile(one, folder / one.name)
