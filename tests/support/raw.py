# SPDX-License-Identifier: GPL-3.0-or-later
"""A client of screed that is not ours: written from protocol/PROTOCOL.md alone,
on python3-zmq, so that tests can tell whether the page and the daemon agree."""
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import uuid

import zmq

BIN = os.environ["SCREE_BIN"]
with open(os.path.join(BIN, "screed"), "rb") as program:
    SANITIZED = b"__asan_init" in (text := program.read()) or b"__tsan_init" in text
PATIENCE_S = float(os.environ.get("SCREE_PATIENCE", 60))  # for anything that should come at once; machines may be busy


class Refused(Exception):
    """A reply or a stream's end with ok false."""

    def __init__(self, error):
        super().__init__(json.dumps(error))
        self.code = error["code"]
        self.path = error["path"]
        self.message = error["message"]
        self.hint = error["hint"]


def crc32c_rows():
    rows = []
    for k in range(256):
        for _ in range(8):
            k = k >> 1 ^ 0x82F63B78 if k & 1 else k >> 1
        rows.append(k)
    return rows


CRC_ROWS = crc32c_rows()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = CRC_ROWS[(crc ^ byte) & 0xFF] ^ crc >> 8
    return crc ^ 0xFFFFFFFF


def hash_word(value, word):
    value = (value ^ word) * 0x9E3779B97F4A7C15 & 0xFFFFFFFFFFFFFFFF
    return value ^ value >> 29


def chunk_hash(before, header, payload):
    """The running hash of a stream up to and with this chunk (PROTOCOL.md)."""
    value = hash_word(before, header["seq"])
    for word in struct.unpack("<2Q", struct.pack("<2d", header["t0_s"], header["dt_s"])):
        value = hash_word(value, word)
    value = hash_word(value, header["n"])
    for word, in struct.iter_unpack("<Q", payload):
        value = hash_word(value, word)
    return value


def receive(socket, timeout_s):
    """One multipart message, or None."""
    if not socket.poll(int(timeout_s * 1000)):
        return None
    return socket.recv_multipart()


class Control:
    """Requests and replies over one DEALER."""

    def __init__(self, endpoint):
        self.socket = zmq.Context.instance().socket(zmq.DEALER)
        self.socket.linger = 0
        self.socket.connect(endpoint)

    def close(self):
        self.socket.close()

    def frames(self, frames, timeout_s=PATIENCE_S):
        """Sends any frames and returns the header of the reply."""
        self.socket.send_multipart(frames)
        return self.reply(timeout_s)

    def reply(self, timeout_s=PATIENCE_S):
        answer = receive(self.socket, timeout_s)
        assert answer is not None, f"no reply in {timeout_s} s"
        assert len(answer) == 2 and answer[0] == b"SC1", answer
        return json.loads(answer[1])

    def ask(self, op, body=None, request=None, timeout_s=PATIENCE_S):
        """The result of an operation; raises Refused. Replies to earlier requests are dropped."""
        request = request or uuid.uuid4().hex
        header = json.dumps({"id": request, "op": op}).encode()
        self.socket.send_multipart([b"SC1", header, json.dumps(body or {}).encode()])
        end = time.monotonic() + timeout_s
        while True:
            reply = self.reply(max(0, end - time.monotonic()))
            if reply["id"] == request:
                break
        if not reply["ok"]:
            raise Refused(reply["error"])
        return reply["result"]

    def submit(self, spec, request=None, again=False):
        return self.ask("submit", {"spec": spec, "again": again}, request=request)["job"]

    def wait(self, job, states=("done", "failed", "cancelled"), timeout_s=2 * PATIENCE_S):
        """The record of the job once it is in one of the states."""
        end = time.monotonic() + timeout_s
        while True:
            record = self.ask("show", {"job": job})
            if record["state"] in states:
                return record
            assert time.monotonic() < end, f"{job} is {record['state']} after {timeout_s} s, not {states}: {record}"
            time.sleep(0.05)


class Streams:
    """Subscriptions over one DEALER."""

    def __init__(self, endpoint):
        self.socket = zmq.Context.instance().socket(zmq.DEALER)
        self.socket.linger = 0
        self.socket.connect(endpoint)

    def close(self):
        self.socket.close()

    def send(self, **header):
        self.socket.send_multipart([b"SC1", json.dumps(header).encode()])

    def open(self, key, job, stream, start=None):
        header = {"op": "open", "key": key, "job": job, "stream": stream}
        if start is not None:
            header["from"] = start
        self.send(**header)

    def credit(self, key, count):
        self.send(op="credit", key=key, bytes=count)

    def message(self, timeout_s=PATIENCE_S, alive=False):
        """(header, payload) of the next message, or None after so long a silence; one that only says that the
        daemon lives, which a slow one may at any time, is passed over unless it is asked for."""
        while True:
            frames = receive(self.socket, timeout_s)
            if frames is None:
                return None
            assert frames[0] == b"SC1", frames
            header = json.loads(frames[1])
            assert len(frames) == (3 if header["op"] == "chunk" else 2), [len(f) for f in frames]
            if alive or header["op"] != "alive":
                return header, frames[2] if len(frames) == 3 else b""

    def read_all(self, key, job, stream, start=0, grant=1 << 20, timeout_s=PATIENCE_S):
        """Every chunk from `start` to the end, paying `grant` bytes at a time.
        Returns ([(header, payload)], end header); raises Refused."""
        chunks = []
        self.open(key, job, stream, start)
        self.credit(key, grant)
        unpaid = 0
        while True:
            got = self.message(timeout_s)
            assert got is not None, f"nothing for {timeout_s} s after {len(chunks)} chunks"
            header, payload = got
            assert header["key"] == key, header
            if header["op"] == "error":
                raise Refused(header["error"])
            if header["op"] == "end":
                return chunks, header
            chunks.append(got)
            unpaid += len(payload)
            if unpaid:
                self.credit(key, unpaid)
                unpaid = 0


class Daemon:
    """A screed in a temporary directory of its own; with `folder` on that one again."""

    def __init__(self, folder=None, workers=1, options=(), environment=None):
        self.owned = folder is None
        self.folder = folder or tempfile.mkdtemp(prefix="scree-test-")
        self.data = os.path.join(self.folder, "data")
        self.runtime = os.path.join(self.folder, "run")
        self.endpoint = "ipc://" + os.path.join(self.runtime, "control")
        self.log_path = os.path.join(self.folder, f"screed.{time.monotonic_ns()}.log")
        self.control = None
        with open(self.log_path, "wb") as log:
            self.process = subprocess.Popen(
                [os.path.join(BIN, "screed"), "--data", self.data, "--runtime", self.runtime, "--workers", str(workers), *options],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, env={**os.environ, **(environment or {})})
        try:
            self.control = Control(self.endpoint)
            self.about = self.first_ping()
        except BaseException:
            sys.stderr.write(self.log())
            self.stop()
            self.remove()
            raise

    def first_ping(self):
        end = time.monotonic() + PATIENCE_S
        while True:
            assert self.alive(), f"screed ended with {self.process.returncode} before it answered"
            try:
                return self.control.ask("ping", timeout_s=1)
            except AssertionError:
                if time.monotonic() > end:
                    raise

    def log(self):
        with open(self.log_path, errors="replace") as log:
            return log.read()

    def alive(self):
        return self.process.poll() is None

    def streams(self):
        return Streams(self.about["stream_endpoint"])

    def stop(self, number=signal.SIGTERM, timeout_s=PATIENCE_S):
        """Ends it; returns its exit code. Kills what does not end by itself and says so."""
        if self.control:
            self.control.close()
            self.control = None
        if self.alive():
            self.process.send_signal(number)
        elif self.process.returncode > 0 or self.process.returncode == -signal.SIGABRT:
            sys.stderr.write(f"screed had ended with {self.process.returncode} by itself:\n" + self.log())
        try:
            return self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"screed did not end within {timeout_s} s of signal {number}\n" + self.log()) from None

    def remove(self):
        if self.owned:
            shutil.rmtree(self.folder, ignore_errors=True)
