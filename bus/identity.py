"""Identity of a publisher for one run of its process, which distinguishes it from a second one."""

import secrets


def new_source(kind: str) -> str:
    """Generate a name that no other process has, for instance "vicon-3f9c2a"; `kind` is the kind of process."""
    return f"{kind}-{secrets.token_hex(3)}"
