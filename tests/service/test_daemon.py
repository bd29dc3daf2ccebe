# SPDX-License-Identifier: GPL-3.0-or-later
"""The daemon's life: what it refuses to start with, and that stopping or killing
it loses no job and changes no bit."""
import os
import signal
import socket
import stat
import subprocess
import tempfile
import time
import unittest

from raw import BIN, Control, Daemon, Refused

SCREED = os.path.join(BIN, "screed")
# Long enough to be stopped in the middle of.
FLOW = {
    "scenario": "incline",
    "params": {"nx": 4, "ny": 4, "nz": 4},
    "time": {"end_s": 0.4},
    "stop": {"when": []},
    "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}, "snapshots": {"every_s": 0.02}},
}
COLLISION = {"scenario": "collision"}


def screed(*arguments, timeout_s=60, **environment):
    """Runs it to its end, which must come by itself."""
    return subprocess.run([SCREED, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout_s,
                          env={**os.environ, **environment}, check=False)


class DaemonLife(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))

    def start(self, **how):
        daemon = Daemon(folder=self.folder, **how)
        self.addCleanup(daemon.stop, signal.SIGKILL)
        return daemon

    def path(self, name):
        return os.path.join(self.folder, name)

    # ---- refusals ----

    def test_network_endpoint_that_is_none_is_refused(self):
        # Streams and events take the two ports after it, so that the last two are too high.
        for endpoint in ("tcp://127.0.0.1", "tcp://127.0.0.1:0", "tcp://:5999", "tcp://127.0.0.1:65534", "tcp://127.0.0.1:5999x"):
            ended = screed("--listen", endpoint, "--data", self.path("data"), "--runtime", self.path("run"))
            self.assertEqual(ended.returncode, 2, ended)
            self.assertIn(endpoint, ended.stderr)

    def test_second_daemon_on_the_same_data_refuses(self):
        # Two would write one journal.
        first = self.start()
        ended = screed("--data", first.data, "--runtime", self.path("other"))
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn(first.data, ended.stderr)
        self.assertEqual(first.control.ask("ping")["pid"], first.process.pid)

    def test_second_daemon_in_the_same_runtime_directory_refuses(self):
        # Else it would take the first one's sockets away.
        first = self.start()
        ended = screed("--data", self.path("other"), "--runtime", first.runtime)
        self.assertNotEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(first.control.ask("ping")["pid"], first.process.pid)

    def test_of_two_that_start_at_once_one_serves(self):
        # The other must not take the sockets away between being started and finding out.
        for k in range(8):
            runtime, data = self.path(f"run{k}"), self.path(f"data{k}")
            both = [subprocess.Popen([SCREED, "--data", data, "--runtime", runtime], stdin=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL) for _ in range(2)]
            for one in both:
                self.addCleanup(one.wait)
                self.addCleanup(one.kill)
            end = time.monotonic() + 60
            while all(one.poll() is None for one in both) and time.monotonic() < end:
                time.sleep(0.01)
            ended, left = sorted(both, key=lambda one: one.poll() is None)
            self.assertEqual((ended.poll(), left.poll()), (75, None))
            control = Control(f"ipc://{runtime}/control")
            self.addCleanup(control.close)
            self.assertEqual(control.ask("ping")["pid"], left.pid)

    def test_runtime_directory_is_for_the_owner_only(self):
        daemon = self.start()
        self.assertEqual(stat.S_IMODE(os.stat(daemon.runtime).st_mode), 0o700)

    def test_open_runtime_directory_is_refused(self):
        # Whoever can write there can put a socket of their own in place.
        os.mkdir(self.path("run"))
        os.chmod(self.path("run"), 0o755)
        ended = screed("--data", self.path("data"), "--runtime", self.path("run"))
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("755", ended.stderr)
        self.assertEqual(stat.S_IMODE(os.stat(self.path("run")).st_mode), 0o755)

    def test_config_errors_name_their_line(self):
        config = self.path("screed.conf")
        for text, line, word in (("# fine\nworkers = 1\nwrokers = 2\n", ":3", "wrokers"), ("workers = many\n", ":1", "many"),
                                 ("workers 3\n", ":1", "=")):
            with open(config, "w") as file:
                file.write(text)
            ended = screed("--config", config, "--data", self.path("data"), "--runtime", self.path("run"))
            self.assertEqual(ended.returncode, 2, ended)
            self.assertIn(config + line, ended.stderr)
            self.assertIn(word, ended.stderr)

    def test_usage_errors(self):
        for arguments in (("--wrokers", "1"), ("--workers", "0"), ("--workers", "x"), ("--workers",), ("stray",), ("--listen", "x")):
            ended = screed(*arguments)
            self.assertEqual(ended.returncode, 2, (arguments, ended))
            self.assertTrue(ended.stderr.strip(), arguments)
            self.assertEqual(ended.stdout, "")

    def test_unwritable_data_is_refused(self):
        with open(self.path("file"), "w"):
            pass
        ended = screed("--data", self.path("file/data"), "--runtime", self.path("run"))
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn(self.path("file"), ended.stderr)

    def test_help_and_version_go_to_stdout(self):
        for option, word in (("--help", "usage"), ("--version", "0.")):
            ended = screed(option)
            self.assertEqual((ended.returncode, ended.stderr), (0, ""))
            self.assertIn(word, ended.stdout)

    # ---- endings ----

    def test_shutdown_ends_it_cleanly(self):
        daemon = self.start()
        self.assertEqual(daemon.control.ask("shutdown", {}), {})
        self.assertEqual(daemon.process.wait(30), 0, daemon.log())

    def test_sigterm_ends_it_within_seconds_of_a_running_job(self):
        daemon = self.start()
        job = daemon.control.submit({**FLOW, "time": {"end_s": 1000}})
        daemon.control.wait(job, states=("running",))
        begin = time.monotonic()
        self.assertEqual(daemon.stop(signal.SIGTERM), 0, daemon.log())
        self.assertLess(time.monotonic() - begin, 20)

    def test_it_ends_with_its_parent(self):
        # A client that is killed must not leave its private daemon behind.
        parent = subprocess.Popen(["sleep", "600"])
        self.addCleanup(parent.wait)
        self.addCleanup(parent.kill)
        daemon = self.start(options=("--parent", str(parent.pid)))
        parent.kill()
        parent.wait()
        daemon.process.wait(30)

    def test_ready_is_written_once_clients_can_connect(self):
        ours, theirs = os.pipe()
        self.addCleanup(os.close, ours)
        process = subprocess.Popen([SCREED, "--data", self.path("data"), "--runtime", self.path("run"), "--ready-fd", str(theirs)],
                                   pass_fds=[theirs], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertEqual(os.read(ours, 100), b"ready\n")
        with socket.socket(socket.AF_UNIX) as probe:
            probe.connect(self.path("run/control"))

    # ---- starts again ----

    def stop_in_the_middle(self, number):
        """Bytes of a job's streams, its daemon ended by the signal in mid-run and started again."""
        daemon = self.start()
        job = daemon.control.submit(FLOW)
        streams = daemon.streams()
        streams.open("head", job, "basal_force")
        streams.credit("head", 1)
        seen = streams.message()  # the job has begun, and a reader has had something of it
        streams.close()
        state = daemon.control.ask("show", {"job": job})["state"]
        daemon.stop(number)
        self.assertEqual(state, "running", "the job ended before it could be interrupted")
        daemon = self.start()
        self.assertEqual(daemon.control.wait(job)["state"], "done")
        return seen, self.read(daemon, job)

    def read(self, daemon, job):
        streams = daemon.streams()
        try:
            return {name: streams.read_all(name, job, name)[0] for name in ("basal_force", "bulk", "snapshots", "grains")}
        finally:
            streams.close()

    def bare(self, chunks):
        return [(header["seq"], header["t0_s"], header["n"], header["crc32c"], payload) for header, payload in chunks]

    def compare_with_undisturbed(self, number):
        seen, interrupted = self.stop_in_the_middle(number)
        with tempfile.TemporaryDirectory(prefix="scree-test-") as folder:
            daemon = Daemon(folder=folder)
            self.addCleanup(daemon.stop, signal.SIGKILL)
            job = daemon.control.submit(FLOW)
            self.assertEqual(daemon.control.wait(job)["state"], "done")
            undisturbed = self.read(daemon, job)
            daemon.stop()
        self.assertEqual(len(undisturbed["basal_force"]), 160)
        for name, chunks in undisturbed.items():
            self.assertEqual(self.bare(interrupted[name]), self.bare(chunks), name)
        # What a reader saw before the interruption still stands under its number.
        self.assertEqual(self.bare([seen]), self.bare(undisturbed["basal_force"][:1]))

    def test_stopped_job_finishes_after_restart_with_the_same_bits(self):
        self.compare_with_undisturbed(signal.SIGTERM)

    def test_killed_job_finishes_after_restart_with_the_same_bits(self):
        self.compare_with_undisturbed(signal.SIGKILL)

    def test_queued_and_done_jobs_survive_a_kill(self):
        # A submit that was acknowledged is on disk.
        daemon = self.start()
        done = daemon.control.submit(COLLISION)
        before = daemon.control.wait(done, states=("done",))
        running = daemon.control.submit({**FLOW, "time": {"end_s": 1000}})
        queued = daemon.control.submit(FLOW)
        daemon.stop(signal.SIGKILL)
        daemon = self.start()
        after = daemon.control.ask("show", {"job": done})
        for name in ("state", "spec", "numbers", "streams", "submitted", "ended", "steps", "result"):
            self.assertEqual(after[name], before[name], name)
        self.assertIn(daemon.control.ask("show", {"job": queued})["state"], ("queued", "running"))
        daemon.control.ask("cancel", {"job": running})
        self.assertEqual(daemon.control.wait(queued)["state"], "done")

    def test_request_ids_are_remembered_across_a_restart(self):
        # The retry may come after the daemon fell over between commit and reply.
        daemon = self.start()
        job = daemon.control.submit(COLLISION, request="once")
        daemon.control.wait(job)
        daemon.stop(signal.SIGKILL)
        daemon = self.start()
        self.assertEqual(daemon.control.submit({**COLLISION, "seed": 5}, request="once"), job)

    def test_job_numbers_are_never_used_twice(self):
        daemon = self.start()
        first = daemon.control.submit(COLLISION)
        daemon.control.wait(first)
        daemon.stop()
        daemon = self.start()
        second = daemon.control.submit(COLLISION | {"seed": 2}, again=True)
        self.assertGreater(int(second[1:]), int(first[1:]))

    def test_cancelled_job_does_not_run_again(self):
        # Cancel was answered; that the daemon ends at once after it changes nothing.
        for number in (signal.SIGTERM, signal.SIGKILL):
            daemon = self.start()
            job = daemon.control.submit({**FLOW, "time": {"end_s": 1000}, "seed": int(number)})
            daemon.control.wait(job, states=("running",))
            daemon.control.ask("cancel", {"job": job})
            daemon.stop(number)
            daemon = self.start()
            self.assertEqual(daemon.control.ask("show", {"job": job})["state"], "cancelled")
            daemon.stop()

    def test_paths_are_told_so_that_any_client_finds_them(self):
        process = subprocess.Popen([SCREED, "--data", "data", "--runtime", "run"], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        control = Control("ipc://" + self.path("run/control"))
        self.addCleanup(control.close)
        about = control.ask("ping")
        self.assertEqual(about["data_dir"], self.path("data"))
        self.assertEqual(about["stream_endpoint"], "ipc://" + self.path("run/stream"))
        record = control.wait(control.submit(COLLISION))
        self.assertTrue(os.path.isabs(record["result"]) and os.path.exists(record["result"]), record["result"])

    def test_result_of_a_cancelled_job_is_kept(self):
        daemon = self.start()
        job = daemon.control.submit({**FLOW, "time": {"end_s": 1000}})
        daemon.control.wait(job, states=("running",))
        time.sleep(0.5)
        daemon.control.ask("cancel", {"job": job})
        record = daemon.control.wait(job)
        self.assertEqual(record["state"], "cancelled")
        place = daemon.control.ask("fetch", {"job": job})
        self.assertGreater(os.path.getsize(place["path"]), 0)
        with self.assertRaises(Refused):
            daemon.control.ask("show", {"job": "j77"})


if __name__ == "__main__":
    unittest.main()
