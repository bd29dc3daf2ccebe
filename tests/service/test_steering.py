# SPDX-License-Identifier: GPL-3.0-or-later
"""Steering: what each command does, when, and that doing it again does nothing."""
import glob
import json
import os
import signal
import subprocess
import tempfile
import time
import unittest
import uuid

from model import tiny
from raw import BIN, PATIENCE_S, Daemon, Refused

LONG = tiny(end_s=1000, record={"basal_force": {"every_s": 1e-4, "chunk": 100}})


class Steering(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))

    def start(self, **how):
        daemon = Daemon(folder=self.folder, **how)
        self.addCleanup(daemon.stop, signal.SIGKILL)
        self.control = daemon.control
        return daemon

    def running(self, spec=None):
        job = self.control.submit(spec or LONG, again=True)
        self.control.wait(job, states=("running",))
        return job

    def refused(self, code, op, **body):
        with self.assertRaises(Refused) as refused:
            self.control.ask(op, body)
        self.assertEqual(refused.exception.code, code, refused.exception)
        return refused.exception

    def test_set_takes_effect_at_the_step_it_names(self):
        self.start()
        job = self.running()
        answer = self.control.ask("set", {"job": job, "set": ["params.slope_deg=21.5", "material.mu_t=0.3"]})
        record = self.control.ask("show", {"job": job})
        self.assertEqual((record["spec"]["params"]["slope_deg"], record["spec"]["material"]["mu_t"]), (21.5, 0.3))
        command, = record["steering"]
        self.assertEqual((command["op"], command["step"], command["set"]),
                         ("set", answer["step"], ["params.slope_deg=21.5", "material.mu_t=0.3"]))
        self.assertGreaterEqual(record["steps"], 0)

    def test_what_cannot_be_set_is_refused_by_name(self):
        self.start()
        job = self.running()
        for assignment, path in (("params.nx=5", "params.nx"), ("params.slope_deg=99", "params.slope_deg"),
                                 ("material.young_Pa=1e9", "material.young_Pa"), ("seed=2", "seed"),
                                 ("params.slpoe_deg=20", "params.slpoe_deg"), ("record.energy={}", "record.energy")):
            self.assertEqual(self.refused("invalid", "set", job=job, set=[assignment]).path, path)
        for wrong in ([], "params.slope_deg=20", [5], ["slope"], None):
            self.refused("invalid", "set", job=job, set=wrong)
        self.assertEqual(self.control.ask("show", {"job": job})["steering"], [])

    def test_the_same_request_is_the_same_command(self):
        # The reply was lost; the client asks again. After a restart, too.
        daemon = self.start()
        job, request = self.running(), uuid.uuid4().hex
        body = {"job": job, "set": ["params.slope_deg=22"]}
        first = self.control.ask("set", body, request=request)
        self.assertEqual(self.control.ask("set", body, request=request), first)
        fork = uuid.uuid4().hex
        child = self.control.ask("fork", {"job": job}, request=fork)
        self.assertEqual(self.control.ask("fork", {"job": job}, request=fork)["fork"], child["fork"])
        daemon.stop(signal.SIGKILL)
        self.start()
        self.assertEqual(self.control.ask("set", body, request=request)["step"], first["step"])
        self.assertEqual(self.control.ask("fork", {"job": job}, request=fork)["fork"], child["fork"])
        self.assertEqual(len(self.control.ask("list")["jobs"]), 2)

    def test_paused_job_frees_its_worker_and_goes_on_where_it_was(self):
        self.start()
        job = self.running(tiny(end_s=0.4))
        paused = self.control.ask("pause", {"job": job})
        self.assertEqual(paused["state"], "paused")
        other = self.control.submit(tiny(seed=7))
        self.control.wait(other, states=("done",))  # the only worker was free
        self.assertEqual(self.control.ask("pause", {"job": job})["state"], "paused")
        self.assertIsNone(self.control.ask("pause", {"job": job})["number"])
        self.assertEqual(self.control.ask("show", {"job": job})["steps"], paused["step"])
        self.assertEqual(self.control.ask("resume", {"job": job})["state"], "queued")
        record = self.control.wait(job)
        undisturbed = self.control.wait(self.control.submit(tiny(end_s=0.4), again=True))
        self.assertEqual((record["hash"], record["steps"]), (undisturbed["hash"], undisturbed["steps"]))

    def test_paused_stays_paused_over_a_restart(self):
        daemon = self.start()
        job = self.running()
        step = self.control.ask("pause", {"job": job})["step"]
        daemon.stop(signal.SIGKILL)
        self.start()
        record = self.control.ask("show", {"job": job})
        self.assertEqual((record["state"], record["steps"]), ("paused", step))

    def test_commands_for_a_paused_job_wait_for_it(self):
        self.start()
        job = self.running(tiny(end_s=0.25))
        step = self.control.ask("pause", {"job": job})["step"]
        self.assertIsNone(self.control.ask("set", {"job": job, "set": ["params.slope_deg=29"]})["step"])
        self.assertEqual(self.control.ask("show", {"job": job})["spec"]["params"]["slope_deg"], 26)
        self.control.ask("resume", {"job": job})
        record = self.control.wait(job)
        self.assertEqual(record["spec"]["params"]["slope_deg"], 29)
        self.assertEqual([c["step"] for c in record["steering"] if c["op"] == "set"], [step])

    def test_the_same_value_twice_waits_twice(self):
        # The second is no change to the first, which waits, but is one to the world: it must not slip past it.
        self.start()
        job = self.running(tiny(end_s=0.25))
        self.control.ask("pause", {"job": job})
        for _ in range(2):
            self.assertIsNone(self.control.ask("set", {"job": job, "set": ["params.slope_deg=29"]})["step"])
        self.assertEqual(self.control.ask("show", {"job": job})["spec"]["params"]["slope_deg"], 26)

    def test_queued_job_can_be_set_and_paused(self):
        self.start()
        self.running()
        job = self.control.submit(tiny(seed=3))
        self.control.ask("set", {"job": job, "set": ["time.end_s=0.02"]})
        self.assertEqual(self.control.ask("pause", {"job": job})["state"], "paused")
        self.refused("conflict", "fork", job=job)  # there is no state to continue
        self.control.ask("cancel", {"job": job})
        self.assertEqual(self.control.ask("show", {"job": job})["state"], "cancelled")

    def test_priority_is_for_the_queue(self):
        self.start()
        blocker = self.running()
        first, second = self.control.submit(tiny(seed=3)), self.control.submit(tiny(seed=4))
        self.control.ask("set", {"job": second, "set": ["priority=5"]})
        self.control.ask("cancel", {"job": blocker})
        for job in (first, second):
            self.control.wait(job)
        started = [self.control.ask("show", {"job": job})["started"] for job in (first, second)]
        self.assertGreater(started[0], started[1])

    def test_fork_goes_on_beside_its_parent(self):
        self.start(workers=2)
        parent = self.running(tiny(end_s=0.25))
        answer = self.control.ask("fork", {"job": parent, "set": ["params.slope_deg=20", "time.end_s=0.2"]})
        child = self.control.wait(answer["fork"])
        record = self.control.wait(parent)
        self.assertEqual((child["state"], record["state"]), ("done", "done"))
        self.assertEqual(child["origin"]["fork"]["step"], answer["step"])
        self.assertEqual((child["spec"]["params"]["slope_deg"], child["steps"]), (20, 800_000))
        undisturbed = self.control.wait(self.control.submit(tiny(end_s=0.25), again=True))
        self.assertEqual(record["hash"], undisturbed["hash"])  # it has not noticed
        self.refused("conflict", "fork", job=parent)

    def test_unchanged_fork_ends_in_its_parents_bits(self):
        self.start()
        parent = self.running(tiny(end_s=0.2))
        child = self.control.ask("fork", {"job": parent})["fork"]
        self.assertEqual(self.control.wait(child)["hash"], self.control.wait(parent)["hash"])

    def test_fork_of_a_paused_job_starts_from_its_checkpoint(self):
        self.start()
        parent = self.running(tiny(end_s=0.25))
        step = self.control.ask("pause", {"job": parent})["step"]
        answer = self.control.ask("fork", {"job": parent, "set": ["time.end_s=0.225"]})
        self.assertEqual(answer["step"], step)
        self.assertEqual(self.control.wait(answer["fork"])["steps"], 900_000)
        self.assertEqual(self.control.ask("show", {"job": parent})["state"], "paused")

    def test_end_can_be_moved_both_ways(self):
        self.start()
        job = self.running(tiny(end_s=1000))
        self.control.ask("set", {"job": job, "set": ["time.end_s=1e-3"]})  # in the past: it ends here
        record = self.control.wait(job)
        self.assertEqual(record["state"], "done")
        self.assertLess(record["steps"], 4e8)

    def test_ended_jobs_are_not_steered(self):
        self.start()
        job = self.control.submit(tiny())
        self.control.wait(job)
        for op in ("pause", "resume", "checkpoint", "fork"):
            self.refused("conflict", op, job=job)
        self.refused("conflict", "set", job=job, set=["params.slope_deg=20"])
        self.refused("not_found", "pause", job="j99")

    def test_replay_of_a_steered_and_of_a_cancelled_job(self):
        self.start()
        job = self.running(tiny(end_s=1000))
        for slope in (28, 22):
            self.control.ask("set", {"job": job, "set": [f"params.slope_deg={slope}"]})
            time.sleep(0.1)
        self.refused("conflict", "replay", job=job)
        self.control.ask("cancel", {"job": job})
        first = self.control.wait(job)
        replay = self.control.wait(self.control.ask("replay", {"job": job})["job"])
        self.assertEqual((replay["hash"], replay["steps"], replay["origin"]["replay"]["same"]), (first["hash"], first["steps"], True))
        self.assertEqual([c["step"] for c in replay["steering"]], [c["step"] for c in first["steering"] if c["op"] == "set"])

    def test_replay_of_a_job_cancelled_where_a_command_was_its_last_deed(self):
        self.start()
        for slope in range(20, 28):
            job = self.running(tiny(end_s=1000))
            command = {"job": job, "set": [f"params.slope_deg={slope}"]}
            self.control.socket.send_multipart([b"SC1", b'{"id": "set", "op": "set"}', json.dumps(command).encode()])
            self.control.ask("cancel", {"job": job})  # with the command, before the next slice
            first = self.control.wait(job)
            replay = self.control.wait(self.control.ask("replay", {"job": job})["job"])
            self.assertEqual((replay["hash"], replay["steps"]), (first["hash"], first["steps"]))

    def test_a_different_run_is_seen_in_the_hash(self):
        self.start()
        records = [self.control.wait(self.control.submit(tiny(seed=seed))) for seed in (1, 2)]
        self.assertNotEqual(records[0]["hash"], records[1]["hash"])

    def test_a_steered_job_does_not_answer_for_its_first_spec(self):
        self.start()
        job = self.running(tiny(end_s=0.2))
        self.control.ask("set", {"job": job, "set": ["params.slope_deg=28"]})
        self.control.wait(job)
        self.assertNotEqual(self.control.submit(tiny(end_s=0.2)), job)

    # ---- checkpoints ----

    def checkpoints(self, job):
        return sorted(glob.glob(os.path.join(self.folder, "data", "jobs", job, "checkpoint-*.h5")))

    def test_clock_writes_checkpoints_and_keeps_two(self):
        self.start(options=("--checkpoint-s", "0.1"))
        job = self.running()
        end, seen = time.monotonic() + 30, set()
        while len(seen) < 5:
            assert time.monotonic() < end, seen
            seen.update(self.checkpoints(job))
            self.assertLessEqual(len(self.checkpoints(job)), 3)  # one may just be on its way out
            time.sleep(0.02)
        self.control.ask("cancel", {"job": job})
        self.control.wait(job)
        self.assertEqual(self.checkpoints(job), [])  # nothing goes on from an ended job

    def test_sigterm_leaves_a_checkpoint_of_the_very_step(self):
        daemon = self.start(options=("--checkpoint-s", "0"))
        job = self.running()
        time.sleep(0.3)
        begin = time.monotonic()
        self.assertEqual(daemon.stop(signal.SIGTERM), 0)
        self.assertLess(time.monotonic() - begin, 10)
        newest, = self.checkpoints(job)
        daemon = self.start()
        self.control.wait(job, states=("running",))
        end = time.monotonic() + 20
        while f"{job} resumed at step={int(os.path.basename(newest).split('-')[1])}" not in daemon.log():
            assert time.monotonic() < end, daemon.log()
            time.sleep(0.05)

    def test_checkpoint_is_there_when_it_is_answered(self):
        self.start(options=("--checkpoint-s", "0"))
        job = self.running()
        step = self.control.ask("checkpoint", {"job": job})["step"]
        self.assertEqual(int(os.path.basename(self.checkpoints(job)[-1]).split("-")[1]), step)

    # ---- holds ----

    def test_job_that_does_not_fit_the_memory_waits(self):
        self.start(workers=2, options=("--memory", "0.0001"))  # 100 kB
        small = self.running()  # 33 grains
        large = self.control.submit(tiny(params={"nx": 10, "ny": 10, "nz": 1}))
        record = self.control.wait(large, states=("held",))
        self.assertRegex(record["why"], r"^needs 0 MB of memory, 0 MB to be had$")
        self.control.ask("cancel", {"job": small})
        self.control.ask("cancel", {"job": large})
        self.assertEqual(self.control.wait(large)["state"], "cancelled")

    # ---- log ----

    def test_sighup_opens_the_log_anew(self):
        log, moved = os.path.join(self.folder, "log"), os.path.join(self.folder, "log.1")
        daemon = self.start(options=("--log", log))
        os.rename(log, moved)
        daemon.process.send_signal(signal.SIGHUP)
        end = time.monotonic() + 10
        while not os.path.exists(log):
            assert time.monotonic() < end
            time.sleep(0.02)
        self.control.wait(self.control.submit(tiny()))
        with open(log) as file:
            self.assertIn("state=done", file.read())
        with open(moved) as file:
            self.assertNotIn("state=done", file.read())

    # ---- client ----

    def scree(self, *arguments):
        return subprocess.run([os.path.join(BIN, "scree"), *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False,
                              env={**os.environ, "SCREE_RUNTIME": os.path.join(self.folder, "run")}, stdin=subprocess.DEVNULL)

    def test_verbs(self):
        self.start(workers=2)
        job = self.running(tiny(end_s=1000))
        self.assertRegex(self.scree("set", job, "params.slope_deg=28").stdout, rf"^{job} step \d+\n$")
        wrong = self.scree("set", job, "params.nx=4")
        self.assertEqual((wrong.returncode, wrong.stdout), (2, ""))
        self.assertIn("params.nx", wrong.stderr)
        child = self.scree("fork", job, "--set", "time.end_s=1e-3").stdout.strip()
        self.assertRegex(child, r"^j\d+$")
        self.assertEqual(self.scree("pause", job).stdout, f"{job} paused\n")
        self.assertEqual(self.scree("checkpoint", job).stdout, f"{job} paused\n")
        self.assertEqual(self.scree("resume", job).stdout, f"{job} queued\n")
        self.assertEqual(self.scree("set", job, "time.end_s=1e-3").returncode, 0)  # in the past: it ends where it is
        self.assertEqual(self.scree("wait", job, child).returncode, 0)
        replay = self.scree("replay", job)
        self.assertEqual(replay.returncode, 0, replay)
        self.assertIn("the same bits", replay.stdout)
        self.assertIn("params.slope_deg=28", self.scree("show", job).stdout)
        tail = self.scree("tail", job, "basal_force", "--verify")
        self.assertEqual(tail.returncode, 0)
        self.assertIn("verified", tail.stderr)
        self.assertEqual(self.scree("pause", job).returncode, 2)


if __name__ == "__main__":
    unittest.main()
