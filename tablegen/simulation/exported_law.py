"""Direct simulation as an object file, for programs in C, C++ and Fortran.

The object has the machine code of the kernel `simulate_rows`, the arrays of a law, and the record
``rebound_direct`` of the C header, all from LLVM. It needs libc and libm, and neither Python nor
numba. Its bits are those of `tablegen.DirectModel`.
"""

import ctypes
import re
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numba
import numpy as np
from llvmlite import ir
from numpy.typing import NDArray

from sampler.errors import InputError
from tablegen.model.jit import c_function_text
from tablegen.model.particle_run import simulate_rows
from tablegen.simulation.direct_law import SIGNATURE, DirectParts, LawRecord

#: Names of the two files, and of the record that the object has.
OBJECT, HEADER, RECORD = "rebound_direct.o", "rebound_direct.h", "rebound_direct"

_SIMULATE = f"{RECORD}_simulate"

#: Processor of another machine, by its architecture: kernels need fused multiplication and
#: addition, which not every x86-64 has. Elsewhere every processor has what they need.
_PROCESSORS = {"x86_64": "x86-64-v3"}

_BYTE, _WORD = ir.IntType(8), ir.IntType(64)
_POINTER = _BYTE.as_pointer()


class Target(NamedTuple):
    """A machine: its triple as of compilers, its processor, and features of the processor."""

    triple: str
    processor: str
    features: str

    @classmethod
    def of_this_machine(cls) -> "Target":
        """Describe this machine as numba compiles for it."""
        settings: Any = numba.config
        processor = settings.CPU_NAME or llvm.get_host_cpu_name()
        features = settings.CPU_FEATURES
        if features is None:
            features = llvm.get_host_cpu_features().flatten()
        return cls(llvm.get_process_triple(), processor, features)

    @classmethod
    def of_triple(cls, triple: str) -> "Target":
        """Describe another machine by its triple, such as aarch64-linux-gnu.

        Raises `InputError` for a triple that LLVM does not know.
        """
        _llvm_target(triple)
        return cls(triple, _PROCESSORS.get(triple.partition("-")[0], ""), "")

    def machine(self) -> llvm.TargetMachine:
        """Make the code generator."""
        target = _llvm_target(self.triple)
        settings = {"cpu": self.processor, "features": self.features, "opt": 3}
        return target.create_target_machine(**settings, reloc="pic", codemodel="default")

    def __str__(self) -> str:
        return f"{self.triple} ({self.processor})" if self.processor else self.triple


def _llvm_target(triple: str) -> llvm.Target:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    try:
        return llvm.Target.from_triple(triple)
    except RuntimeError as error:
        allowed = "a triple such as aarch64-linux-gnu or x86_64-linux-gnu"
        raise InputError("--target", repr(triple), allowed) from error


def direct_files(parts: DirectParts, target: Target) -> dict[str, bytes]:
    """Make the contents of the object and of its header, by their names."""
    header = _header_text(parts.pair, target).encode()
    return {OBJECT: _object_code(parts, target), HEADER: header}


def _header_text(pair: str, target: Target) -> str:
    """Write the header that declares the record."""
    return f"""\
/* {HEADER} - direct simulation of {pair}, for rbt_use_direct.

   {OBJECT} was compiled for {target}. Link it with a program that includes rebound_sampler.h, and
   say, after rbt_open:

       code = rbt_use_direct(table, &{RECORD});

   Written by `tablegen export-direct`; part of rebound-tables, MIT licence. */

#ifndef REBOUND_DIRECT_H
#define REBOUND_DIRECT_H

#include "rebound_sampler.h"

#ifdef __cplusplus
extern "C" {{
#endif

extern const rbt_direct_law {RECORD};

#ifdef __cplusplus
}}
#endif

#endif
"""


def _object_code(parts: DirectParts, target: Target) -> bytes:
    """Compile the kernel and the record of a law to an object file."""
    machine = target.machine()
    text = c_function_text(simulate_rows, SIGNATURE)
    layout, triple = machine.target_data, target.triple
    text = re.sub(r"^target triple = .*$", f'target triple = "{triple}"', text, flags=re.M)
    text = re.sub(r"^target datalayout = .*$", f'target datalayout = "{layout}"', text, flags=re.M)
    module = llvm.parse_assembly(text)
    kernel = next(f.name for f in module.functions if simulate_rows.__name__ in f.name)
    module.link_in(llvm.parse_assembly(_record_text(parts, kernel, str(layout), triple)))
    for value in [*module.functions, *module.global_variables]:
        if value.name != RECORD and not value.is_declaration:
            value.linkage = llvm.Linkage.internal
    module.verify()
    return bytes(machine.emit_object(module))


def _record_text(parts: DirectParts, kernel: str, layout: str, triple: str) -> str:
    """Write the record, its arrays, and a function of C around the kernel, in LLVM."""
    module = ir.Module(RECORD)
    module.triple, module.data_layout = triple, layout
    values: dict[str, Any] = dict(parts.numbers) | {"simulate": _c_function(module, kernel)}
    values["pair"] = _constant(module, "pair", np.frombuffer(parts.pair.encode() + b"\0", np.uint8))
    for name, array in parts.arrays.items():
        values[name] = _constant(module, name, array)
    record = _record_constant(LawRecord, values, "")
    variable = ir.GlobalVariable(module, record.type, RECORD)
    variable.initializer, variable.global_constant, variable.align = record, True, 8
    return str(module)


def _c_function(module: ir.Module, kernel: str) -> Any:
    """Write a function that calls the kernel as numba does, with places for results and errors.

    A kernel without allocations and exceptions gives no error.
    """
    kinds = [_llvm_type(kind) for kind in SIGNATURE.args]
    native = ir.FunctionType(ir.IntType(32), [_POINTER, _POINTER, *kinds])
    callee = ir.Function(module, native, kernel)
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), _SIMULATE)
    builder = ir.IRBuilder(function.append_basic_block())
    places = [builder.alloca(_WORD) for _ in range(2)]
    places = [builder.bitcast(place, _POINTER) for place in places]
    builder.call(callee, [*places, *function.args])
    builder.ret_void()
    return function


def _llvm_type(kind: Any) -> Any:
    """Give the type in LLVM of an argument of the kernel: an address, or an integer."""
    return ir.IntType(kind.bitwidth) if hasattr(kind, "bitwidth") else _POINTER


def _constant(module: ir.Module, name: str, array: NDArray[Any]) -> Any:
    """Store the numbers of an array in the module."""
    kinds = {"f8": ir.DoubleType(), "i8": _WORD, "i4": ir.IntType(32), "u1": _BYTE}
    flat = np.ascontiguousarray(array).ravel()
    # an array without numbers has an address too
    flat = flat if flat.size else np.zeros(1, flat.dtype)
    kind = ir.ArrayType(kinds[flat.dtype.str[1:]], flat.size)
    variable = ir.GlobalVariable(module, kind, f"{RECORD}.{name}")
    variable.initializer, variable.global_constant = kind(flat.tolist()), True
    variable.linkage, variable.align = "internal", 64
    return variable


def _record_constant(record: type[ctypes.Structure], values: dict[str, Any], prefix: str) -> Any:
    """Make the constant of a record from its fields in their order."""
    fields = []
    for name, kind in record._fields_:  # type: ignore[misc]
        if isinstance(kind, type) and issubclass(kind, ctypes.Structure):
            fields.append(_record_constant(kind, values, f"{prefix}{name}."))
            continue
        value = values[prefix + name]
        if isinstance(value, list):
            fields.append(ir.ArrayType(ir.DoubleType(), len(value))(value))
        elif isinstance(value, ir.Value):
            fields.append(value.bitcast(_POINTER))
        elif kind is ctypes.c_double:
            fields.append(ir.DoubleType()(value))
        else:
            fields.append(ir.IntType(8 * ctypes.sizeof(kind))(value))
    return ir.Constant.literal_struct(fields)
