"""Laws by name: tendond's own, and those of installed packages with an entry point in the group `tendond.laws`."""

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pydantic import TypeAdapter, ValidationError

from tendond.daemon.control.laws import backstepping, mpc, policy, sensitivity, sliding_mode
from tendond.daemon.control.laws.law import Law
from tendond.daemon.errors import LawError, LawPackageError
from tendond.schemas.errors.explain import choose, explain

GROUP = "tendond.laws"
"""Entry points of that group name a law each: `name = "package.module:LAW"`."""

BUILT_IN: tuple[Law, ...] = (backstepping.LAW, sliding_mode.LAW, sensitivity.LAW, mpc.LAW)

TRAINED: Mapping[str, Law] = {policy.LAW.name: policy.LAW}
"""Laws that cannot run without a file of their own: known by name, but not among those that run as they are."""

MEMBERS = ("name", "parameters", "state", "task_space", "start", "decide")
"""Members of the protocol `Law` without which none can run; `convergence` may be missing in an older package."""


class Laws(Mapping[str, Law]):
    """All laws by name; packages are looked for at the first use.

    Raises:
        LawPackageError: a package's law cannot be imported, is not a law, or has the name of another one.
    """

    def __init__(self) -> None:
        self._found: dict[str, Law] = {}

    def __getitem__(self, name: str) -> Law:
        return TRAINED[name] if name in TRAINED else self._all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def register(self, law: Law) -> None:
        """Add a law.

        Raises:
            LawPackageError: another one has its name.
        """
        self._all()
        self._add(self._found, law, "this process")

    def forget(self) -> None:
        """Look for all laws anew at the next use: packages have been installed or removed."""
        self._found = {}

    def _all(self) -> dict[str, Law]:
        if not self._found:
            found = {law.name: law for law in BUILT_IN}
            for entry in entry_points(group=GROUP):
                self._add(found, load(entry), _package(entry))
            self._found = found
        return self._found

    @staticmethod
    def _add(found: dict[str, Law], law: Law, source: str) -> None:
        if law.name in found or law.name in TRAINED:
            raise LawPackageError(
                f"{GROUP}: {source} brings a law '{law.name}', and there is one of that name already: rename one of "
                "them, or uninstall the package"
            )
        found[law.name] = law


LAWS = Laws()


def load(entry: EntryPoint) -> Law:
    """Import the law of an entry point.

    Raises:
        LawPackageError: it cannot be imported, or is not a law.
    """
    where = f"{GROUP}: the law '{entry.name}' of {_package(entry)}"
    remedy = "fix or uninstall the package"
    try:
        law: Law = entry.load()
    except Exception as error:  # whatever a package raises while it is imported
        reason = str(error).splitlines()[0] if str(error) else ""
        raise LawPackageError(
            f"{where} cannot be imported from {entry.value}: {type(error).__name__}: {reason}; {remedy}"
        ) from error
    if missing := [member for member in MEMBERS if not hasattr(law, member)]:
        raise LawPackageError(f"{where} is not a law: {entry.value} has no {', '.join(missing)}; {remedy}")
    if law.name != entry.name:
        raise LawPackageError(f"{where} calls itself '{law.name}' in {entry.value}: give both the same name; {remedy}")
    return law


def _package(entry: EntryPoint) -> str:
    return f"package {entry.dist.name}" if entry.dist is not None else "a package"


def select_law(name: str, tables: Mapping[str, Mapping[str, Any]]) -> tuple[Law, Any]:
    """Return the law of that name and its parameters; every table is checked, not only the selected law's.

    Args:
        name: name of a law.
        tables: `control.laws` of the configuration: parameters by law.

    Raises:
        LawError: no such law, an unknown parameter, or a value out of range.
    """
    parameters, wrong = {}, []
    for key in dict.fromkeys([name, *tables]):
        if key not in LAWS:
            where = "control.law" if key == name else "control.laws"
            wrong.append(f"{where}: no law is called '{key}'; {choose(key, LAWS)}")
            continue
        kind = LAWS[key].parameters
        try:
            parameters[key] = TypeAdapter(kind).validate_python(tables.get(key, {}))
        except ValidationError as error:
            wrong += [f"control.laws.{key}.{line}" for line in explain(error, kind)]
    if wrong:
        raise LawError("\n".join(wrong))
    return LAWS[name], parameters[name]
