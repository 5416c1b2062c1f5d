"""A stand-in for CuPy: arrays that only its own functions take, and kernels that the host runs.

It has what `sampler.device` uses. A program is compiled by g++ with `device_on_host.h`, and a
launch calls a kernel once for every thread of the grid.
"""

import ctypes
import hashlib
import itertools
import sys
from contextlib import contextmanager
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
        self.host = host

    def __array__(self, *_, **__):
        raise TypeError("Implicit conversion to a NumPy array is not allowed.")

    def __getattr__(self, name):
        if name not in ("dtype", "shape", "size", "ndim", "item"):
            raise AttributeError(name)
        return getattr(self.host, name)

    def __len__(self):
        return len(self.host)

    def __getitem__(self, key):
        return ndarray(self.host[key])

    def __lt__(self, other):
        return ndarray(self.host < other)

    def __gt__(self, other):
        return ndarray(self.host > other)

    def __or__(self, other):
        return ndarray(self.host | other.host)

    def __bool__(self):
        return bool(self.host)

    def __int__(self):
        return int(self.host)

    def any(self):
        return ndarray(np.asarray(self.host.any()))

    def argmax(self):
        return ndarray(np.asarray(self.host.argmax()))

    def astype(self, dtype, copy=True):
        return ndarray(self.host.astype(dtype, copy=copy))

    def reshape(self, *shape):
        return ndarray(self.host.reshape(*shape))


def asarray(values):
    return values if isinstance(values, ndarray) else ndarray(np.array(values))


def asnumpy(array):
    return array.host.copy()


def empty(shape, dtype):
    # what a kernel does not write is seen
    return ndarray(np.full(shape, 77, dtype))


def zeros(shape, dtype):
    return ndarray(np.zeros(shape, dtype))


def broadcast_to(array, shape):
    return ndarray(np.broadcast_to(array.host, shape))


def ascontiguousarray(array):
    return ndarray(np.ascontiguousarray(array.host))


class Device:
    """A device of one multiprocessor."""

    id = 0
    attributes = {"MultiProcessorCount": 1}  # noqa: RUF012

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def synchronize(self):
        pass


def as_argument(value):
    """Argument of a kernel, as CuPy passes it."""
    if value is None:
        return ctypes.c_void_p(None)
    if isinstance(value, ndarray):
        assert value.host.flags.c_contiguous
        return ctypes.c_void_p(value.host.ctypes.data)
    if isinstance(value, np.ndarray):  # a structure by value
        kind = type(
            "structure", (ctypes.Structure,), {"_fields_": [("b", ctypes.c_byte * value.nbytes)]}
        )
        return kind.from_buffer_copy(value)
    return {4: ctypes.c_uint32, 8: ctypes.c_uint64}[value.nbytes](int(value))


class RawModule:
    """A program, compiled when a kernel of it is first asked for."""

    folder = None
    libraries = {}  # noqa: RUF012
    launches = []  # noqa: RUF012  (names, blocks and threads)

    def __init__(self, code, options):
        assert "-fmad=false" in options
        self.code = code
        self.flags = [option for option in options if option.startswith("-D")]

    def get_function(self, name):
        library = self._compiled()
        function = getattr(library, name)

        def launch(grid, block, arguments):
            arguments = [as_argument(value) for value in arguments]
            RawModule.launches.append((name, *grid, *block))
            place = {
                word: ctypes.c_uint.in_dll(library, word)
                for word in ("gridDim", "blockDim", "blockIdx", "threadIdx")
            }
            place["gridDim"].value, place["blockDim"].value = *grid, *block
            for k, j in itertools.product(range(*grid), range(*block)):
                place["blockIdx"].value, place["threadIdx"].value = k, j
                function(*arguments)

        return launch

    def _compiled(self):
        digest = hashlib.sha256(f"{self.code}{self.flags}".encode()).hexdigest()[:16]
        if digest in self.libraries:
            return self.libraries[digest]
        source = self.folder / f"program-{digest}.cpp"
        source.write_text(self.code)
        flags = ["-O1", "-fPIC", "-shared", *self.flags]
        program = toolchain.build_on_host(source, source.with_suffix(".so"), flags)
        self.libraries[digest] = ctypes.CDLL(str(program))
        return self.libraries[digest]


def device_count():
    return 1


cuda = SimpleNamespace(Device=Device, runtime=SimpleNamespace(getDeviceCount=device_count))
