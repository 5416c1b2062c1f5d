"""A stand-in for CuPy: arrays that only its own functions take, and kernels that the host runs.

It has what `sampler.device` uses. A program is compiled by g++ with `device_on_host.h`, and a
launch calls a kernel once for every thread of the grid.
"""

import ctypes
import hashlib
import itertools
import sys
from contextlib import contextmanager, nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
import toolchain


@contextmanager
def in_place_of_cupy(folder):
    """Let `import cupy` give this module, whose programs are compiled in a folder."""
    module = sys.modules[__name__]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "cupy", module)
        patch.setattr(RawModule, "folder", folder)
        yield module


class ndarray:  # noqa: N801  (CuPy's name)
    """An array that numpy does not take by mistake."""

    def __init__(self, host):
        self.host = np.asarray(host)

    def __array__(self, *_, **__):
        raise TypeError("Implicit conversion to a NumPy array is not allowed.")

    def __getattr__(self, name):
        if name not in ("dtype", "shape", "size", "ndim", "item"):
            raise AttributeError(name)
        return getattr(self.host, name)

    def __array_function__(self, function, _, arguments, keywords):
        return ndarray(function(*(getattr(x, "host", x) for x in arguments), **keywords))

    def get(self):
        return self.host.copy()

    @property
    def data(self):
        return SimpleNamespace(ptr=self.host.ctypes.data)


def _method(name):
    def method(self, *arguments, **keywords):
        given = [getattr(value, "host", value) for value in arguments]
        result = getattr(self.host, name)(*given, **keywords)
        return result if name in _OF_PYTHON else ndarray(result)

    return method


_OF_PYTHON = ("__len__", "__bool__", "__int__", "__setitem__")
_OF_ARRAYS = ("__and__", "__getitem__", "__gt__", "__lt__", "__ne__", "__or__")
_OF_ARRAYS += ("any", "argmax", "astype", "clip", "reshape")
for _name in (*_OF_PYTHON, *_OF_ARRAYS):
    setattr(ndarray, _name, _method(_name))


def asarray(values):
    return values if isinstance(values, ndarray) else ndarray(np.array(values))


def asnumpy(array):
    return array.get()


def empty(shape, dtype):
    # what a kernel does not write is seen
    return ndarray(np.full(shape, 77, dtype))


def zeros(shape, dtype):
    return ndarray(np.zeros(shape, dtype))


def broadcast_to(array, shape):
    return ndarray(np.broadcast_to(array.host, shape))


def ascontiguousarray(array):
    return ndarray(np.ascontiguousarray(array.host))


class Device(nullcontext):
    """A device of one multiprocessor."""

    id = 0
    attributes = {"MultiProcessorCount": 1}  # noqa: RUF012


def as_argument(value):
    if value is None:
        return ctypes.c_void_p(None)
    if isinstance(value, ndarray):
        assert value.host.flags.c_contiguous
        return ctypes.c_void_p(value.host.ctypes.data)
    if isinstance(value, np.ndarray):  # a structure by value
        assert value.size == 1
        fields = [("b", ctypes.c_byte * value.nbytes)]
        return type("structure", (ctypes.Structure,), {"_fields_": fields}).from_buffer_copy(value)
    return {4: ctypes.c_uint32, 8: ctypes.c_uint64}[value.nbytes](int(value))


class RawModule:
    """A program, compiled when a kernel of it is first asked for."""

    folder = None
    libraries = {}  # noqa: RUF012

    def __init__(self, code, options):
        assert "-fmad=false" in options
        self.code = code
        self.flags = [option for option in options if option.startswith("-D")]

    def get_function(self, name):
        library = self._compiled()
        function = getattr(library, name)
        words = ("gridDim", "blockDim", "blockIdx", "threadIdx")
        dims, blocks, block, thread = (ctypes.c_uint.in_dll(library, word) for word in words)

        def launch(grid, threads, arguments):
            arguments = [as_argument(value) for value in arguments]
            dims.value, blocks.value = *grid, *threads
            for block.value, thread.value in itertools.product(range(*grid), range(*threads)):
                function(*arguments)

        return launch

    def _compiled(self):
        digest = hashlib.sha256(f"{self.code}{self.flags}".encode()).hexdigest()[:16]
        if digest not in self.libraries:
            source = self.folder / f"program-{digest}.cpp"
            source.write_text(self.code)
            flags = ["-fPIC", "-shared", *self.flags]
            program = toolchain.build_on_host(source, source.with_suffix(".so"), flags)
            self.libraries[digest] = ctypes.CDLL(str(program))
        return self.libraries[digest]


cuda = SimpleNamespace(Device=Device, runtime=SimpleNamespace(getDeviceCount=lambda: 1))
