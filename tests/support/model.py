# SPDX-License-Identifier: GPL-3.0-or-later
"""A client that keeps a history, and the judge of it.

Every request has an id and is sent again, to whichever daemon is alive, until it
is answered: so everything that was asked for was acknowledged once, and what the
daemon must know at the end follows from the history alone. `Session.judge` looks
whether it does: no acknowledged thing lost or doubled, no stream with a gap or a
change, every final state equal to that of a run that nothing disturbed."""
import json
import os
import random
import signal
import time
import uuid

from raw import PATIENCE_S, Daemon, Refused, chunk_hash, crc32c, receive

FAULTS = os.environ.get("SCREE_FAULTS", "")
SLOW = bool(os.environ.get("SCREE_SLOW"))
ENDED = ("done", "failed", "cancelled")


def tiny(seed=1, end_s=0.05, **more):
    """A job of some tenths of a second."""
    return {
        "scenario": "incline",
        "seed": seed,
        "params": {"nx": 3, "ny": 3, "nz": 2, "slope_deg": 26},
        "time": {"end_s": end_s},
        "stop": {"when": []},
        "record": {"basal_force": {"every_s": 1e-5, "chunk": 128}, "snapshots": {"every_s": 0.004}},
        **more,
    }


class Job:
    """What the history says of a job."""

    def __init__(self, name):
        self.name = name
        self.commands = {}  # number: (op, step or None, assignments)
        self.cancelled = False
        self.paused = False
        self.read = []  # (header, payload) of its basal force, as far as somebody has read


class Session:
    def __init__(self, folder, workers=2, options=("--checkpoint-s", "0.1"), **environment):
        self.folder, self.workers, self.options = folder, workers, options
        self.daemon = None
        self.jobs = {}
        self.deaths = 0
        self.start(**environment)

    def start(self, **environment):
        """A daemon; with variables one that faults are injected into."""
        faulty = {**environment, "LD_PRELOAD": FAULTS} if environment else {}
        self.daemon = Daemon(folder=self.folder, workers=self.workers, options=self.options, environment=faulty)

    def kill(self):
        self.daemon.stop(signal.SIGKILL)

    def revive(self):
        """Another daemon where the last one fell over."""
        self.deaths += 1
        if self.daemon.alive():
            self.kill()
        elif self.daemon.control:
            self.daemon.control.close()
        self.start()

    def ask(self, op, body, patience_s=20, silence_s=3):
        """The answer, whoever gives it in the end."""
        request = uuid.uuid4().hex
        end = time.monotonic() + patience_s
        while True:
            if (reply := self.ask_once(op, body, request, silence_s)) is not None:
                if not reply["ok"]:
                    raise Refused(reply["error"])
                return reply["result"]
            if not self.daemon.alive():
                self.revive()
            assert time.monotonic() < end, f"{op} {body} was not answered\n" + self.daemon.log()

    def ask_once(self, op, body, request, silence_s):
        """The reply, or None when the daemon is dead or silent."""
        if not self.daemon.alive():
            return None
        socket = self.daemon.control.socket
        socket.send_multipart([b"SC1", json.dumps({"id": request, "op": op}).encode(), json.dumps(body).encode()])
        end = time.monotonic() + silence_s
        while time.monotonic() < end:
            frames = receive(socket, 0.02)
            if frames and (reply := json.loads(frames[1]))["id"] == request:
                return reply
            if not frames and not self.daemon.alive():
                return None
        return None

    def wait_all(self, timeout_s=20):
        """Until every job has ended, or the daemon has."""
        end = time.monotonic() + timeout_s
        for name in list(self.jobs):
            while self.daemon.alive() and time.monotonic() < end:
                reply = self.ask_once("show", {"job": name}, uuid.uuid4().hex, 3)
                if reply and reply["ok"] and reply["result"]["state"] in ENDED:
                    break
                time.sleep(0.02)

    # ---- what a client does ----

    def submit(self, spec):
        name = self.ask("submit", {"spec": spec, "again": True})["job"]
        assert name not in self.jobs, f"{name} was given away twice"
        self.jobs[name] = Job(name)
        return name

    def steer(self, op, name, assignments=None):
        """The answer, or None when the job has ended."""
        job = self.jobs[name]
        body = {"job": name, **({"set": assignments} if assignments is not None else {})}
        try:
            answer = self.ask(op, body)
        except Refused as refused:
            assert refused.code == "conflict", refused
            return None
        if answer["number"] is not None:
            assert answer["number"] not in job.commands, answer
            job.commands[answer["number"]] = (op, answer["step"], assignments or [])
        if op in ("pause", "resume"):
            job.paused = op == "pause"
        if op == "fork" and answer["fork"]:
            assert answer["fork"] not in self.jobs
            self.jobs[answer["fork"]] = Job(answer["fork"])
        return answer

    def cancel(self, name):
        if self.ask("show", {"job": name})["state"] not in ENDED:
            answer = self.ask("cancel", {"job": name})
            self.jobs[name].cancelled = answer["state"] != "done"  # it may just have come to its end

    def look(self, name):
        """The record; what was paused stays so."""
        record = self.ask("show", {"job": name})
        if self.jobs[name].paused:
            assert record["state"] == "paused", record
        return record

    def read(self, name, patience_s=0.05):
        """Reads on in a job's stream for a moment."""
        job = self.jobs[name]
        streams = self.daemon.streams()
        try:
            streams.open("k", name, "basal_force", len(job.read))
            streams.credit("k", 1 << 20)
            end = time.monotonic() + patience_s
            while (left := end - time.monotonic()) > 0 and (got := streams.message(left)):
                if got[0]["op"] == "chunk":
                    job.read.append(got)
        finally:
            streams.close()

    # ---- the judge ----

    def judge(self, replays=None, timeout_s=2 * PATIENCE_S):
        if not self.daemon.alive():
            self.revive()
        control = self.daemon.control
        for job in self.jobs.values():
            if job.paused:
                self.steer("resume", job.name)
        left = list(self.jobs.values())
        while left:
            job = left.pop()
            record = control.wait(job.name, timeout_s=timeout_s)
            self.judge_record(job, record)
            left += self.late_forks(job, record)
        known = set(self.jobs)
        listed = [entry["id"] for entry in control.ask("list", {"limit": 100000})["jobs"]]
        assert len(listed) == len(set(listed)) and set(listed) == known, (sorted(listed), sorted(known))
        for job in self.jobs.values():
            self.judge_stream(job)
        chosen = sorted(self.jobs)
        random.Random(1).shuffle(chosen)
        for name in chosen[:replays]:
            self.judge_state(name, timeout_s)

    def late_forks(self, job, record):
        """Forks that were acknowledged as waiting for a job that did not run, and made later: their parent's record names them."""
        late = [command["fork"] for command in record["steering"]
                if command["op"] == "fork" and "fork" in command and job.commands[command["number"]][1] is None]
        for name in late:
            assert name not in self.jobs, f"{name} was given away twice"
            self.jobs[name] = Job(name)
        return [self.jobs[name] for name in late]

    def judge_record(self, job, record):
        expected = ("cancelled", "done") if job.cancelled else ("done",)
        assert record["state"] in expected, (expected, record["error"], record)
        assert record["error"] is None, record
        there = {command["number"]: command for command in record["steering"]}
        assert len(there) == len(record["steering"]), record["steering"]
        for number, (op, step, assignments) in job.commands.items():
            command = there.pop(number)
            assert command["op"] == op and command.get("set", []) == assignments, (command, op, assignments)
            # Acknowledged with a step: that step for ever. Acknowledged as waiting: since then given one, or too late.
            assert command["step"] == step if step is not None else (command["step"] is not None or command["void"]), command
        for command in there.values():  # cancels are not known by their numbers; what was refused had no effect
            assert command["op"] == "cancel" or (command["void"] and command["step"] is None), command

    def judge_stream(self, job):
        streams = self.daemon.streams()
        try:
            chunks, end = streams.read_all("all", job.name, "basal_force")
        except Refused as refused:
            assert refused.code == "not_found" and job.cancelled and not job.read, refused  # it never began
            return
        finally:
            streams.close()
        value = 0
        for seq, (header, payload) in enumerate(chunks):
            assert header["seq"] == seq and crc32c(payload) == header["crc32c"], header
            value = chunk_hash(value, header, payload)
            assert f"{value:016x}" == header["hash"], (header, f"{value:016x}")
        assert end["chunks"] == len(chunks)
        for (seen, payload), (header, stored) in zip(job.read, chunks, strict=False):
            assert payload == stored and seen["hash"] == header["hash"], (seen, header)
        assert len(job.read) <= len(chunks)

    def judge_state(self, name, timeout_s):
        """A replay runs from the start, undisturbed, and must come to the same bits."""
        control = self.daemon.control
        if control.ask("show", {"job": name})["hash"] is None:
            return  # cancelled, and the daemon fell before its last state was known
        replay = control.ask("replay", {"job": name})["job"]
        record = control.wait(replay, timeout_s=timeout_s)
        assert record["state"] == "done" and record["origin"]["replay"]["same"], record

    def close(self):
        if self.daemon.alive():
            self.daemon.stop()
        elif self.daemon.control:
            self.daemon.control.close()
            self.daemon.control = None
