# SPDX-License-Identifier: GPL-3.0-or-later
"""What xdotool cannot do on a display: drop files on a window (XDND 5) and set resources. Through
libX11, which xdotool brings along."""

import ctypes
import ctypes.util
import time
import urllib.parse

SELECTION_REQUEST, SELECTION_NOTIFY, CLIENT_MESSAGE = 30, 31, 33
NO_EVENT_MASK, REPLACE, XA_STRING = 0, 0, 31
EVENT_LONGS = 24


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong),
                ("message_type", ctypes.c_ulong), ("format", ctypes.c_int),
                ("data", ctypes.c_long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("owner", ctypes.c_ulong),
                ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong),
                ("target", ctypes.c_ulong), ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class Selection(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("requestor", ctypes.c_ulong),
                ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong),
                ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("client", ClientMessage), ("request", SelectionRequest),
                ("selection", Selection), ("room", ctypes.c_long * EVENT_LONGS)]


def library():
    x = ctypes.CDLL(ctypes.util.find_library("X11") or "libX11.so.6")
    x.XOpenDisplay.restype = ctypes.c_void_p
    x.XDefaultRootWindow.restype = x.XInternAtom.restype = ctypes.c_ulong
    x.XCreateSimpleWindow.restype = ctypes.c_ulong
    x.XInternAtom.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int]
    x.XCreateSimpleWindow.argtypes = [ctypes.c_void_p, ctypes.c_ulong] + [ctypes.c_int] * 2 + \
        [ctypes.c_uint] * 3 + [ctypes.c_ulong] * 2
    x.XDefaultRootWindow.argtypes = x.XCloseDisplay.argtypes = x.XFlush.argtypes = \
        x.XPending.argtypes = [ctypes.c_void_p]
    x.XSync.argtypes = [ctypes.c_void_p, ctypes.c_int]
    x.XNextEvent.argtypes = [ctypes.c_void_p, ctypes.POINTER(Event)]
    x.XSendEvent.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long,
                             ctypes.POINTER(Event)]
    x.XSetSelectionOwner.argtypes = [ctypes.c_void_p] + [ctypes.c_ulong] * 3
    x.XChangeProperty.argtypes = [ctypes.c_void_p] + [ctypes.c_ulong] * 3 + [ctypes.c_int] * 2 + \
        [ctypes.c_char_p, ctypes.c_int]
    return x


class Connection:
    """To the display of a name; for `with`."""

    def __init__(self, name):
        self.x = library()
        self.display = self.x.XOpenDisplay(name.encode())
        if not self.display:
            raise RuntimeError(f"no display {name}")
        self.root = self.x.XDefaultRootWindow(self.display)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.x.XCloseDisplay(self.display)

    def atom(self, name):
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def set_resources(self, text):
        """As xrdb -load does."""
        data = text.encode()
        self.x.XChangeProperty(self.display, self.root, self.atom("RESOURCE_MANAGER"), XA_STRING,
                               8, REPLACE, data, len(data))
        self.x.XSync(self.display, 0)

    def send(self, window, name, source, *data):
        event = Event()
        event.client.type, event.client.display = CLIENT_MESSAGE, self.display
        event.client.window, event.client.format = window, 32
        event.client.message_type = self.atom(name)
        event.client.data[:] = [source, *data] + [0] * (4 - len(data))
        self.x.XSendEvent(self.display, window, 0, NO_EVENT_MASK, ctypes.byref(event))
        self.x.XFlush(self.display)

    def next_event(self, patience_s):
        """The next event, or None where none comes in time."""
        end = time.monotonic() + patience_s
        while self.x.XPending(self.display) == 0:
            if time.monotonic() > end:
                return None
            time.sleep(0.01)
        event = Event()
        self.x.XNextEvent(self.display, ctypes.byref(event))
        return event

    def answer(self, request, data):
        """Hands out what is being dragged."""
        self.x.XChangeProperty(self.display, request.requestor, request.property, request.target,
                               8, REPLACE, data, len(data))
        event = Event()
        event.selection.type, event.selection.display = SELECTION_NOTIFY, self.display
        event.selection.requestor = request.requestor
        event.selection.selection = request.selection
        event.selection.target, event.selection.property = request.target, request.property
        event.selection.time = request.time
        self.x.XSendEvent(self.display, request.requestor, 0, NO_EVENT_MASK, ctypes.byref(event))
        self.x.XFlush(self.display)


def drop(display, window, paths, patience_s):
    """Drags files over the middle of a window and lets go, as a file manager does; returns when the
    window says that it has them."""
    uris = "".join("file://" + urllib.parse.quote(path) + "\r\n" for path in paths).encode()
    with Connection(display) as to:
        source = to.x.XCreateSimpleWindow(to.display, to.root, 0, 0, 1, 1, 0, 0, 0)
        selection = to.atom("XdndSelection")
        to.x.XSetSelectionOwner(to.display, selection, source, 0)
        to.send(window, "XdndEnter", source, 5 << 24, to.atom("text/uri-list"))
        to.send(window, "XdndPosition", source, 0, 100 << 16 | 100, 0, to.atom("XdndActionCopy"))
        status, finished = to.atom("XdndStatus"), to.atom("XdndFinished")
        while event := to.next_event(patience_s):
            if event.type == SELECTION_REQUEST:
                to.answer(event.request, uris)
            elif event.type == CLIENT_MESSAGE and event.client.message_type == status:
                if event.client.data[1] & 1 == 0:
                    raise RuntimeError("the window does not want files")
                to.send(window, "XdndDrop", source, 0, 0)
            elif event.type == CLIENT_MESSAGE and event.client.message_type == finished:
                return
        raise TimeoutError("the window does not take what is dropped")
