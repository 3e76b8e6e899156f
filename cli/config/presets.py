"""`tendond config presets`: the robots by name."""

import json
from dataclasses import asdict

from tendond.schemas.config.rod.presets import ABOUT


def run_presets(*, as_json: bool) -> None:
    """Print name, robot, source and assumptions of each; see `tendond config presets --help`."""
    if as_json:
        print(json.dumps({name: asdict(about) for name, about in ABOUT.items()}, indent=2))
        return
    width = max(map(len, ABOUT))
    for name, about in ABOUT.items():
        print(f"{name:<{width}}  {about.robot}")
        print(f"{'':<{width}}  source: {about.source}; assumed: {about.assumed}")
    print("\nuse one: tendond config new --like NAME; print one: tendond config show --preset NAME")
