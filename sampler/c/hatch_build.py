"""Build hook: put the compiled library and the C header into a wheel that serves every Python."""

import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))
import build


class CompiledDraw(BuildHookInterface):
    """Compile the draw before the wheel is put together."""

    def dependencies(self) -> list[str]:
        """Ask for the compiler of PyPI where the machine has none."""
        return [] if build.compiler() else ["ziglang>=0.13"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, add the library and name the platform."""
        build.build()
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
        build_data["artifacts"] += ["/sampler/librebound.so", "/sampler/c/rebound_sampler.h"]
