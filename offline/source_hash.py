"""The version of the code that results depend on."""

import functools
import hashlib
from pathlib import Path

import tendond


@functools.cache
def source_hash(sources: tuple[str, ...]) -> str:
    """Hash files and folders of the package, 12 hexadecimal digits."""
    root = Path(tendond.__path__[0])
    digest = hashlib.sha256()
    for name in sources:
        folder = root / name
        files = sorted(folder.rglob("*.py")) if folder.is_dir() else sorted(root.glob(name))
        for file in files:
            digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:12]
