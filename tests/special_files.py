"""Files that are not regular, of every kind that can be made here."""

import os
import socket

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
    elif kind == "link to a device":
        path.symlink_to("/dev/zero")  # which has no end
    else:
        return "/dev/zero", kind
    return path, kind.removeprefix("link to a ")
