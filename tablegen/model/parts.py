"""Compile functions as parts of the kernels that call them: optional, and faster to compile.

Nobody needs this file to change the physics.

By its public means numba optimises each function together with all that it calls, turns it into
machine code, and wraps it for Python. A part is only translated; it is optimised once, with the
kernel that Python calls. `tablegen compile` then takes two thirds of the processor time.

That needs names that are not public. In numba 0.60 to 0.68, with llvmlite 0.43 to 0.50, they are:

- `JITCodeLibrary` with ``_linking_libraries``, ``_final_module``, ``_finalized`` and
  ``_get_module_for_linking``, and llvmlite's `link_in`;
- `CompilerBase`, `DefaultPassBuilder`, `NativeLowering`, the names of `_UNNEEDED`, and ``state``
  with its flag ``no_compile``, ``targetctx``, ``func_id`` and ``cr``;
- ``get_call_template`` and ``get_overload``, which numba asks of a kernel that another one calls,
  and `infer_global`, which makes a function known to kernels.

With another version of numba, or if a name is missing, this file raises ImportError. Then
`tablegen.model.jit` uses the public means: kernels take longer to compile and have the same bits.
To allow a newer version of numba, name it in `_TESTED` and run `.ci/newest`.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.typing.templates import infer_global

#: Oldest and newest version of numba with which this was tested.
_TESTED = (0, 60), (0, 68)

if not _TESTED[0] <= numba.version_info.short <= _TESTED[1]:
    raise ImportError(f"tested with numba {_TESTED}, and not with {numba.__version__}")

#: Passes of numba that kernels do not need: they have no closures and no arithmetic on arrays.
_UNNEEDED = {"inline_closure_likes", "inline_overloads", "nopython_rewrites", "dead_branch_prune"}


class _PartLibrary(JITCodeLibrary):
    """Code of a part and of its own parts, before any optimisation."""

    def finalize(self) -> None:
        """Link in the parts that this one calls."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _PartLowering(NativeLowering):
    """Write the code of a part, and register it for its callers."""

    _name = "part_lowering"

    def run_pass(self, state: Any) -> bool:
        """Run the pass."""
        state.library = _PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        entry = object().__reduce__  # never called; numba needs a different builtin for each part
        state.targetctx.insert_user_function(entry, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=entry)
        return True


class _PartCompiler(CompilerBase):
    """Compiler of parts."""

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes without those that kernels do not need, and with our last one."""
        self.state.flags.no_compile = True
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        pipeline.passes = [
            (_PartLowering if compiler_pass is NativeLowering else compiler_pass, text)
            for compiler_pass, text in pipeline.passes
            if compiler_pass.name() not in _UNNEEDED
        ]
        pipeline.finalize()
        return [pipeline]


#: Parts, kept alive here because numba only refers to them.
_REGISTERED: list[Any] = []


def _part(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    unwrapped = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return numba.njit(**options | unwrapped, pipeline_class=_PartCompiler)(function)


def let_kernels_call(compiled: Any, options: dict[str, Any]) -> None:
    """Make a compiled function a part of the kernels that call it."""
    part = _part(compiled.py_func, options)
    compiled.get_call_template, compiled.get_overload = part.get_call_template, part.get_overload


def register_part(function: Callable[..., Any], options: dict[str, Any]) -> None:
    """Make a function that Python calls interpreted a part of the kernels that call it."""
    part = _part(function, options)
    infer_global(function, types.Dispatcher(part))
    _REGISTERED.append(part)
