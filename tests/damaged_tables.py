"""Damaged table files, and a process that reads them one by one under a watch.

`mutated` changes some bytes of a file; the same seed gives the same file. `read_damaged` has such
files read by a process of its own, so that one that hangs, crashes or takes all memory is one
`Outcome` and neither ends nor delays who asked for it:

    for outcome in read_damaged(["full.h5"], range(1000)):
        assert outcome.kind in ACCEPTABLE, outcome

`python tests/damaged_tables.py FIRST END FILE...` is that process, unless another is given. Seed s
damages file s modulo their number.
"""

import math
import os
import resource
import select
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

#: What may become of a damaged table: refused in one line, or read with all that it held.
ACCEPTABLE = ("refused", "same")

#: Memory by which reading one damaged table may make the process grow, bytes.
MOST_MEMORY = 256 * 2**20

#: Seconds that the process may take to start.
STARTING = 60.0

#: Numbers that lengths, addresses and counts are replaced by.
_ODD = (0, 1, 7, 8, 16, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 16, 2**64 - 1)


@dataclass(frozen=True)
class Outcome:
    """What became of one damaged table.

    ``kind`` is "refused" (in one line, which is ``detail``), "same" (read, with the checksum of
    the whole one), or what must not be: "other" (read with another checksum), "raised" (anything
    but a refusal in one line), "large" (memory), "hung" and "died".
    """

    seed: int
    kind: str
    detail: str
    seconds: float


def _flip(data: bytearray, at: int, rng: np.random.Generator) -> None:
    data[at] ^= 1 << int(rng.integers(8))


def _random_byte(data: bytearray, at: int, rng: np.random.Generator) -> None:
    data[at] = int(rng.integers(256))


def _odd_number(data: bytearray, at: int, rng: np.random.Generator) -> None:
    size = int(rng.choice([1, 2, 4, 8]))
    at -= at % size
    number = int(_ODD[rng.integers(len(_ODD))]) % 256**size
    data[at : at + size] = number.to_bytes(size, "little")


def _neighbour(data: bytearray, at: int, rng: np.random.Generator) -> None:
    """An address or length that is off by a few."""
    at -= at % 8
    number = int.from_bytes(data[at : at + 8], "little") + int(rng.integers(-64, 65))
    data[at : at + 8] = (number % 2**64).to_bytes(8, "little")


def _copied(data: bytearray, at: int, rng: np.random.Generator) -> None:
    """Bytes from elsewhere in the file, which are likely to have a meaning there."""
    size, source = int(rng.choice([8, 40, 512])), int(rng.integers(len(data)))
    data[at : at + size] = data[source : source + size]


def _other_address(data: bytearray, _: int, rng: np.random.Generator) -> None:
    """What looks like an address, by another one: loops, and one thing taken for another."""
    numbers = np.frombuffer(data, "<u8", count=len(data) // 8)
    addresses = np.flatnonzero((numbers > 0) & (numbers < len(data)) & (numbers % 8 == 0))
    if addresses.size:
        to, source = (8 * int(k) for k in rng.choice(addresses, 2))
        del numbers  # while it lives, the bytes have a fixed length
        data[to : to + 8] = data[source : source + 8]


def _zeros(data: bytearray, at: int, rng: np.random.Generator) -> None:
    size = int(rng.choice([8, 64, 4096]))
    data[at : at + size] = bytes(len(data[at : at + size]))


def _cut(data: bytearray, at: int, _: np.random.Generator) -> None:
    del data[at:]


_CHANGES = (
    *[_flip] * 6,
    *[_odd_number] * 4,
    *[_other_address] * 3,
    *[_neighbour] * 2,
    _random_byte,
    _copied,
    _zeros,
    _cut,
)


def mutated(data: bytes, seed: int) -> bytes:
    """A file with one to three changes, half of them at bytes that are not zero."""
    rng = np.random.default_rng(seed)
    changed = bytearray(data)
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        at = int(rng.integers(max(len(changed), 1)))
        while rng.random() < 0.8 and at + 1 < len(changed) and changed[at] == 0:
            at += 1
        if changed:
            _CHANGES[rng.integers(len(_CHANGES))](changed, at, rng)
    return bytes(changed)


def _lines(worker: subprocess.Popen, limit: float) -> Iterator[str]:
    """Lines of a worker until it ends; raises `TimeoutError` if it says nothing for a time."""
    buffer, more, patience = b"", b"...", max(limit, STARTING)
    while more:
        if not select.select([worker.stdout], [], [], patience)[0]:
            raise TimeoutError
        patience = limit
        more = os.read(worker.stdout.fileno(), 65536)
        *lines, buffer = (buffer + more).split(b"\n")
        yield from (line.decode() for line in lines)


def _one_worker(
    files: Sequence[Path], seeds: range, limit: float, program: str
) -> Iterator[Outcome]:
    """Outcomes of the seeds, in their order, up to the first at which the process ends."""
    command = [sys.executable, program, str(seeds.start), str(seeds.stop), *map(str, files)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as worker:
        begun, since, kind = None, time.monotonic(), "died"
        try:
            for line in _lines(worker, limit):
                seed, said, *detail = line.split(" ", 2)
                now = time.monotonic()
                if said == "begun":
                    begun, since = int(seed), now
                else:
                    yield Outcome(int(seed), said, "".join(detail), now - since)
                    begun = None
            worker.wait(limit)
        except (TimeoutError, subprocess.TimeoutExpired):
            kind = "hung"
        finally:
            worker.kill()
        worker.wait()
    if begun is not None:
        yield Outcome(begun, kind, f"status {worker.returncode}", time.monotonic() - since)
    elif worker.returncode:
        raise RuntimeError(f"the process that reads damaged tables: status {worker.returncode}")


def read_damaged(
    files: Sequence[Path],
    seeds: range,
    limit: float = 10.0,
    until: float = math.inf,
    program: str = __file__,
) -> Iterator[Outcome]:
    """Have damaged tables read by a process of its own; what became of each seed.

    Parameters
    ----------
    files : sequence of Path
        Whole tables; seed s damages number s modulo their number.
    seeds : range
        In steps of 1.
    limit : float
        Seconds after which a file counts as one at which the reader hangs.
    until : float
        Value of `time.monotonic` at which no further file is begun.
    program : str
        Script that reads the files; prints "SEED begun" and "SEED KIND DETAIL" for each.
    """
    while seeds and time.monotonic() < until:
        for outcome in _one_worker(files, seeds, limit, program):
            seeds = range(outcome.seed + 1, seeds.stop)
            yield outcome
            if time.monotonic() > until:
                return


def _read(path: Path, checksum: str) -> tuple[str, str]:
    """Kind and detail of what a reader makes of a file."""
    from sampler.formats.image import table_arrays

    from sampler.errors import TableError
    from sampler.formats.hdf5 import read_table

    try:
        contents = read_table(path)
        table_arrays(contents)
    except TableError as error:
        line = str(error)
        return ("raised" if "\n" in line else "refused"), line
    except Exception as error:
        return "raised", f"{type(error).__name__}: {error}"
    return ("same" if contents.content_sha256 == checksum else "other"), ""


def _peak() -> int:
    """Most memory that this process has had so far, bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _work(first: int, end: int, files: Sequence[Path]) -> None:
    """Read damaged files in this process and say after each what became of it."""
    import tempfile

    from sampler.formats.hdf5 import read_table

    originals = [(path.read_bytes(), read_table(path).content_sha256) for path in files]
    with tempfile.TemporaryDirectory() as folder:
        damaged = Path(folder) / "damaged.h5"
        for seed in range(first, end):
            data, checksum = originals[seed % len(originals)]
            damaged.write_bytes(mutated(data, seed))
            print(f"{seed} begun", flush=True)
            before = _peak()
            kind, detail = _read(damaged, checksum)
            if _peak() - before > MOST_MEMORY:
                kind = "large"
            detail = detail.replace(str(damaged), "").encode("unicode_escape").decode()
            print(f"{seed} {kind} {detail}", flush=True)


if __name__ == "__main__":
    _work(int(sys.argv[1]), int(sys.argv[2]), [Path(path) for path in sys.argv[3:]])
