# SPDX-License-Identifier: GPL-3.0-or-later
"""Many at once: a queue of ten thousand jobs, a thousand readers of one stream. Sizes
and times of the slow version; the fast one runs the same paths."""
import glob
import os
import random
import signal
import statistics
import sys
import tempfile
import time
import unittest

from model import SLOW, tiny
from raw import PATIENCE_S, Daemon, chunk_hash, crc32c

JOBS = 10000 if SLOW else 300
READERS = 1000 if SLOW else 60
SOAK_S = 600 if SLOW else 4
OPERATIONS_MS = 50  # what 99 of 100 requests stay under, not counting time in which daemon or client wait for a processor


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def on_the_way(process):
    """Threads that a request passes: the first one and ZeroMQ's."""
    for task in glob.glob(f"/proc/{process}/task/*"):
        with open(task + "/comm") as file:
            if task.endswith(f"/{process}") or file.read().startswith("ZMQbg/IO"):
                yield task


def waited_ms(tasks):
    """How long these threads have been ready to run and had to wait: other people's work."""
    total = 0
    for task in tasks:
        with open(task + "/schedstat") as file:
            total += int(file.read().split()[1])
    return total / 1e6


class Load(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))

    def daemon(self, **how):
        daemon = Daemon(folder=self.folder, **how)
        self.addCleanup(daemon.stop, signal.SIGKILL)
        return daemon

    def memory(self, daemon):
        with open(f"/proc/{daemon.process.pid}/status") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024

    def test_long_queue_stays_quick(self):
        """Submit, list, show and cancel beside a queue that nobody could work off; every job is there after a restart."""
        daemon = self.daemon()
        control = daemon.control
        blocker = control.submit(tiny(end_s=1e4))
        took, names, waits = {"submit": [], "list": [], "show": [], "cancel": []}, [], 0
        tasks = [*on_the_way(daemon.process.pid), *on_the_way(os.getpid())]

        def timed(op, body):
            nonlocal waits
            before, started = waited_ms(tasks), time.monotonic()
            answer = control.ask(op, body)
            waited = waited_ms(tasks) - before
            took[op].append(max(0, 1000 * (time.monotonic() - started) - waited))
            waits += waited
            return answer

        rng = random.Random(1)
        for k in range(JOBS):
            names.append(timed("submit", {"spec": tiny(seed=k + 2)})["job"])
            if k % 10 == 0:
                timed("list", {"limit": 200})
                timed("show", {"job": rng.choice(names)})
        gone = rng.sample(names, JOBS // 10)
        for name in gone:
            self.assertEqual(timed("cancel", {"job": name})["state"], "cancelled")
        for op, values in took.items():
            sys.stderr.write(f"{JOBS} jobs queued, {op}: median {statistics.median(values):.2f} ms, "
                             f"99th percentile {percentile(values, 0.99):.2f} ms, most {max(values):.1f} ms\n")
        sys.stderr.write(f"memory {self.memory(daemon):.0f} MB; without {waits / 1000:.1f} s in all of waiting for a processor\n")
        if SLOW:
            for op, values in took.items():
                self.assertLess(percentile(values, 0.99), OPERATIONS_MS, op)
        daemon.stop(signal.SIGKILL)
        started = time.monotonic()
        control = self.daemon().control
        sys.stderr.write(f"started again in {time.monotonic() - started:.2f} s\n")
        listed = {job["id"]: job["state"] for job in control.ask("list", {"limit": 100000})["jobs"]}
        self.assertEqual(set(listed), {blocker, *names})
        self.assertEqual({name for name, state in listed.items() if state == "cancelled"}, set(gone))

    def test_readers_for_a_while(self):
        """A tenth of them have stopped, the others read: memory stays flat, and each sees a stream without a gap."""
        daemon = self.daemon(options=("--checkpoint-s", "5"))
        job = daemon.control.submit(tiny(end_s=1e4, params={"nx": 6, "ny": 6, "nz": 6},
                                         record={"basal_force": {"every_s": 1e-5, "chunk": 4096}}))
        readers = []
        for k in range(READERS):
            streams = daemon.streams()
            self.addCleanup(streams.close)
            streams.open("k", job, "basal_force")
            streams.credit("k", 1 << 18)
            readers.append([streams, 0, 0])
        end, levels, passes = time.monotonic() + SOAK_S, [], 0
        while time.monotonic() < end or (readers[1][1] == 0 and time.monotonic() < end + PATIENCE_S):
            for k, reader in enumerate(readers):
                while k % 10 and (got := reader[0].message(0)):
                    header, payload = got
                    if header["op"] != "chunk":
                        continue
                    self.assertEqual(header["seq"], reader[1])
                    self.assertEqual(crc32c(payload) if k == 1 else header["crc32c"], header["crc32c"])
                    reader[1] += 1
                    reader[2] = chunk_hash(reader[2], header, payload) if k == 1 else 0
                    reader[0].credit("k", len(payload))
            passes += 1
            levels.append(self.memory(daemon))
            time.sleep(0.05)
        third = len(levels) // 3
        early, late = statistics.median(levels[third:2 * third + 1]), statistics.median(levels[2 * third:])
        read = [reader[1] for k, reader in enumerate(readers) if k % 10]
        flat_mb = 8 if PATIENCE_S == 60 else 80  # a sanitizer keeps what is freed
        sys.stderr.write(f"{READERS} readers for {SOAK_S} s: chunks read by each {min(read)} to {max(read)}, "
                         f"memory {early:.0f} MB, then {late:.0f} MB\n")
        self.assertGreater(max(read), 0)
        self.assertLess(late - early, flat_mb)


if __name__ == "__main__":
    unittest.main()
