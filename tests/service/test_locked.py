# SPDX-License-Identifier: GPL-3.0-or-later
"""The network endpoint: only trusted keys come in, each may do what its role
says, and strangers, however many and however rude, cost next to nothing."""
import base64
import contextlib
import json
import os
import random
import socket
import stat
import struct
import subprocess
import tempfile
import time
import unittest

import zmq

from raw import BIN, SANITIZED, Control, Daemon, Refused, Streams

SCREE = os.path.join(BIN, "scree")
SCREED = os.path.join(BIN, "screed")
TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"  # an OBJ file
COLLISION = {"scenario": "collision"}
LONG = {"scenario": "incline", "params": {"nx": 4, "ny": 4, "nz": 3}, "time": {"end_s": 1000}, "stop": {"when": []},
        "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}}}
# ZMTP 3.1's greeting (ZeroMQ RFC 23), for a mechanism.
SIGNATURE = b"\xff" + bytes(8) + b"\x7f"


def greeting(mechanism=b"CURVE"):
    return SIGNATURE + b"\x03\x01" + mechanism.ljust(20, b"\0") + bytes(32)


def free_ports():
    """The first of three free ones in a row."""
    while True:
        first = random.randrange(20000, 60000)
        taken = []
        try:
            for port in range(first, first + 3):
                taken.append(socket.socket())
                taken[-1].bind(("127.0.0.1", port))
            return first
        except OSError:
            continue
        finally:
            for one in taken:
                one.close()


def scree(keys, *arguments, timeout_s=60, **environment):
    return subprocess.run([SCREE, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout_s,
                          env={**os.environ, "SCREE_KEYS": keys, **environment}, check=False)


def key_of(folder, name):
    """(public, secret or None) of a key file."""
    words = {}
    path = os.path.join(folder, name)
    with open(path) as file:
        for line in file:
            if not line.startswith("#"):
                word, key = line.split()
                words[word] = key.encode()
    return words["public"], words.get("secret")


def memory_kib(pid):
    with open(f"/proc/{pid}/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def secured(kind, folder, endpoint, server=None, name="client.key"):
    peer = zmq.Context.instance().socket(kind)
    peer.linger = 0
    peer.curve_publickey, peer.curve_secretkey = key_of(folder, name)
    peer.curve_serverkey = server or key_of(folder, "server.pub")[0]
    peer.connect(endpoint)
    return peer


class CurveControl(Control):
    def __init__(self, folder, endpoint, server=None):  # pylint: disable=super-init-not-called
        self.socket = secured(zmq.DEALER, folder, endpoint, server)


class CurveStreams(Streams):
    def __init__(self, folder, endpoint):  # pylint: disable=super-init-not-called
        self.socket = secured(zmq.DEALER, folder, endpoint)


class Keyed(unittest.TestCase):
    """A daemon on the network with keys of its own, and users with theirs."""

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        self.server_keys = os.path.join(self.folder, "server-keys")
        self.assertEqual(scree(self.server_keys, "keygen", "server").returncode, 0)

    def start(self, *options):
        self.port = free_ports()
        os.mkdir(os.path.join(self.folder, "daemon"))
        daemon = Daemon(folder=os.path.join(self.folder, "daemon"),
                        options=("--listen", f"tcp://127.0.0.1:{self.port}", "--keys", self.server_keys, *options))
        self.addCleanup(daemon.stop)
        self.endpoint = f"tcp://127.0.0.1:{self.port}"
        return daemon

    def user(self, name, role=None):
        """A folder of keys of a user, trusted if a role is given."""
        folder = os.path.join(self.folder, name)
        self.assertEqual(scree(folder, "keygen").returncode, 0)
        with open(os.path.join(self.server_keys, "server.pub"), "rb") as file:
            public = file.read()
        with open(os.path.join(folder, "server.pub"), "wb") as file:
            file.write(public)
        if role:
            self.trust(name, role)
        return folder

    def trust(self, name, role):
        ended = scree(self.server_keys, "trust", os.path.join(self.folder, name, "client.pub"), "--name", name, "--role", role)
        self.assertEqual(ended.returncode, 0, ended)

    def control(self, folder):
        control = CurveControl(folder, self.endpoint)
        self.addCleanup(control.close)
        return control

    def denied(self, control, op, body=None):
        with self.assertRaises(Refused) as caught:
            control.ask(op, body, timeout_s=10)
        self.assertEqual(caught.exception.code, "denied", caught.exception)

    def remote(self, folder, *arguments, **environment):
        return scree(folder, "--connect", self.endpoint, *arguments, **environment)


class Locked(Keyed):
    # ---- who may come in ----

    def test_network_without_a_server_key_is_refused_and_says_how_to_make_one(self):
        # No key, no encryption: then nothing may listen at all.
        nothing = os.path.join(self.folder, "nothing")
        ended = subprocess.run([SCREED, "--listen", "tcp://127.0.0.1:5999", "--keys", nothing, "--data", self.folder + "/d",
                                "--runtime", self.folder + "/r"], capture_output=True, text=True, timeout=30, check=False)
        self.assertEqual(ended.returncode, 2, ended)
        self.assertIn("keygen server", ended.stderr)
        with socket.socket() as probe:
            self.assertNotEqual(probe.connect_ex(("127.0.0.1", 5999)), 0)

    def test_keys_that_others_can_read_are_refused(self):
        # A secret that was open once is none.
        path = os.path.join(self.server_keys, "server.key")
        self.assertEqual(stat.S_IMODE(os.stat(path).st_mode), 0o600)
        self.assertEqual(stat.S_IMODE(os.stat(self.server_keys).st_mode), 0o700)
        arguments = [SCREED, "--listen", "tcp://127.0.0.1:5999", "--keys", self.server_keys, "--data", self.folder + "/d",
                     "--runtime", self.folder + "/r"]
        for what, mode, good in ((path, 0o640, 0o600), (self.server_keys, 0o750, 0o700)):
            os.chmod(what, mode)
            ended = subprocess.run(arguments, capture_output=True, text=True, timeout=30, check=False)
            os.chmod(what, good)
            self.assertEqual(ended.returncode, 77, ended)
            self.assertIn("chmod", ended.stderr)
        folder = self.user("anna")
        os.chmod(os.path.join(folder, "client.key"), 0o644)
        self.start()
        ended = self.remote(folder, "ping")
        self.assertEqual(ended.returncode, 77, ended)
        self.assertIn("client.key", ended.stderr)

    def test_causes_are_named_on_the_client(self):
        # Four ways to fail, four texts; 69 for nobody there, 77 for keys.
        self.start()
        folder = self.user("anna")
        ended = self.remote(folder, "ping")
        self.assertEqual(ended.returncode, 77, ended)
        self.assertIn("does not trust this key", ended.stderr)
        self.trust("anna", "view")
        self.assertEqual(self.remote(folder, "ping").returncode, 0)
        other = self.user("other")
        ended = self.remote(folder, "ping", SCREE_SERVER_KEY=os.path.join(other, "client.pub"))
        self.assertEqual(ended.returncode, 77, ended)
        self.assertIn("not the one whose key is in", ended.stderr)
        ended = self.remote(os.path.join(self.folder, "without"), "ping")
        self.assertEqual(ended.returncode, 77, ended)
        self.assertIn("keygen", ended.stderr)
        ended = scree(folder, "--connect", "tcp://127.0.0.1:1", "ping")
        self.assertEqual(ended.returncode, 69, ended)
        self.assertIn("no daemon at", ended.stderr)

    def test_each_role_may_do_what_it_says_and_no_more(self):
        # Roles are ranks: what one may, the next may too.
        daemon = self.start()
        job = daemon.control.submit(LONG)
        body = {"ping": {}, "show": {"job": job}, "submit": {"spec": COLLISION},
                "mesh": {"data": base64.b64encode(TRIANGLE).decode()}, "cancel": {"job": job}, "shutdown": {}}
        operations = {"view": ["ping", "show"], "submit": ["submit", "mesh"], "steer": ["cancel"], "admin": ["shutdown"]}
        for number, role in enumerate(operations):
            control = self.control(self.user(role, role))
            for later, op in [(k, op) for k, r in enumerate(operations) for op in operations[r]]:
                if later > number:
                    self.denied(control, op, body[op])
                elif op != "shutdown":
                    control.ask(op, body[op])
        control.ask("shutdown")
        self.assertEqual(daemon.process.wait(20), 0)

    def test_withdrawn_trust_ends_at_once(self):
        # Without a restart, on connections that are open; streams too.
        daemon = self.start()
        folder = self.user("anna", "view")
        control = self.control(folder)
        job = daemon.control.submit(LONG)
        streams = CurveStreams(folder, control.ask("ping")["stream_endpoint"])
        self.addCleanup(streams.close)
        streams.open("k", job, "basal_force")
        streams.credit("k", 1)
        self.assertEqual(streams.message()[0]["op"], "chunk")
        self.assertEqual(scree(self.server_keys, "trust", "anna", "--remove").returncode, 0)
        self.denied(control, "ping")
        streams.credit("k", 1 << 20)
        end = time.monotonic() + 10
        header = {}
        while header.get("op") != "error" and time.monotonic() < end:
            header = streams.message()[0]
        self.assertEqual(header["error"]["code"], "denied", header)
        self.assertIn("does not trust", self.remote(folder, "ping").stderr)

    def test_a_damaged_list_lets_nobody_in(self):
        # Fails closed: a line that cannot be read might have been the one that takes a right away.
        daemon = self.start()
        control = self.control(self.user("anna", "view"))
        control.ask("ping")
        with open(os.path.join(self.server_keys, "trusted"), "a") as file:
            file.write("view anna\n")
        self.denied(control, "ping")
        self.assertIn("nobody is let in", daemon.log())
        daemon.control.ask("ping")  # the owner's own way does not hang on it

    def test_any_null_client_is_refused(self):
        # CURVE fails open where no handler is enforced; NULL on the network is not taken at all.
        self.start()
        plain = Control(self.endpoint)
        self.addCleanup(plain.close)
        plain.socket.send_multipart([b"SC1", b'{"id":"a","op":"ping"}', b"{}"])
        self.assertEqual(plain.socket.poll(1000), 0)

    # ---- over the network everything works ----

    def test_run_over_the_network_fetches_the_same_result(self):
        # The result comes in pieces, not by a path on the daemon's machine.
        daemon = self.start()
        folder = self.user("anna", "submit")
        spec = os.path.join(self.folder, "job.json")
        with open(spec, "w") as file:
            json.dump(COLLISION, file)
        out = os.path.join(self.folder, "out.h5")
        ended = self.remote(folder, "--json", "run", spec, "-o", out)
        self.assertEqual(ended.returncode, 0, ended)
        with open(out, "rb") as here, open(os.path.join(daemon.data, "jobs", "j1", "result.h5"), "rb") as there:
            self.assertEqual(here.read(), there.read())
        tail = self.remote(folder, "tail", "j1", "contact", "--no-follow")
        self.assertEqual(tail.returncode, 0, tail)
        self.assertGreater(len(tail.stdout.splitlines()), 10)

    def test_events_reach_trusted_subscribers_alone(self):
        # They tell of jobs: as secret as the rest.
        daemon = self.start()
        folder = self.user("anna", "view")
        endpoint = self.control(folder).ask("ping")["events_endpoint"]
        trusted = secured(zmq.SUB, folder, endpoint)
        stranger = secured(zmq.SUB, self.user("mallory"), endpoint)
        for one in (trusted, stranger):
            self.addCleanup(one.close)
            one.subscribe(b"job/")
        end = time.monotonic() + 20
        while not trusted.poll(200) and time.monotonic() < end:
            daemon.control.submit(COLLISION, again=True)
        self.assertTrue(trusted.recv().startswith(b"job/"))
        self.assertEqual(stranger.poll(300), 0)

    # ---- limits ----

    def test_a_users_jobs_are_limited_and_a_retry_is_none(self):
        # Seventeen files of one user must not fill the queue of all.
        daemon = self.start("--max-jobs-per-user", "2")
        anna, boris = self.control(self.user("anna", "steer")), self.control(self.user("boris", "submit"))
        first = anna.submit(LONG, request="one")
        anna.submit({**LONG, "seed": 2})
        with self.assertRaises(Refused) as caught:
            anna.submit({**LONG, "seed": 3})
        self.assertEqual(caught.exception.code, "busy")
        self.assertEqual(anna.submit(LONG, request="one"), first)
        boris.submit({**LONG, "seed": 4})
        for seed in (5, 6, 7):
            daemon.control.submit({**LONG, "seed": seed})
        anna.ask("cancel", {"job": first})
        daemon.control.wait(first)
        anna.submit({**LONG, "seed": 8})

    def test_a_request_id_of_another_user_gives_nothing_away(self):
        # Ids are idempotency keys; those of two users must not meet.
        self.start()
        anna, boris = self.control(self.user("anna", "submit")), self.control(self.user("boris", "submit"))
        self.assertNotEqual(anna.submit(LONG, request="same"), boris.submit({**LONG, "seed": 2}, request="same"))

    def test_a_users_streams_are_limited(self):
        # One open log each.
        daemon = self.start("--max-streams-per-user", "3")
        job = daemon.control.submit(LONG)
        folder = self.user("anna", "view")
        streams = [CurveStreams(folder, f"tcp://127.0.0.1:{self.port + 1}") for _ in range(2)]
        for one in streams:
            self.addCleanup(one.close)
        for key in range(3):
            streams[0].open(f"k{key}", job, "basal_force")
        streams[0].credit("k2", 1)
        self.assertEqual(streams[0].message()[0]["op"], "chunk")
        streams[1].open("k", job, "basal_force")
        header, _ = streams[1].message()
        self.assertEqual((header["op"], header["error"]["code"]), ("error", "busy"))


class Hostile(Keyed):
    """A raw peer against a daemon that a trusted client uses meanwhile."""

    def setUp(self):
        super().setUp()
        self.daemon = self.start("--max-connections", "64", "--handshake-s", "3")
        self.friend = self.control(self.user("friend", "view"))
        self.friend.ask("ping")
        self.before = memory_kib(self.daemon.process.pid)

    def connect(self, offset=0):
        peer = socket.create_connection(("127.0.0.1", self.port + offset), timeout=5)
        self.addCleanup(peer.close)
        return peer

    def is_closed(self, peer, within_s):
        """Whether the daemon hangs up in time."""
        end = time.monotonic() + within_s
        while time.monotonic() < end:
            peer.settimeout(max(0.01, end - time.monotonic()))
            try:
                if not peer.recv(4096):
                    return True
            except socket.timeout:
                return False
            except OSError:
                return True
        return False

    def assert_unharmed(self, grown_kib=16384):
        """The friend is served as before, quickly, over the same connection and a new one."""
        worst = 0
        for _ in range(20):
            start = time.monotonic()
            self.friend.ask("ping", timeout_s=10)
            worst = max(worst, time.monotonic() - start)
        self.assertLess(worst, 2)
        ended = self.remote(os.path.join(self.folder, "friend"), "ping")
        self.assertEqual(ended.returncode, 0, ended)
        if not SANITIZED:  # which keep what was freed
            self.assertLess(memory_kib(self.daemon.process.pid) - self.before, grown_kib)
        self.assertTrue(self.daemon.alive())

    def open_files(self):
        return len(os.listdir(f"/proc/{self.daemon.process.pid}/fd"))

    def test_a_flood_of_connections_is_bounded(self):
        # Descriptors and memory stay flat, and who has proved a key keeps the place.
        files = self.open_files()
        peers = [self.connect(k % 3) for k in range(400)]
        self.friend.ask("ping", timeout_s=10)
        self.assertLess(self.open_files() - files, 3 * 64)
        self.assert_unharmed()
        del peers

    def test_a_slow_handshake_is_cut_off(self):
        # A byte now and then would hold a place for ever.
        peer = self.connect()
        closed, text = False, greeting()
        start = time.monotonic()
        while not closed and time.monotonic() - start < 15:
            try:
                peer.sendall(text[:1])
            except OSError:
                closed = True
            text = text[1:] or b"\0"
            closed = closed or self.is_closed(peer, 0.2)
        self.assertTrue(closed)
        self.assertLess(time.monotonic() - start, 7)
        self.assert_unharmed()

    def test_garbage_is_cut_off(self):
        # Whatever the bytes: the connection goes, the daemon stays.
        source = random.Random(1)
        for k in range(40):
            peer = self.connect(k % 3)
            try:
                peer.sendall(source.randbytes(source.randrange(1, 5000)))
            except OSError:
                pass
            self.assertTrue(self.is_closed(peer, 6), k)
        self.assert_unharmed()

    def test_oversize_frames_before_the_handshake_cost_nothing(self):
        # ZeroMQ alone would take 2 MiB from each, a frame that it has announced, and wait for its end:
        # these are gone long before the deadline of their handshakes.
        peers = []
        for claim in (1 << 20, 2 << 20, 1 << 40, (1 << 63) - 1):
            for flags in (b"\x02", b"\x06"):
                peers.append((self.connect(), claim, flags))
                try:
                    peers[-1][0].sendall(greeting() + flags + struct.pack(">Q", claim) + bytes(1 << 14))
                except OSError:
                    pass
        for peer, claim, flags in peers:
            self.assertTrue(self.is_closed(peer, 1.5), (claim, flags))
        self.assert_unharmed()

    def test_endless_multipart_frames_cost_nothing(self):
        # MAXMSGSIZE and RCVHWM count frames and messages: one that never ends passes both.
        for mechanism in (b"NULL", b"CURVE", b"PLAIN"):
            peer = self.connect()
            sent = 0
            try:
                peer.sendall(greeting(mechanism))
                peer.sendall(b"\x04\x19\x05READY\x0bSocket-Type\0\0\0\6DEALER")
                for _ in range(2000):
                    peer.sendall(b"\x01\xff" + bytes(255) * 1)
                    sent += 257
            except OSError:
                pass
            self.assertTrue(self.is_closed(peer, 6), mechanism)
        self.assert_unharmed()

    def test_half_a_proof_without_end(self):
        # A real HELLO, for the right server key, and then silence or rubbish: the deadline holds.
        folder = self.user("mallory")
        peers = [secured(zmq.DEALER, folder, self.endpoint) for _ in range(30)]
        for peer in peers:
            self.addCleanup(peer.close)
            with contextlib.suppress(zmq.Again):  # already thrown out
                peer.send_multipart([b"SC1", b'{"id":"a","op":"ping"}', b"{}"], zmq.DONTWAIT)
        time.sleep(1)
        self.assertFalse(any(peer.poll(0) for peer in peers))
        self.assert_unharmed()

    def test_closing_and_opening_without_pause(self):
        # Descriptors are given back; a stale event meets no new connection.
        files = self.open_files()
        for k in range(1500):
            peer = socket.create_connection(("127.0.0.1", self.port + k % 3), timeout=5)
            if k % 2:
                peer.sendall(greeting()[: k % 64])
            if k % 5 == 0:
                peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            peer.close()
        self.assert_unharmed()
        end = time.monotonic() + 10
        while self.open_files() > files + 3 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLessEqual(self.open_files(), files + 3)


if __name__ == "__main__":
    unittest.main()
