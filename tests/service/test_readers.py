# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of every kind beside a running job: late, slow, dead, stopped. Nothing is
lost, memory stays flat, and (measured with SCREE_SLOW, on an idle machine) the
simulation's rate per second of its own processor time changes by less than 2 %."""
import glob
import os
import signal
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time
import unittest

from model import SLOW, tiny
from raw import SANITIZED, Daemon, chunk_hash

READERS = 200 if SLOW else 24
ROUNDS = 7 if SLOW else 1
WINDOW_S = 5 if SLOW else 2
SPEC = tiny(end_s=1000, params={"nx": 6, "ny": 6, "nz": 6}, record={"basal_force": {"every_s": 1e-5, "chunk": 64}})


class Readers(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        self.daemon = Daemon(folder=self.folder, options=("--checkpoint-s", "0"))
        self.addCleanup(self.daemon.stop, signal.SIGKILL)
        self.job = self.daemon.control.submit(SPEC)
        while self.daemon.control.ask("show", {"job": self.job})["steps"] == 0:
            time.sleep(0.05)
        self.all = []
        self.addCleanup(lambda: [streams.close() for streams in self.all])

    def memory(self):
        with open(f"/proc/{self.daemon.process.pid}/status") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024

    def worked(self):
        """Nanoseconds of processor time of the worker."""
        for task in glob.glob(f"/proc/{self.daemon.process.pid}/task/*"):
            with open(task + "/comm") as name, open(task + "/schedstat") as times:
                if name.read() == "worker\n":
                    return int(times.read().split()[0])
        raise AssertionError("no worker")

    def chunks(self):
        """How many the log has: what the daemon says of itself is as old as its last look."""
        with sqlite3.connect(os.path.join(self.daemon.data, "jobs", self.job, "streams.db")) as log:
            count, = log.execute("SELECT MAX(seq) FROM chunks WHERE stream = 'basal_force'").fetchone()
        log.close()
        return count

    def rate(self, seconds):
        """Chunks a second of the worker's own time."""
        def both():
            return self.chunks(), self.worked()
        done, used = both()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.pump()
        more, later = both()
        return (more - done) / (later - used)

    def pump(self):
        """Those that read do so."""
        for k, streams in enumerate(self.all):
            if k % 4 == 0:
                while got := streams.message(0):
                    streams.credit("k", len(got[1]))
        time.sleep(0.02)

    def open(self, count):
        for k in range(count):
            streams = self.daemon.streams()
            streams.open("k", self.job, "basal_force")
            if k % 4 != 1:  # those that never pay
                streams.credit("k", (1 << 14, 0, 1 << 26, 1 << 26)[k % 4])
            self.all.append(streams)
            if k % 4 == 3:  # paid and died
                streams.close()
                self.all[-1] = self.daemon.streams()

    def test_they_cost_the_simulation_nothing(self):
        ratios, before = [], self.memory()
        for _ in range(ROUNDS):
            alone = self.rate(WINDOW_S)
            self.open(READERS)
            ratios.append(self.rate(WINDOW_S) / alone)
            for streams in self.all:
                streams.close()
            self.all.clear()
        grown = self.memory() - before
        sys.stderr.write(f"{READERS} readers: rate x {statistics.median(ratios):.3f}, memory + {grown:.1f} MB\n")
        if not SANITIZED:  # which keep what was freed
            self.assertLess(grown, 20 + 0.5 * READERS)  # 256 chunks of 2 kB wait for one who has paid and does not read
        if SLOW:
            self.assertGreater(statistics.median(ratios), 0.98)

    def test_reader_behind_a_stopped_process_loses_nothing(self):
        # A client that is stopped and goes on finds every chunk, and the daemon has not waited for it.
        child = subprocess.Popen(
            [os.path.join(os.environ["SCREE_BIN"], "scree"), "--connect", self.daemon.endpoint, "tail", self.job, "basal_force",
             "--format", "ndjson", "--verify"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(child.wait)
        self.addCleanup(child.kill)
        self.addCleanup(child.stdout.close)
        child.stdout.readline()
        child.send_signal(signal.SIGSTOP)
        steps = self.daemon.control.ask("show", {"job": self.job})["steps"]
        time.sleep(1)
        self.assertGreater(self.daemon.control.ask("show", {"job": self.job})["steps"], steps)
        child.send_signal(signal.SIGCONT)
        self.daemon.control.ask("set", {"job": self.job, "set": ["time.end_s=1e-3"]})
        self.daemon.control.wait(self.job)
        lines = child.stdout.read().count("\n") + 1
        self.assertEqual(child.wait(60), 0)
        self.assertEqual(lines, self.daemon.control.ask("show", {"job": self.job})["streams"]["basal_force"]["chunks"])

    def test_late_reader_sees_all_from_the_first_chunk(self):
        time.sleep(0.5)
        streams = self.daemon.streams()
        self.all.append(streams)
        streams.open("k", self.job, "basal_force")
        streams.credit("k", 1 << 26)
        value = 0
        for seq in range(40):
            header, payload = streams.message()
            self.assertEqual(header["seq"], seq)
            value = chunk_hash(value, header, payload)
            self.assertEqual(header["hash"], f"{value:016x}")


if __name__ == "__main__":
    unittest.main()
