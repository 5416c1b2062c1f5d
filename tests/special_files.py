"""Files that are not regular, of every kind that can be made here."""

import os
import socket
import stat
from pathlib import Path

import pytest

KINDS = ("folder", "pipe", "socket", "device", "link to a device")


def make_special(folder, kind):
    """Path of something that is no regular file, and a word for it."""
    path = folder / "special"
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        made = socket.socket(socket.AF_UNIX)
        made.bind(os.path.relpath(path))  # whose length is limited
        made.close()
    elif kind == "device":
        return _device(folder), kind
    else:
        path.symlink_to(_device(folder))
    return path, kind.removeprefix("link to a ")


def _device(folder):
    """Device without an end; the superuser gets another one, which a failing test may replace."""
    if os.geteuid() != 0:
        return Path("/dev/zero")
    path = folder / "zero"
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 5))
        with open(path, "rb") as file:
            file.read(1)
    except OSError:
        pytest.skip("no device can be made here")
    return path
