# SPDX-License-Identifier: GPL-3.0-or-later
"""The protocol page against the daemon: a client that shares no code with scree
submits, reads streams with credit, and compares them with result.h5."""
import base64
import json
import os
import random
import time
import unittest
import uuid

import h5py
import numpy
import zmq

from raw import Control, Daemon, Refused, crc32c

# Small, but long enough for the grains to land: a force trace of zeros would
# compare equal whatever was wrong. 2,400 samples in 24 chunks.
FLOW = {
    "scenario": "incline",
    "params": {"nx": 4, "ny": 4, "nz": 3},
    "time": {"end_s": 0.06},
    "stop": {"when": []},
    "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}, "snapshots": {"every_s": 0.02}},
}
CHUNK_BYTES = 100 * 3 * 8
QUICK = {**FLOW, "time": {"end_s": 0.001}, "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 16}}}
LONG = {**FLOW, "time": {"end_s": 1000}}  # hours: for what must be stopped
CODES = {"invalid", "bad_request", "not_found", "busy", "denied", "conflict", "io", "no_memory", "corrupt", "blowup", "cancelled",
         "internal"}
SILENCE_S = 0.5  # how long nothing must come


def different(spec, **params):
    """The same job with other params: a spec of its own."""
    return {**spec, "params": {**spec["params"], **params}}


class RawClient(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.remove)
        cls.addClassCleanup(cls.daemon.stop)
        cls.control = cls.daemon.control
        cls.job = cls.control.submit(FLOW)
        # Read live, from the first chunk on, paying for two chunks at a time.
        streams = cls.daemon.streams()
        cls.addClassCleanup(streams.close)
        cls.chunks, cls.end = streams.read_all("live", cls.job, "basal_force", grant=2 * CHUNK_BYTES)
        cls.record = cls.control.wait(cls.job, states=("done",))

    def setUp(self):
        self.assertTrue(self.daemon.alive(), self.daemon.log())
        self.streams = self.daemon.streams()
        self.addCleanup(self.streams.close)

    def refused(self, code, op, body=None):
        with self.assertRaises(Refused) as caught:
            self.control.ask(op, body)
        self.assertEqual(caught.exception.code, code, caught.exception)
        self.assertTrue(caught.exception.message)
        return caught.exception

    def assert_lives(self):
        self.assertEqual(self.control.ask("ping")["pid"], self.daemon.process.pid, self.daemon.log())

    # ---- control ----

    def test_ping_tells_where_everything_is(self):
        # A client that knows only the control endpoint finds the rest through ping.
        about = self.control.ask("ping")
        self.assertEqual(about["protocol"], "SC1")
        self.assertEqual(about["pid"], self.daemon.process.pid)
        self.assertEqual(about["workers"], 1)
        self.assertEqual(about["data_dir"], self.daemon.data)
        self.assertTrue(about["version"] and about["isa"].startswith("x86-64-v"), about)
        self.assertGreaterEqual(about["uptime_s"], 0)
        for name in ("stream_endpoint", "events_endpoint"):
            self.assertTrue(about[name].startswith("ipc://"), about)
        self.assertEqual(set(about["jobs"]), {"queued", "running", "paused", "done", "failed", "cancelled", "held"})

    def test_show_has_every_field_of_the_page(self):
        # Scripts rely on the names; the numbers say that the run was the one asked for.
        record = self.record
        for name in ("id title scenario state verdict time_s end_s progress steps grains grain_steps_per_s eta_s submitted started "
                     "ended spec streams build isa threads evidence numbers error result why").split():
            self.assertIn(name, record)
        self.assertEqual((record["id"], record["state"], record["scenario"]), (self.job, "done", "incline"))
        self.assertEqual((record["steps"], record["error"]), (240000, None))
        self.assertGreaterEqual(record["grains"], 48)
        self.assertAlmostEqual(record["time_s"], 0.06, places=12)
        self.assertGreater(record["grain_steps_per_s"], 0)
        self.assertLessEqual(record["submitted"], record["started"])
        self.assertLessEqual(record["started"], record["ended"])
        self.assertEqual(record["streams"]["basal_force"]["frames"], False)
        self.assertEqual(record["streams"]["snapshots"]["frames"], True)
        self.assertTrue(all(set(number) == {"name", "value", "unit", "doc"} for number in record["numbers"]))
        self.assertGreater(len(record["numbers"]), 5)

    def test_repeated_submit_is_one_job(self):
        # A client that saw no reply sends again: also at once, and over a new connection.
        request, spec = uuid.uuid4().hex, different(QUICK, base_seed=11)
        header = json.dumps({"id": request, "op": "submit"}).encode()
        body = json.dumps({"spec": spec}).encode()
        for _ in range(2):
            self.control.socket.send_multipart([b"SC1", header, body])
        replies = [self.control.reply() for _ in range(2)]
        other = Control(self.daemon.endpoint)
        self.addCleanup(other.close)
        jobs = {reply["result"]["job"] for reply in replies} | {other.submit(spec, request=request)}
        self.assertEqual(len(jobs), 1, jobs)

    def test_finished_spec_answers_with_its_result(self):
        # The resolved spec counts, not its spelling; `again` insists on a new run.
        spelt = different(FLOW, slope_deg=23.5)
        answer = self.control.ask("submit", {"spec": spelt})
        self.assertEqual((answer["job"], answer["reused"], answer["state"]), (self.job, True, "done"))
        spec = different(QUICK, base_seed=12)
        first = self.control.submit(spec)
        self.control.wait(first, states=("done",))
        answer = self.control.ask("submit", {"spec": spec, "again": True})
        self.assertFalse(answer["reused"])
        self.assertNotEqual(answer["job"], first)

    def test_resolved_spec_is_a_fixed_point(self):
        # What is echoed can be submitted again and means the same.
        resolved = self.control.ask("check", {"spec": FLOW})["spec"]
        self.assertEqual(self.control.ask("check", {"spec": resolved})["spec"], resolved)
        self.assertEqual(resolved, self.record["spec"])

    def test_check_estimates_the_cost(self):
        # Users decide by it whether to submit.
        cost = self.control.ask("check", {"spec": FLOW})["cost"]
        self.assertEqual((cost["moving"], cost["steps"]), (48, 240000))
        self.assertEqual(cost["grain_steps"], 48 * 240000)
        self.assertGreater(cost["fixed"], 0)
        self.assertGreater(cost["bytes"], 0)
        self.assertGreater(cost["seconds"], 0)

    def test_bad_specs_are_refused_and_leave_nothing(self):
        before = [job["id"] for job in self.control.ask("list")["jobs"]]
        error = self.refused("invalid", "submit", {"spec": different(FLOW, slope_deg=123)})
        self.assertEqual(error.path, "params.slope_deg")
        self.assertIn("123", error.message)
        self.assertIn("0..60 deg", error.message)
        error = self.refused("invalid", "submit", {"spec": different(FLOW, slop_deg=20)})
        self.assertIn("slope_deg", error.message + error.hint)
        self.refused("invalid", "submit", {"spec": {"params": {}}})
        self.refused("invalid", "submit", {"spec": {**FLOW, "time": {"step_s": 1e-5}}})
        self.refused("invalid", "submit", {"spec": different(FLOW, nx=1)})
        self.refused("no_memory", "submit", {"spec": different(FLOW, nx=2000, ny=2000, nz=7)})
        for body in ({}, {"spec": 3}, {"spec": [FLOW]}, {"spec": None}):
            self.assertIn(self.refused_code("submit", body), ("invalid", "bad_request"), body)
        self.assertEqual([job["id"] for job in self.control.ask("list")["jobs"]], before)

    def refused_code(self, op, body):
        with self.assertRaises(Refused) as caught:
            self.control.ask(op, body)
        return caught.exception.code

    def test_unknown_jobs_are_not_found(self):
        for name in ("j999999", "j0", "x", "", "j18446744073709551617", "../../etc/passwd"):
            for op in ("show", "cancel", "fetch"):
                self.refused("not_found", op, {"job": name})

    def test_missing_or_mistyped_arguments_are_refused(self):
        for body in ({}, {"job": 3}, {"job": None}, {"job": [self.job]}):
            for op in ("show", "cancel", "fetch"):
                self.assertIn(self.refused_code(op, body), ("bad_request", "invalid", "not_found"), (op, body))
        self.assertIn(self.refused_code("list", {"limit": "x"}), ("bad_request", "invalid"))
        self.assertIn(self.refused_code("list", {"states": ["asleep"]}), ("bad_request", "invalid"))

    def test_unknown_operations_are_bad_requests(self):
        self.refused("bad_request", "dance")
        self.refused("bad_request", "")

    def test_list_is_newest_first_and_can_be_narrowed(self):
        late = self.control.submit(different(QUICK, base_seed=13))
        self.control.wait(late)
        jobs = [job["id"] for job in self.control.ask("list")["jobs"]]
        numbers = [int(job[1:]) for job in jobs]
        self.assertEqual(numbers, sorted(numbers, reverse=True))
        self.assertEqual([job["id"] for job in self.control.ask("list", {"limit": 1})["jobs"]], jobs[:1])
        done = self.control.ask("list", {"states": ["done"]})["jobs"]
        self.assertIn(self.job, [job["id"] for job in done])
        self.assertEqual({job["state"] for job in done}, {"done"})

    def test_cancel_stops_running_and_queued_and_is_idempotent(self):
        # One worker: the second job waits behind the first.
        running, queued = (self.control.submit(different(LONG, base_seed=seed)) for seed in (14, 15))
        self.control.wait(running, states=("running",))
        self.assertEqual(self.control.ask("show", {"job": queued})["state"], "queued")
        for job in (queued, running):
            self.control.ask("cancel", {"job": job})
            self.assertEqual(self.control.wait(job)["state"], "cancelled")
            self.assertEqual(self.control.ask("cancel", {"job": job}), {"job": job, "state": "cancelled"})
        # An ended job stays what it was.
        self.assertEqual(self.control.ask("cancel", {"job": self.job})["state"], "done")

    def test_malformed_requests_get_an_error(self):
        good = json.dumps({"id": "x1", "op": "ping"}).encode()
        cases = [
            [b"SC1", good],
            [b"SC1", good, b"{}", b"{}"],
            [b"SC1"],
            [b""],
            [b"SC2", good, b"{}"],
            [b"SC1", b"", b"{}"],
            [b"SC1", b"{", b"{}"],
            [b"SC1", b"[]", b"{}"],
            [b"SC1", b"\xff\xfe", b"{}"],
            [b"SC1", b'{"id": "x1"}', b"{}"],
            [b"SC1", b'{"id": "x1", "id": "x2", "op": "ping"}', b"{}"],
            [b"SC1", b'{"id": "a b", "op": "ping"}', b"{}"],
            [b"SC1", json.dumps({"id": "y" * 65, "op": "ping"}).encode(), b"{}"],
            [b"SC1", json.dumps({"id": 3, "op": "ping"}).encode(), b"{}"],
            [b"SC1", good, b""],
            [b"SC1", good, b"[]"],
            [b"SC1", good, b'{"a": NaN}'],
            [b"SC1", good, b'{"a": 1, "a": 2}'],
            [b"SC1", good, b'{"a": 1e400}'],
            [b"SC1", good, b"{} x"],
            [b"SC1", good, b"[" * 5000],
        ]
        for frames in cases:
            reply = self.control.frames(frames)
            self.assertEqual((reply["ok"], reply["error"]["code"]), (False, "bad_request"), (frames, reply))
            self.assertEqual(set(reply["error"]), {"code", "path", "message", "hint"})
        # The id is given back where it can be read.
        self.assertEqual(self.control.frames([b"SC1", good, b"[]"])["id"], "x1")
        self.assertEqual(self.control.frames([b"SC1", b"{", b"{}"])["id"], "")

    def test_oversize_frames_are_refused_and_harmless(self):
        client = Control(self.daemon.endpoint)
        self.addCleanup(client.close)
        reply = client.frames([b"SC1", b'{"id": "big", "op": "ping"}', b'{"a": "' + b"x" * (1 << 20) + b'"}'])
        self.assertEqual((reply["ok"], reply["error"]["code"]), (False, "bad_request"))
        # Far beyond the limit the daemon may hang up, but it goes on for everybody else.
        client.socket.send_multipart([b"SC1", b'{"id": "huge", "op": "ping"}', b"x" * (64 << 20)])
        client.socket.poll(500)
        self.assert_lives()

    def test_noise_on_both_sockets_is_survived(self):
        # Fixed seed: a failure can be repeated.
        noise = random.Random(20240229)
        client = Control(self.daemon.endpoint)
        self.addCleanup(client.close)
        seeds = [b"SC1", b'{"id":"n1","op":"show"}', b'{"op":"open","key":"n","job":"j1","stream":"basal_force","from":0}',
                 b'{"op":"credit","key":"n","bytes":100000}', b'{"job":"j1"}', b"{}"]
        for _ in range(400):
            frames = []
            for _ in range(noise.randrange(1, 5)):
                frame = bytearray(noise.choice(seeds))
                for _ in range(noise.randrange(0, 4)):
                    if frame:
                        frame[noise.randrange(len(frame))] = noise.randrange(256)
                frames.append(bytes(frame))
            client.socket.send_multipart(frames)
            self.streams.socket.send_multipart(frames)
        self.assert_lives()
        self.assertEqual(self.control.ask("show", {"job": self.job})["state"], "done")

    # ---- streams ----

    def test_live_chunks_are_gapless_and_whole(self):
        self.assertEqual([header["seq"] for header, _ in self.chunks], list(range(24)))
        samples = 0
        for header, payload in self.chunks:
            self.assertEqual((header["job"], header["stream"], header["dtype"]), (self.job, "basal_force", "<f8"))
            self.assertEqual((header["columns"], header["units"]), (["Fx", "Fy", "Fz"], ["N", "N", "N"]))
            self.assertEqual(len(payload), header["n"] * 3 * 8)
            self.assertEqual(header["crc32c"], crc32c(payload), header["seq"])
            self.assertAlmostEqual(header["dt_s"], 2.5e-5, places=15)
            # A block average belongs to the end of its block.
            self.assertAlmostEqual(header["t0_s"], (samples + 1) * 2.5e-5, places=12)
            samples += header["n"]
        self.assertEqual(samples, 2400)
        self.assertEqual((self.end["op"], self.end["chunks"], self.end["state"]), ("end", 24, "done"))
        told = self.record["streams"]["basal_force"]
        self.assertEqual((told["chunks"], told["samples"]), (24, 2400))

    def test_stream_equals_the_result_file_to_the_bit(self):
        live = numpy.frombuffer(b"".join(payload for _, payload in self.chunks), "<f8").reshape(-1, 3)
        self.assertGreater(numpy.count_nonzero(live[:, 2]), 100, "the grains never landed: nothing was compared")
        place = self.control.ask("fetch", {"job": self.job})
        self.assertTrue(place["complete"])
        with h5py.File(place["path"], "r") as result:
            stored = result["/observables/basal_force/value"]
            self.assertEqual(stored.attrs["unit"], b"N" if isinstance(stored.attrs["unit"], bytes) else "N")
            self.assertEqual(stored[...].astype("<f8").tobytes(), live.tobytes())
            self.assertEqual(result["/observables/basal_force/time"][()], self.chunks[0][0]["dt_s"])

    def test_frames_equal_the_result_file_to_the_bit(self):
        # Frames are streams too: a row a grain, one chunk an instant, dt_s 0.
        chunks, end = self.streams.read_all("frames", self.job, "snapshots")
        self.assertEqual(end["chunks"], len(chunks))
        self.assertGreaterEqual(len(chunks), 3)
        place = self.control.ask("fetch", {"job": self.job})
        with h5py.File(place["path"], "r") as result:
            position = result["/particles/grains/position/value"]
            for k, (header, payload) in enumerate(chunks):
                self.assertEqual(header["dt_s"], 0)
                rows = numpy.frombuffer(payload, "<f8").reshape(header["n"], -1)
                columns = [header["columns"].index(name) for name in ("x", "y", "z")]
                self.assertEqual(position[k].tobytes(), numpy.ascontiguousarray(rows[:, columns]).tobytes())
                self.assertEqual(result["/particles/grains/position/time"][k], header["t0_s"])

    def test_late_joiner_gets_the_same_bytes(self):
        # Past and present are one code path.
        late, end = self.streams.read_all("late", self.job, "basal_force", start=3, grant=1)
        self.assertEqual([header["seq"] for header, _ in late], list(range(3, 24)))
        self.assertEqual([payload for _, payload in late], [payload for _, payload in self.chunks[3:]])
        self.assertEqual(end["chunks"], 24)

    def test_open_at_the_end_of_an_ended_job_just_ends(self):
        # What a reader does that comes back after it saw everything but the end.
        chunks, end = self.streams.read_all("tip", self.job, "basal_force", start=24)
        self.assertEqual((chunks, end["chunks"], end["state"]), ([], 24, "done"))

    def test_without_credit_nothing_is_sent(self):
        self.streams.open("poor", self.job, "basal_force")
        self.assertIsNone(self.streams.message(SILENCE_S, alive=True))

    def test_no_more_is_sent_than_was_granted(self):
        self.streams.open("meagre", self.job, "basal_force")
        self.streams.credit("meagre", 2 * CHUNK_BYTES + CHUNK_BYTES // 2)
        self.assertEqual([self.streams.message()[0]["seq"] for _ in range(2)], [0, 1])
        self.assertIsNone(self.streams.message(SILENCE_S, alive=True))
        # The half left over counts: half a chunk more pays for one.
        self.streams.credit("meagre", CHUNK_BYTES // 2)
        self.assertEqual(self.streams.message()[0]["seq"], 2)
        self.assertIsNone(self.streams.message(SILENCE_S, alive=True))

    def test_a_chunk_larger_than_the_grant_still_moves(self):
        # Else a reader with a small buffer would wait for ever.
        self.streams.open("small", self.job, "basal_force")
        self.streams.credit("small", 1)
        self.assertEqual(self.streams.message()[0]["seq"], 0)
        self.assertIsNone(self.streams.message(SILENCE_S, alive=True))

    def test_several_subscriptions_share_a_connection(self):
        for key, start in (("a", 0), ("b", 10)):
            self.streams.open(key, self.job, "basal_force", start)
            self.streams.credit(key, 1 << 20)
        seen, ended = {"a": [], "b": []}, set()
        while ended != {"a", "b"}:
            header, payload = self.streams.message()
            if header["op"] == "end":
                ended.add(header["key"])
            else:
                self.assertEqual(payload, self.chunks[header["seq"]][1])
                seen[header["key"]].append(header["seq"])
        self.assertEqual(seen, {"a": list(range(24)), "b": list(range(10, 24))})

    def test_closed_subscription_falls_silent(self):
        self.streams.open("shut", self.job, "basal_force")
        self.streams.send(op="close", key="shut")
        self.streams.credit("shut", 1 << 20)
        got = self.streams.message(SILENCE_S, alive=True)
        self.assertTrue(got is None or got[0]["op"] == "error", got)

    def test_bad_opens_are_refused(self):
        for body, codes in (
            ({"job": "j999999", "stream": "basal_force"}, {"not_found"}),
            ({"job": self.job, "stream": "weather"}, {"not_found"}),
            ({"job": self.job, "stream": "basal_force", "from": 25}, CODES),
            ({"job": self.job, "stream": "basal_force", "from": -1}, CODES),
            ({"job": self.job, "stream": "basal_force", "from": 1.5}, CODES),
            ({"job": self.job, "stream": "basal_force", "from": "0"}, CODES),
            ({"job": self.job}, CODES),
            ({"stream": "basal_force"}, CODES),
        ):
            self.streams.send(op="open", key="bad", **body)
            self.streams.credit("bad", 1 << 20)
            header, _ = self.streams.message()
            self.assertEqual((header["op"], header["key"]), ("error", "bad"), body)
            self.assertIn(header["error"]["code"], codes, body)
            while self.streams.message(0.1):  # what the credit for a subscription that is gone may bring
                pass

    def test_malformed_stream_messages_leave_other_subscriptions_alone(self):
        self.streams.open("good", self.job, "basal_force")
        for frames in ([b"SC1"], [b""], [b"SC1", b"{"], [b"SC2", b"{}"], [b"SC1", b"{}", b"more"], [b"SC1", b'{"op": "dance"}'],
                       [b"SC1", b'{"op": "credit", "key": "good", "bytes": -5}'],
                       [b"SC1", b'{"op": "credit", "key": "good", "bytes": 1e300}'],
                       [b"SC1", b'{"op": "credit", "key": "nobody", "bytes": 5}'], [b"SC1", b"x" * (1 << 20)]):
            self.streams.socket.send_multipart(frames)
        other = self.daemon.streams()
        self.addCleanup(other.close)
        chunks, _ = other.read_all("other", self.job, "basal_force")
        self.assertEqual(len(chunks), 24)
        self.assert_lives()

    def test_reader_that_vanishes_costs_nothing(self):
        # It granted much and never reads: the job must end all the same.
        spec = different(FLOW, base_seed=16)
        job = self.control.submit(spec)
        dead = self.daemon.streams()
        dead.open("dead", job, "basal_force")
        dead.credit("dead", 64 << 20)
        time.sleep(0.05)
        dead.close()
        self.assertEqual(self.control.wait(job)["state"], "done")
        chunks, _ = self.streams.read_all("after", job, "basal_force")
        self.assertEqual(len(chunks), 24)

    def test_vanished_readers_hold_nothing(self):
        # Readers that open, pay nothing and go: neither descriptors nor places may stay taken.
        def descriptors():
            return len(os.listdir(f"/proc/{self.daemon.process.pid}/fd"))

        patient = self.daemon.streams()
        self.addCleanup(patient.close)
        patient.open("patient", self.job, "basal_force")
        before, end = 0, time.monotonic() + 1
        while time.monotonic() < end:  # until the daemon has heard of the patient one, which takes a descriptor
            before = max(before, descriptors())
            time.sleep(0.02)
        for _ in range(20):
            reader = self.daemon.streams()
            for key in range(10):
                reader.open(f"k{key}", self.job, "basal_force")
            reader.socket.close(linger=1000)
        end = time.monotonic() + 40
        while descriptors() > before and time.monotonic() < end:
            time.sleep(0.2)
        self.assertLessEqual(descriptors(), before)
        # One that only waits is told that the daemon lives, and is served when it pays.
        header, _ = patient.message(alive=True)
        self.assertEqual((header["op"], header["key"]), ("alive", "patient"))
        patient.credit("patient", CHUNK_BYTES)
        self.assertEqual(patient.message()[0]["seq"], 0)

    # ---- events and results ----

    def test_events_tell_of_states(self):
        # Hints may be lost, but on a quiet local socket the end of a job is heard.
        events = zmq.Context.instance().socket(zmq.SUB)
        self.addCleanup(events.close, linger=0)
        events.connect(self.daemon.about["events_endpoint"])
        events.subscribe(b"job/")
        time.sleep(0.3)
        job = self.control.submit(different(QUICK, base_seed=17))
        states, end = [], time.monotonic() + 30
        while "done" not in states and time.monotonic() < end:
            if events.poll(500):
                topic, text = events.recv_multipart()
                hint = json.loads(text)
                if topic == f"job/{job}/state".encode():
                    self.assertEqual(hint["job"], job)
                    states.append(hint["state"])
        self.assertIn("done", states)

    def test_result_can_be_fetched_over_the_wire(self):
        # For clients that do not share the daemon's file system.
        place = self.control.ask("fetch", {"job": self.job})
        data = b""
        while len(data) < place["bytes"]:
            part = self.control.ask("fetch_part", {"job": self.job, "offset": len(data), "bytes": 30000})
            piece = base64.b64decode(part["data"], validate=True)
            self.assertEqual((part["offset"], part["bytes"], part["total"]), (len(data), len(piece), place["bytes"]))
            self.assertGreater(len(piece), 0)
            data += piece
        with open(place["path"], "rb") as file:
            self.assertEqual(file.read(), data)
        self.assertEqual(self.control.ask("fetch_part", {"job": self.job, "offset": len(data), "bytes": 10})["bytes"], 0)
        for body in ({"offset": -1, "bytes": 10}, {"offset": 0, "bytes": -1}, {"offset": 1e30, "bytes": 1}, {"offset": 0.5, "bytes": 1}):
            self.assertIn(self.refused_code("fetch_part", {"job": self.job, **body}), CODES - {"internal"}, body)

    def test_running_job_can_be_fetched(self):
        # The result so far: readable while the simulation goes on.
        job = self.control.submit(different(LONG, base_seed=18))
        self.addCleanup(self.control.ask, "cancel", {"job": job})
        end = time.monotonic() + 60
        while self.control.ask("show", {"job": job})["streams"].get("basal_force", {}).get("chunks", 0) < 2:
            self.assertLess(time.monotonic(), end, "no chunks within a minute")
            time.sleep(0.05)
        place = self.control.ask("fetch", {"job": job})
        self.assertFalse(place["complete"])
        with h5py.File(place["path"], "r") as result:
            rows = result["/observables/basal_force/value"][...]
        self.assertGreaterEqual(len(rows), 200)
        self.streams.open("head", job, "basal_force")
        self.streams.credit("head", 2 * CHUNK_BYTES)
        payload = b"".join(self.streams.message()[1] for _ in range(2))
        self.assertEqual(rows[:200].tobytes(), payload)
        self.assertEqual(self.control.ask("show", {"job": job})["state"], "running")


if __name__ == "__main__":
    unittest.main()
