# SPDX-License-Identifier: GPL-3.0-or-later
"""scree for scripts: submit jobs, wait for them, read their streams live.

One file on pyzmq and numpy, Python 3.9 or later; copy it to where it is needed.
It speaks protocol/PROTOCOL.md and needs no part of scree on its side.

    import scree
    daemon = scree.connect()
    job = daemon.submit({"scenario": "incline", "time": {"end_s": 1}})
    for t, force in job.stream("basal_force"):
        print(t[-1], force.mean(axis=0))     # s, N
    print(job.show()["verdict"], job.fetch("result.h5"))

A stream that is being read survives the daemon: when it comes back, reading goes
on at the next chunk, without a gap and without a repetition, because chunks are
numbered and a job that is run again makes the same ones.
"""
import base64
import contextlib
import json
import math
import os
import stat
import time
import uuid

import numpy
import zmq

__all__ = ["connect", "Daemon", "Job", "Chunk", "Error", "Refused", "Unreachable", "Ended"]

VERSION = b"SC1"
RETRY_S = 2.0  # a request without an answer is sent again, under the same id
CREDIT_BYTES = 8 << 20
PART_BYTES = 512 << 10
ENDED = ("done", "failed", "cancelled")


class Error(Exception):
    """Anything that goes wrong here."""


class Unreachable(Error):
    """No daemon, or none that answers; over the network also: one that does not trust the key."""


class Refused(Error):
    """The daemon said no: `code` (invalid, not_found, busy, denied, ...), `path` of the field, `hint`."""

    def __init__(self, error):
        super().__init__(error.get("message", "refused") + (f" ({error['hint']})" if error.get("hint") else ""))
        self.code = error.get("code", "internal")
        self.path = error.get("path", "")
        self.hint = error.get("hint", "")


class Ended(Error):
    """A job came to another end than `done`; `record` is what `show` says of it."""

    def __init__(self, record):
        error = record.get("error") or {}
        super().__init__(f"{record['id']} {record['state']}" + (f": {error['message']}" if error.get("message") else ""))
        self.record = record


# ---- keys and endpoints ----


def keys_folder():
    own, config = os.environ.get("SCREE_KEYS"), os.environ.get("XDG_CONFIG_HOME")
    return own or os.path.join(config or os.path.expanduser("~/.config"), "scree", "keys")


def read_key(path, secret):
    """Of a file of `scree keygen`: the pair, or the public key. Bytes of Z85."""
    words = {}
    try:
        with open(path, encoding="ascii") as file:
            if secret and stat.S_IMODE(os.fstat(file.fileno()).st_mode) & 0o077:
                raise Error(f"{path}: others can read it; make new keys")
            for line in file:
                if line.strip() and not line.startswith("#"):
                    word, key = line.split()
                    words[word] = key.encode()
        return (words["public"], words["secret"]) if secret else words["public"]
    except OSError as error:
        raise Error(f"cannot read {path}: {error.strerror}; `scree keygen` makes keys, the daemon's server.pub comes from its owner") from error
    except (KeyError, ValueError) as error:
        raise Error(f"{path} is not a key of scree keygen") from error


def default_endpoint():
    runtime, user = os.environ.get("SCREE_RUNTIME"), os.environ.get("XDG_RUNTIME_DIR")
    if os.environ.get("SCREE_CONNECT"):
        return os.environ["SCREE_CONNECT"]
    return "ipc://" + (runtime or (os.path.join(user, "scree") if user else f"/tmp/scree-{os.getuid()}")) + "/control"


def connect(endpoint=None, patience_s=30.0, key=None, server_key=None):
    """A daemon that answers. `endpoint` of its control socket, as of `scree --connect`;
    over the network with the key file of this user and the public one of the daemon
    (defaults: $SCREE_KEY, $SCREE_SERVER_KEY, client.key and server.pub in the folder of
    keys). `patience_s`: how long any request waits for a daemon that does not answer."""
    daemon = Daemon(endpoint or default_endpoint(), patience_s, key, server_key)
    daemon.ping()
    return daemon


# ---- the daemon ----


class Daemon:
    """A connection to a control socket. Not for use from several threads at a time."""

    def __init__(self, endpoint, patience_s=30.0, key=None, server_key=None):
        self.endpoint = endpoint
        self.patience_s = patience_s
        self.curve = None
        if endpoint.startswith("tcp://"):
            key = key or os.environ.get("SCREE_KEY") or os.path.join(keys_folder(), "client.key")
            server_key = server_key or os.environ.get("SCREE_SERVER_KEY") or os.path.join(keys_folder(), "server.pub")
            server = server_key.encode() if len(server_key) == 40 and not os.path.exists(server_key) else read_key(server_key, False)
            self.curve = read_key(key, True) + (server,)
        elif not endpoint.startswith("ipc://"):
            raise Error(f"{endpoint}: an endpoint has the form ipc://PATH or tcp://HOST:PORT")
        self.context = zmq.Context.instance()
        self.socket = None

    def open_socket(self, kind, endpoint):
        sock = self.context.socket(kind)
        sock.linger = 0
        sock.reconnect_ivl, sock.reconnect_ivl_max = 50, 1000
        if self.curve:
            sock.curve_publickey, sock.curve_secretkey, sock.curve_serverkey = self.curve
        sock.connect(endpoint)
        return sock

    def close(self):
        if self.socket:
            self.socket.close()
            self.socket = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def ask(self, op, body=None, retry_s=RETRY_S, patience_s=None):
        """The result of any operation of the protocol. Asks again, under the same id, until
        there is an answer: a daemon that is restarted meanwhile does not show."""
        ident = uuid.uuid4().hex
        request = [VERSION, json.dumps({"id": ident, "op": op}).encode(), json.dumps(body or {}).encode()]
        end = time.monotonic() + (self.patience_s if patience_s is None else patience_s)
        while True:
            self.socket = self.socket or self.open_socket(zmq.DEALER, self.endpoint)
            with contextlib.suppress(zmq.Again):  # thrown out: no answer will come
                self.socket.send_multipart(request, zmq.DONTWAIT)
            until = min(end, time.monotonic() + retry_s)
            while self.socket.poll(max(0, int(1000 * (until - time.monotonic())))):
                frames = self.socket.recv_multipart()
                reply = json.loads(frames[1]) if len(frames) == 2 and frames[0] == VERSION else {}
                if reply.get("id") == ident:
                    if reply["ok"]:
                        return reply["result"]
                    raise Refused(reply["error"])
            self.close()
            if time.monotonic() >= end:
                trust = "" if not self.curve else ", or it does not trust this key, or its key is another (`scree ping` tells which)"
                raise Unreachable(f"no answer from {self.endpoint}{trust}")

    def ping(self):
        """What the daemon says of itself."""
        return self.ask("ping")

    def mesh(self, path):
        """Gives the daemon an STL or OBJ file and returns its name, for `sha256` of a job's params.mesh."""
        with open(path, "rb") as file:
            return self.ask("mesh", {"data": base64.b64encode(file.read()).decode()})["sha256"]

    def submit(self, spec, again=False):
        """Puts a job into the queue. `spec`: a dict, or the path of a JSON file."""
        if not isinstance(spec, dict):
            with open(spec, encoding="utf-8") as file:
                spec = json.load(file)
        return Job(self, self.ask("submit", {"spec": spec, "again": again})["job"])

    def job(self, ident):
        """The job of that id, which must exist."""
        job = Job(self, ident)
        job.show()
        return job

    def jobs(self, *states):
        """Summaries, newest first; of these states alone if any are given."""
        return self.ask("list", {"states": list(states)} if states else {})["jobs"]

    def stream_endpoint(self, pong):
        """Over the network: the host that was reached, whatever address the daemon listens on."""
        endpoint = pong["stream_endpoint"]
        if not self.curve:
            return endpoint
        return self.endpoint.rsplit(":", 1)[0] + ":" + endpoint.rsplit(":", 1)[1]


class Chunk:
    """A piece of a stream: rows of `values` (n by columns) at times `t` (n), in seconds."""

    def __init__(self, header, payload):
        self.seq = header["seq"]
        self.columns, self.units = header["columns"], header["units"]
        self.dt_s = header["dt_s"]
        self.values = numpy.frombuffer(payload, header["dtype"]).reshape(header["n"], len(self.columns))
        self.t = header["t0_s"] + self.dt_s * numpy.arange(header["n"])

    def column(self, name):
        return self.values[:, self.columns.index(name)]


class Job:
    """A job of a daemon, by its id."""

    def __init__(self, daemon, ident):
        self.daemon = daemon
        self.id = ident

    def __repr__(self):
        return f"<scree job {self.id} at {self.daemon.endpoint}>"

    def ask(self, op, **body):
        """Any operation on this job: job.ask("pause"), job.ask("set", ...)."""
        return self.daemon.ask(op, {"job": self.id, **body})

    def show(self):
        """Its whole record."""
        return self.ask("show")

    def cancel(self):
        return self.ask("cancel")["state"]

    def wait(self, timeout_s=None, check=True):
        """Its record once it has ended. Raises Ended for another end than `done` if `check`,
        TimeoutError when it takes longer than `timeout_s`."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        pause = 0.02
        while True:
            record = self.show()
            if record["state"] in ENDED:
                if check and record["state"] != "done":
                    raise Ended(record)
                return record
            if end is not None and time.monotonic() >= end:
                raise TimeoutError(f"{self.id} is {record['state']} after {timeout_s} s")
            time.sleep(pause)
            pause = min(0.5, 1.5 * pause)

    def stream(self, name, start=0):
        """(t, values) of each chunk, from number `start` on, live to the end of the job: t in
        seconds (n), values n by columns."""
        for chunk in self.chunks(name, start):
            yield chunk.t, chunk.values

    def chunks(self, name, start=0):
        """The same as whole Chunks, with number, names and units of columns."""
        reader = Reader(self, name, start)
        try:
            while True:
                chunk = reader.next()
                if chunk is None:
                    return
                yield chunk
                reader.paid(chunk)
        finally:
            reader.close()

    def fetch(self, path=None):
        """The result so far as an HDF5 file; returns its path."""
        path = path or f"{self.id}.h5"
        part = f"{path}.part-{os.getpid()}"
        for _ in range(3):  # the file is made anew when the job ends meanwhile
            total = self.daemon.ask("fetch", {"job": self.id}, retry_s=60, patience_s=1800)["bytes"]
            try:
                if self.fetch_parts(part, total):
                    os.replace(part, path)
                    return path
            finally:
                if os.path.exists(part):
                    os.unlink(part)
        raise Error(f"the result of {self.id} changed while it was fetched")

    def fetch_parts(self, part, total):
        with open(part, "wb") as file:
            while file.tell() < total:
                piece = self.ask("fetch_part", offset=file.tell(), bytes=PART_BYTES)
                if piece["total"] != total or not piece["bytes"]:
                    return False
                file.write(base64.b64decode(piece["data"]))
            file.flush()
            os.fsync(file.fileno())
        return True


class Reader:
    """One subscription. A daemon that went away took the subscription with it: after a
    silence its uptime tells whether it is younger than what was opened, and then the
    stream is opened anew where reading stands."""

    def __init__(self, job, name, start):
        self.job, self.name, self.seq = job, name, start
        self.socket = None
        self.opened = 0.0
        self.open()

    def say(self, **header):
        try:
            self.socket.send_multipart([VERSION, json.dumps({"key": "r", **header}).encode()], zmq.DONTWAIT)
        except zmq.Again:  # thrown out: opened anew once silence has shown it
            self.opened = -math.inf

    def open(self):
        self.close()
        pong = self.job.daemon.ping()
        self.opened = time.monotonic()
        self.socket = self.job.daemon.open_socket(zmq.DEALER, self.job.daemon.stream_endpoint(pong))
        self.say(op="open", job=self.job.id, stream=self.name, **{"from": self.seq})
        self.say(op="credit", bytes=CREDIT_BYTES)

    def close(self):
        if self.socket:
            self.socket.close()
            self.socket = None

    def paid(self, chunk):
        if chunk.values.nbytes:
            self.say(op="credit", bytes=chunk.values.nbytes)

    def next(self):
        """The next Chunk, None at the end."""
        while True:
            if not self.socket.poll(int(1000 * RETRY_S)):
                if self.job.daemon.ping()["uptime_s"] < time.monotonic() - self.opened:
                    self.open()
                continue
            frames = self.socket.recv_multipart()
            header = json.loads(frames[1]) if len(frames) in (2, 3) and frames[0] == VERSION else {}
            if header.get("op") == "error":
                raise Refused(header["error"])
            if header.get("op") == "end":
                if header["chunks"] == self.seq:
                    return None
                self.open()
            elif header.get("op") == "chunk" and len(frames) == 3:
                if header["seq"] != self.seq:  # a message was lost on the way: from the last good one
                    self.open()
                    continue
                self.seq += 1
                return Chunk(header, frames[2])
