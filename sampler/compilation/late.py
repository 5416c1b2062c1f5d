"""Public names of a package, imported when they are first used, so that it is imported at once.

Commands import what does their work in their own functions.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    """A package whose public names, and modules, are imported when they are asked for."""

    _homes: dict[str, str]
    _ready: Callable[[], None]

    def __getattr__(self, name: str) -> Any:
        if name in self._homes:
            self._ready()
            value = getattr(import_module(self._homes[name]), name)
        elif name == "__all__":
            # who asks for all names (pdoc, a star import) looks for them in __dict__ next
            value = [*self._homes]
            for public in value:
                getattr(self, public)
        else:
            value = self._module(name)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        # importing tablegen.simulate would bind that module over the function of the same name
        if not (isinstance(value, ModuleType) and name in self.__dict__.get("_homes", ())):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._homes})

    def _module(self, name: str) -> ModuleType:
        path = f"{self.__name__}.{name}"
        if not name.startswith("_"):
            try:
                return import_module(path)
            except ModuleNotFoundError as error:
                if error.name != path:
                    raise
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


def import_late(
    package: str, homes: Mapping[str, Sequence[str]], ready: Callable[[], None] = lambda: None
) -> None:
    """Let a package import its public names when they are first asked for.

    A name stands for what its module calls so, also where the package has a module of that name.

    Parameters
    ----------
    package : str
        Its ``__name__``.
    homes : mapping of str to sequence of str
        Public names by the module that defines them.
    ready : callable
        Called before a name is imported; raises ImportError where that cannot succeed.
    """
    module = sys.modules[package]
    module.__dict__["_homes"] = {name: home for home, names in homes.items() for name in names}
    module.__dict__["_ready"] = ready
    module.__class__ = _Package
