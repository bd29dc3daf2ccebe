# SPDX-License-Identifier: GPL-3.0-or-later
"""The one-file client for scripts, on Debian's python3-zmq and python3-numpy."""
import ast
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import h5py
import numpy

from raw import BIN, Daemon

SOURCE = os.environ["SCREE_SOURCE"]
FOLDER = os.path.join(SOURCE, "client", "python")
sys.path.insert(0, FOLDER)
import scree  # noqa: E402 pylint: disable=wrong-import-position

FLOW = {
    "scenario": "incline",
    "params": {"nx": 4, "ny": 4, "nz": 3},
    "time": {"end_s": 0.06},
    "stop": {"when": []},
    "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}},
}
LONGER = {**FLOW, "time": {"end_s": 0.4}}


class Scripts(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        self.server = self.start()

    def start(self):
        daemon = Daemon(folder=self.folder)
        self.addCleanup(daemon.stop, signal.SIGKILL)
        return daemon

    def connect(self, **how):
        daemon = scree.connect(self.server.endpoint, **how)
        self.addCleanup(daemon.close)
        return daemon

    def test_submit_stream_wait_fetch(self):
        # The whole of a script: what came live is what the result holds.
        job = self.connect().submit(FLOW)
        pieces = list(job.stream("basal_force"))
        times, force = (numpy.concatenate(part) for part in zip(*pieces))
        self.assertEqual(force.shape, (2400, 3))
        numpy.testing.assert_allclose(numpy.diff(times), 2.5e-5, rtol=1e-9)
        self.assertGreater(numpy.abs(force).max(), 0)
        self.assertEqual(job.wait(timeout_s=60)["state"], "done")
        path = job.fetch(os.path.join(self.folder, "out.h5"))
        with h5py.File(path) as file:
            numpy.testing.assert_array_equal(file["observables/basal_force/value"][:], force)
        self.assertEqual([n for n in os.listdir(self.folder) if ".part" in n], [])

    def test_stream_survives_kills_without_a_gap(self):
        # The promise of the page: numbers go on, bytes are those of an undisturbed reader.
        job = self.connect(patience_s=60).submit(LONGER)
        seen, values, killed = [], [], 0
        for chunk in job.chunks("basal_force"):
            seen.append(chunk.seq)
            values.append(chunk.values.copy())
            if len(seen) in (5, 60):
                killed += 1
                self.server.stop(signal.SIGKILL)
                self.server = self.start()
        self.assertEqual(killed, 2)
        self.assertEqual(seen, list(range(160)))
        again = numpy.concatenate([v for _, v in self.connect().job(job.id).stream("basal_force")])
        numpy.testing.assert_array_equal(numpy.concatenate(values), again)

    def test_requests_survive_a_restart(self):
        # wait() started before the daemon went and came.
        job = self.connect(patience_s=60).submit(LONGER)
        records = []
        waiting = threading.Thread(target=lambda: records.append(job.wait(timeout_s=120)))
        waiting.start()
        self.server.stop()
        self.server = self.start()
        waiting.join(120)
        self.assertEqual([r["state"] for r in records], ["done"])

    def test_start_in_the_middle(self):
        # A script that was restarted itself goes on where it was.
        job = self.connect().submit(FLOW)
        job.wait()
        self.assertEqual([c.seq for c in job.chunks("basal_force", start=20)], [20, 21, 22, 23])

    def test_refusals_carry_code_and_path(self):
        # What a script can act on.
        daemon = self.connect()
        with self.assertRaises(scree.Refused) as caught:
            daemon.submit({"scenario": "incline", "params": {"slope_deg": 123}})
        self.assertEqual((caught.exception.code, caught.exception.path), ("invalid", "params.slope_deg"))
        with self.assertRaises(scree.Refused) as caught:
            daemon.job("j99")
        self.assertEqual(caught.exception.code, "not_found")
        with self.assertRaises(scree.Refused) as caught:
            list(daemon.submit(FLOW).stream("no_such"))
        self.assertEqual(caught.exception.code, "not_found")

    def test_a_cancelled_job_is_no_success(self):
        # wait() must not return as if all were well.
        job = self.connect().submit({**FLOW, "time": {"end_s": 1000}})
        job.cancel()
        with self.assertRaises(scree.Ended) as caught:
            job.wait(timeout_s=60)
        self.assertEqual(caught.exception.record["state"], "cancelled")
        self.assertEqual(job.wait(check=False)["state"], "cancelled")

    def test_no_daemon_is_told_in_time(self):
        # A script does not hang.
        with self.assertRaises(scree.Unreachable):
            scree.connect("ipc://" + os.path.join(self.folder, "nobody"), patience_s=0.5)

    def test_python_3_9_can_read_it(self):
        # The oldest that is promised.
        for name in ("scree.py", "examples/live_spectrum.py"):
            with open(os.path.join(FOLDER, name), encoding="utf-8") as file:
                ast.parse(file.read(), feature_version=(3, 9))

    def test_live_spectrum_example(self):
        # White noise has a flat one; here it must only come, and be that of the force: Parseval.
        path = os.path.join(self.folder, "job.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(FLOW, file)
        ended = subprocess.run([sys.executable, os.path.join(FOLDER, "examples", "live_spectrum.py"), path, "--connect",
                                self.server.endpoint, "--segment", "256"], capture_output=True, text=True, timeout=120, check=False,
                               env={**os.environ, "PYTHONPATH": FOLDER})
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertIn("N^2/Hz", ended.stdout)
        sys.path.insert(0, os.path.join(FOLDER, "examples"))
        import live_spectrum  # pylint: disable=import-outside-toplevel,import-error
        noise = numpy.random.default_rng(1).normal(0, 3, 200000)
        welch = live_spectrum.Welch(1024)
        for piece in numpy.array_split(noise, 77):
            welch.add(piece, 0.01)
        frequency = numpy.fft.rfftfreq(1024, 0.01)
        self.assertAlmostEqual(welch.density()[1:-1].sum() * frequency[1], 9, delta=0.2)


class OverTheNetwork(unittest.TestCase):
    def test_curve(self):
        # With keys from files, the same; with a stranger's, an error that says why it may be.
        folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        keys = os.path.join(folder, "keys")
        command = os.path.join(BIN, "scree")
        for name in ("server", "client", "stranger"):
            subprocess.run([command, "keygen", name], env={**os.environ, "SCREE_KEYS": keys}, check=True, capture_output=True)
        subprocess.run([command, "trust", os.path.join(keys, "client.pub"), "--role", "submit"],
                       env={**os.environ, "SCREE_KEYS": keys}, check=True, capture_output=True)
        port = 20000 + os.getpid() % 30000
        server = Daemon(options=("--listen", f"tcp://0.0.0.0:{port}", "--keys", keys))
        self.addCleanup(server.remove)
        self.addCleanup(server.stop)
        names = {"key": os.path.join(keys, "client.key"), "server_key": os.path.join(keys, "server.pub")}
        daemon = scree.connect(f"tcp://127.0.0.1:{port}", **names)
        self.addCleanup(daemon.close)
        job = daemon.submit(FLOW)
        self.assertEqual(sum(len(t) for t, _ in job.stream("basal_force")), 2400)
        self.assertGreater(os.path.getsize(job.fetch(os.path.join(folder, "out.h5"))), 1000)
        with self.assertRaisesRegex(scree.Unreachable, "trust"):
            scree.connect(f"tcp://127.0.0.1:{port}", patience_s=1, key=os.path.join(keys, "stranger.key"),
                          server_key=names["server_key"])


if __name__ == "__main__":
    unittest.main()
