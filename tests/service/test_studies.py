# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies through the daemon: what they come to, that killing it loses and repeats
no trial, and how the client shows them."""
import base64
import contextlib
import csv
import io
import json
import os
import random
import signal
import sqlite3
import time
import unittest

import h5py
import numpy

from raw import PATIENCE_S, Daemon, Refused
import test_client
from test_client import Client
from test_locked import Keyed

# Soft beads, few of them, for a moment: a trial takes a fraction of a second. What has
# not come to rest by then counts as flowing.
FLOW = {"scenario": "incline", "params": {"nx": 2, "ny": 2, "nz": 2}, "material": {"young_Pa": 3e8, "beta_s": 4e-7},
        "time": {"step_s": 2e-6, "end_s": 0.9}, "record": {"basal_force": None}}
BISECT = {"study": "bisect", "over": "params.slope_deg", "low": 5, "high": 40, "raise_low_when": "rest", "digits": 2,
          "extend_to_s": 0.9, "undecided": "lower", "at_once": 1, "job": FLOW}
HIT = {"scenario": "collision"}
SWEEP = {"study": "sweep", "job": HIT, "grid": {"params.speed_m_s": [0.1, 0.2], "params.partner": ["sphere", "plane"]}, "replicas": 2}
# Foerster's spheres: 71.2 ns give a restitution of 0.97 (the paper's 45.1 ns do not, targets S0-11).
ROOT = {"study": "root", "over": "material.beta_s", "low": 1e-8, "high": 2e-7, "number": "restitution", "target": 0.97,
        "job": {"scenario": "collision", "params": {"speed_m_s": 1.2}, "material": {"preset": "foerster-3mm"}, "time": {"step_s": 2e-8}}}


def brackets(record):
    return [(row["replica"], row["round"], row["low"], row["high"]) for row in record["bracket"]]


class Studies(Client):
    def daemon(self, **how):
        daemon = self.start(**how)
        self.control = daemon.control
        return daemon

    def ask(self, op, **body):
        return self.control.ask(op, body)

    def finished(self, study, state="done", timeout_s=2 * PATIENCE_S):
        record = self.control.wait(study, timeout_s=timeout_s)
        self.assertEqual(record["state"], state, record["error"])
        return record

    def run_study(self, spec, **how):
        return self.finished(self.control.submit(spec), **how)

    # ---- what they come to ----

    def test_root_finds_the_damping_of_a_restitution(self):
        self.daemon(workers=2)
        record = self.run_study(ROOT)
        self.assertEqual((record["conclusion"], record["answers"][0]["value"], record["unit"]), ("found", 7.12e-8, "s"))
        below, above = [min(t["number"] for t in record["trials"]), max(t["number"] for t in record["trials"])]
        self.assertTrue(below < 0.97 < above)
        self.assertLess(len(record["trials"]), 10)

    def test_bisection_keeps_its_history(self):
        self.daemon(workers=2)
        record = self.run_study(BISECT)
        self.assertEqual(record["conclusion"], "found")
        answer = record["answers"][0]
        history = brackets(record)
        self.assertEqual(history[0][2:], (5, 40))
        self.assertEqual(history[-1][2:], (answer["low"], answer["high"]))
        for before, after in zip(history, history[1:]):
            self.assertTrue(before[2] <= after[2] < after[3] <= before[3])
            self.assertAlmostEqual(after[3] - after[2], (before[3] - before[2]) / 2)
        by_slope = {t["values"]["params.slope_deg"]: t for t in record["trials"]}
        self.assertEqual((by_slope[answer["low"]]["verdict"], by_slope[answer["low"]]["answer"]), ("rest", "raise"))
        self.assertIn("E_kin", by_slope[answer["low"]]["evidence"])
        self.assertEqual((by_slope[answer["high"]]["verdict"], by_slope[answer["high"]]["answer"]), ("undecided", "lower"))

    def test_sections_do_not_wait_for_what_they_do_not_need(self):
        # One worker, five points a round in rising order: the first that flows makes those above it superfluous.
        self.daemon(workers=1)
        record = self.run_study({**BISECT, "at_once": 5})
        spared = [t for t in record["trials"] if t["answer"] == "not needed"]
        self.assertTrue(spared)
        for trial in spared:
            self.assertEqual(trial["state"], "cancelled")
            low = min(t["values"]["params.slope_deg"] for t in record["trials"]
                      if t["round"] == trial["round"] and t["answer"] == "lower")
            self.assertGreater(trial["values"]["params.slope_deg"], low)

    def test_bracket_does_not_depend_on_the_number_of_workers(self):
        one = self.daemon(workers=1)
        first = brackets(self.run_study({**BISECT, "at_once": 2, "replicas": 2}))
        one.stop()
        self.daemon(workers=2)
        self.assertEqual(brackets(self.run_study({**BISECT, "at_once": 2, "replicas": 2, "title": "again"})), first)

    def test_replicas_give_a_spread(self):
        self.daemon(workers=2)
        record = self.run_study({**BISECT, "replicas": 3, "digits": 1})
        self.assertEqual([a["replica"] for a in record["answers"]], [0, 1, 2])
        values = [a["value"] for a in record["answers"]]
        self.assertAlmostEqual(record["spread"]["mean"], numpy.mean(values))
        self.assertAlmostEqual(record["spread"]["deviation"], numpy.std(values, ddof=1))
        seeds = {self.ask("show", job=t["job"])["spec"]["seed"] for t in record["trials"]}
        self.assertEqual(seeds, {1, 2, 3})

    def test_undecided_trial_goes_on_for_longer_and_is_reported(self):
        self.daemon(workers=2)
        spec = {**BISECT, "raise_low_when": ["rest"], "extend_to_s": 0.25, "undecided": "report",
                "job": {**FLOW, "params": {**FLOW["params"], "slope_deg": 20}, "time": {"step_s": 2e-6, "end_s": 0.06}}}
        for stop, expected in ((None, [0.25]), ({"when": ["rest"]}, [0.06, 0.12, 0.24, 0.25])):
            record = self.run_study({**spec, "job": {**spec["job"], "stop": stop} if stop else spec["job"]}, state="failed")
            ends = [t["end_s"] for t in record["trials"] if t["values"]["params.slope_deg"] == 40]
            self.assertEqual(ends, expected)
        self.assertEqual((record["conclusion"], record["error"]["code"]), ("stuck", "not_found"))
        for word in ("40", "undecided", "0.25"):
            self.assertIn(word, record["error"]["message"])
        self.assertIn("extend_to_s", record["error"]["hint"])

    def test_ends_with_the_same_verdict_say_so(self):
        self.daemon(workers=2)
        record = self.run_study({**BISECT, "high": 8}, state="failed")
        self.assertEqual((record["conclusion"], len(record["trials"])), ("same_ends", 2))
        for word in ("same answer", "params.slope_deg = 5", "params.slope_deg = 8", "rest"):
            self.assertIn(word, record["error"]["message"])

    def test_reversed_ends_say_so(self):
        self.daemon(workers=2)
        record = self.run_study({**BISECT, "raise_low_when": ["steady", "accelerating"], "undecided": "raise"}, state="failed")
        self.assertEqual(record["conclusion"], "reversed")

    def test_missing_number_is_named(self):
        self.daemon(workers=2)
        record = self.run_study({**ROOT, "number": "restituzione"}, state="failed")
        self.assertIn("restituzione", record["error"]["message"])

    def test_sweep_with_a_trial_that_fails_runs_the_others(self):
        self.daemon(workers=2)
        # Grains so soft that they fall through the base.
        spec = {"study": "sweep",
                "job": {**FLOW, "params": {**FLOW["params"], "gravity_m_s2": 90, "slope_deg": 5}, "time": {"step_s": 1e-6, "end_s": 0.02}},
                "grid": {"material.young_Pa": [1e9, 1e3, 2e9]}}
        record = self.run_study(spec, state="failed")
        self.assertEqual([t["state"] for t in record["trials"]], ["done", "failed", "done"])
        for word in ("3 trials", "1 failed", record["trials"][1]["job"]):
            self.assertIn(word, record["error"]["message"])

    # ---- submitting ----

    def test_same_request_is_one_study(self):
        self.daemon()
        first = self.control.submit(SWEEP, request="r1")
        self.assertEqual(self.control.submit(SWEEP, request="r1"), first)
        self.finished(first)
        # A finished study of the same spec answers; --again makes another one, whose trials are run anew.
        answer = self.ask("submit", spec=SWEEP)
        self.assertEqual((answer["job"], answer["reused"]), (first, True))
        again = self.ask("submit", spec=SWEEP, again=True)
        self.assertFalse(again["reused"])
        jobs = [t["job"] for t in self.finished(again["job"])["trials"]]
        self.assertFalse(set(jobs) & {t["job"] for t in self.ask("show", job=first)["trials"]})

    def test_trials_take_results_that_are_there(self):
        # A finer study over the same points costs only the new ones.
        self.daemon()
        first = self.run_study(SWEEP)
        wider = {**SWEEP, "grid": {**SWEEP["grid"], "params.speed_m_s": [0.1, 0.15, 0.2]}}
        second = self.run_study(wider)
        self.assertLess({t["job"] for t in first["trials"]}, {t["job"] for t in second["trials"]})
        self.assertEqual(len(second["trials"]), 12)

    def test_refusals_come_with_path_and_range(self):
        self.daemon()
        for change, path, word in (({"over": "material.mu"}, "over", "mu_t"), ({"digits": 0}, "digits", "1..9"),
                                   ({"high": 400}, "high", "0..60 deg"), ({"hgih": 1}, "hgih", "high")):
            with self.assertRaises(Refused) as refused:
                self.control.submit({**BISECT, **change})
            self.assertEqual((refused.exception.code, refused.exception.path), ("invalid", path))
            self.assertIn(word, refused.exception.message)
        self.assertEqual(self.ask("list")["studies"], [])
        with self.assertRaises(Refused) as refused:
            self.ask("show", job="s1")
        self.assertEqual(refused.exception.code, "not_found")

    def test_trials_are_jobs_with_a_parent(self):
        self.daemon()
        study = self.control.submit(SWEEP)
        self.finished(study)
        own = self.control.submit({**HIT, "seed": 77})
        self.control.wait(own)
        jobs = self.ask("list")["jobs"]
        self.assertEqual([j["study"] for j in jobs], [None] + 8 * [study])
        summary = self.ask("list")["studies"][0]
        self.assertEqual((summary["kind"], summary["total"], summary["jobs"]["done"], summary["progress"]), ("sweep", 8, 8, 1))

    # ---- fetching ----

    def test_table_as_csv_and_hdf5(self):
        self.daemon()
        study = self.control.submit(SWEEP)
        record = self.finished(study)
        made = self.ask("fetch", job=study, format="csv")
        text, total = b"", None
        while total is None or len(text) < total: # in pieces, as the client does
            part = self.ask("fetch_part", job=study, format="csv", offset=len(text), bytes=1000)
            text, total = text + base64.b64decode(part["data"]), part["total"]
        self.assertEqual((len(text), made["complete"]), (made["bytes"], True))
        rows = list(csv.DictReader(io.StringIO(text.decode())))
        self.assertEqual([row["job"] for row in rows], [t["job"] for t in record["trials"]])
        with h5py.File(self.ask("fetch", job=study)["path"]) as file:
            trials = file["trials"]
            self.assertEqual(trials["restitution"].attrs["unit"], b"")
            self.assertEqual(trials["params.speed_m_s"].attrs["unit"], b"m/s")
            self.assertEqual(json.loads(file["study/spec"][0]), record["spec"])
            for k, row in enumerate(rows):
                self.assertEqual(float(row["restitution"]), trials["restitution"][k])
                self.assertEqual(row["params.partner"].encode(), trials["params.partner"][k])
                job = {n["name"]: n["value"] for n in self.ask("show", job=row["job"])["numbers"]}
                self.assertEqual(job["restitution"], trials["restitution"][k])
                self.assertEqual(float(row["params.speed_m_s (m/s)"]), trials["params.speed_m_s"][k])
        with self.assertRaises(Refused):
            self.ask("fetch", job=study, format="xls")

    def test_bracket_is_in_the_table(self):
        self.daemon(workers=2)
        study = self.control.submit({**BISECT, "digits": 1})
        record = self.finished(study)
        table = self.ask("table", job=study)
        names = [c["name"] for c in table["columns"]]
        got = {(row[names.index("round")], row[names.index("bracket_low")], row[names.index("bracket_high")]) for row in table["rows"]}
        self.assertEqual(got, {(r, low, high) for _, r, low, high in brackets(record)})

    # ---- cancelling, killing ----

    def test_cancel_takes_the_trials_with_it(self):
        daemon = self.daemon(workers=1)
        spec = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 1000}},
                "grid": {"seed": [1, 2, 3, 4, 5]}, "at_once": 3}
        study = self.control.submit(spec)
        self.until(lambda: self.ask("show", job=study)["jobs"]["running"] == 1)
        self.assertEqual(self.ask("show", job=study)["jobs"]["queued"], 2)
        self.assertEqual(self.ask("cancel", job=study)["state"], "cancelled")
        record = self.until(lambda: [r for r in [self.ask("show", job=study)] if r["jobs"]["cancelled"] == 3])[0]
        self.assertEqual(record["state"], "cancelled")
        self.assertEqual(self.ask("cancel", job=study)["state"], "cancelled")
        daemon.stop()
        self.daemon(workers=1)
        time.sleep(0.3)
        self.assertEqual((self.ask("show", job=study)["state"], len(self.ask("list")["jobs"])), ("cancelled", 3))

    def test_pause_takes_the_trials_with_it(self):
        """What is on its way rests, nothing new begins, also after a restart; a trial that somebody paused by hand is
        not woken with its study; a command that is sent again changes nothing."""
        daemon = self.daemon(workers=1)
        spec = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 2}},
                "grid": {"seed": [1, 2, 3, 4, 5]}, "at_once": 3}
        study = self.control.submit(spec)
        self.until(lambda: self.ask("show", job=study)["jobs"]["running"] == 1)
        by_hand = self.ask("show", job=study)["trials"][2]["job"]
        self.ask("pause", job=by_hand)
        states = lambda: self.ask("show", job=study)["jobs"]
        request = self.control.ask("pause", {"job": study}, request="once")
        self.assertEqual((request["state"], request["op"]), ("paused", "pause"))
        self.until(lambda: states()["paused"] == 3)
        self.assertEqual(self.ask("pause", job=study)["state"], "paused")
        daemon.stop(signal.SIGKILL)
        self.daemon(workers=1)
        self.assertEqual(self.ask("show", job=study)["state"], "paused")
        time.sleep(0.5)
        self.assertEqual((states()["paused"], states()["running"], states()["queued"]), (3, 0, 0))
        self.assertEqual(self.ask("resume", job=study)["state"], "running")
        self.until(lambda: states()["done"] >= 2)
        self.assertEqual(self.ask("show", job=by_hand)["state"], "paused")
        self.assertEqual(self.control.ask("pause", {"job": study}, request="once")["state"], "running")
        self.ask("resume", job=by_hand)
        self.finished(study)
        with self.assertRaises(Refused) as refused:
            self.ask("pause", job=study)
        self.assertEqual(refused.exception.code, "conflict")

    def test_paused_and_resumed_at_once(self):
        """The pause of a running trial takes a moment: a resume that comes before it must not be lost."""
        self.daemon(workers=2)
        spec = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 1}},
                "grid": {"seed": [1, 2, 3]}, "at_once": 2}
        study = self.control.submit(spec)
        self.until(lambda: self.ask("show", job=study)["jobs"]["running"] >= 1)
        for _ in range(3):
            self.ask("pause", job=study)
            self.ask("resume", job=study)
        self.finished(study)

    def test_trial_that_was_steered_is_no_answer(self):
        """Its verdict is that of other parameters than the table says: a bracket must not be built on it,
        nor a sweep be called done, not even when the value was set back before the end, nor after a restart."""
        slow = {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 1000}}
        for spec, word in (({"study": "sweep", "job": slow, "grid": {"seed": [1]}}, "changed with `set`"),
                           ({**BISECT, "job": slow, "extend_to_s": 1000}, "is no answer")):
            daemon = self.daemon(workers=1)
            study = self.control.submit(spec)
            job = self.until(lambda: [t["job"] for t in self.ask("show", job=study)["trials"] if t["state"] == "running"])[0]
            self.ask("set", job=job, set=["params.slope_deg=21"])
            self.ask("set", job=job, set=["time.end_s=0.001"])
            self.until(lambda: self.ask("show", job=job)["state"] == "done")
            record = self.until(lambda: [r for r in [self.ask("show", job=study)] if r["trials"][0]["state"] == "done"])[0]
            if spec["study"] == "bisect":
                self.assertEqual(record["trials"][0]["answer"], "steered")
                self.ask("cancel", job=study)
            else:
                record = self.finished(study, "failed")
                self.assertIn(word, record["error"]["message"])
            daemon.stop()
            daemon = self.daemon(workers=1)
            self.assertEqual(self.ask("show", job=study)["trials"][0]["answer"], "steered")
            daemon.stop()

    def test_killed_again_and_again_it_comes_to_the_same(self):
        # The contract: no trial lost, none run twice, the same bracket as without kills.
        spec = {**BISECT, "replicas": 2, "at_once": 2, "digits": 2}
        daemon = self.daemon(workers=2)
        whole = self.run_study({**spec, "title": "in one go"})
        daemon.stop()
        dice = random.Random(7)
        daemon = self.daemon(workers=2)
        study = self.ask("submit", spec=spec, again=True)["job"]
        for kill in range(12):
            time.sleep(dice.uniform(0.0, 0.3))
            daemon.stop(signal.SIGKILL)
            daemon = self.daemon(workers=2)
            if self.ask("show", job=study)["state"] == "done":
                break
        self.assertGreater(kill, 3)
        record = self.finished(study)
        self.assertEqual(brackets(record), brackets(whole))
        self.assertEqual([(a["value"], a["note"]) for a in record["answers"]], [(a["value"], a["note"]) for a in whole["answers"]])
        key = lambda t: (t["replica"], t["round"], t["values"]["params.slope_deg"], t["verdict"], t["evidence"], t["answer"])
        self.assertEqual(sorted(map(key, record["trials"])), sorted(map(key, whole["trials"])))
        mine = [j["id"] for j in self.ask("list")["jobs"] if j["study"] == study]
        self.assertEqual(sorted(mine), sorted(t["job"] for t in record["trials"]))

    def test_killed_between_two_commits(self):
        # Submitting a trial and noting that it is one are two commits. A kill between them must not make a
        # second job of it: the state in between is made by hand.
        daemon = self.daemon(workers=1)
        study = self.control.submit({**BISECT, "digits": 1})
        self.until(lambda: len(self.ask("show", job=study)["trials"]) > 2)
        daemon.stop(signal.SIGKILL)
        with contextlib.closing(sqlite3.connect(os.path.join(daemon.data, "journal.db"))) as journal, journal:
            self.assertEqual(journal.execute("DELETE FROM trials WHERE rowid = (SELECT MAX(rowid) FROM trials)").rowcount, 1)
        self.daemon(workers=1)
        record = self.finished(study)
        self.assertEqual(sorted(t["job"] for t in record["trials"]), sorted(j["id"] for j in self.ask("list")["jobs"]))

    def test_killed_while_it_was_cancelled(self):
        # The study is cancelled in the journal first: a daemon that ends there must not run its trials.
        daemon = self.daemon(workers=1)
        study = self.control.submit({"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 1000}},
                                     "grid": {"seed": [1, 2]}, "at_once": 2})
        self.until(lambda: self.ask("show", job=study)["jobs"]["running"] == 1)
        daemon.stop(signal.SIGKILL)
        with contextlib.closing(sqlite3.connect(os.path.join(daemon.data, "journal.db"))) as journal, journal:
            journal.execute("UPDATE studies SET state = 'cancelled'")
        self.daemon(workers=1)
        self.until(lambda: self.ask("show", job=study)["jobs"]["cancelled"] == 2)

    def test_restart_shows_a_finished_study_as_it_was(self):
        daemon = self.daemon(workers=2)
        study = self.control.submit({**BISECT, "digits": 1})
        before = self.finished(study)
        daemon.stop()
        self.daemon()
        self.assertEqual(self.ask("show", job=study), before)

    def test_study_shares_the_queue(self):
        # A job that comes after a long study does not wait for all of it.
        self.daemon(workers=1)
        spec = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 0.2}},
                "grid": {"seed": {"from": 1, "to": 50, "step": 1}}}
        study = self.control.submit(spec)
        self.control.wait(self.control.submit(HIT))
        record = self.ask("show", job=study)
        self.assertEqual(record["state"], "running")
        self.assertLess(record["jobs"]["done"], 10)
        self.until(lambda: (self.ask("show", job=study)["eta_s"] or 0) > 0)
        self.ask("cancel", job=study)

    def test_state_is_announced(self):
        daemon = self.daemon()
        import zmq
        events = zmq.Context.instance().socket(zmq.SUB)
        self.addCleanup(events.close, 0)
        events.connect(daemon.about["events_endpoint"])
        events.subscribe(b"job/s")
        time.sleep(0.3)
        study = self.control.submit(SWEEP)
        states = []
        while "done" not in states:
            self.assertTrue(events.poll(PATIENCE_S * 1000))
            topic, body = events.recv_multipart()
            self.assertEqual(topic.decode(), f"job/{study}/state")
            states.append(json.loads(body)["state"])
        self.assertEqual(states, ["queued", "running", "done"])


class StudiesInTheClient(Client):
    on_terminal = test_client.Terminal.on_terminal

    def test_run_brings_a_table_and_says_what_it_came_to(self):
        ended = self.scree("run", self.spec(ROOT), "-o", "out")
        self.assertEqual(ended.returncode, 0, ended)
        self.assertIn("material.beta_s = 7.12e-08 s", ended.stdout)
        self.assertEqual(sorted(os.listdir(os.path.join(self.work, "out"))), ["result.csv", "result.h5"])
        with open(os.path.join(self.work, "out/result.csv")) as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(rows[0]["material.beta_s (s)"], "1e-08")
        self.nothing_left()

    def test_run_that_finds_nothing_fails(self):
        ended = self.scree("--json", "run", self.spec({**ROOT, "target": 2}), "-o", "out")
        self.assertEqual(ended.returncode, 1, ended)
        self.assertIn("same answer", ended.stderr)
        self.assertEqual(json.loads(ended.stdout)["conclusion"], "same_ends")

    def test_check_counts_trials_and_spells_them_out(self):
        ended = self.scree("--json", "check", self.spec(SWEEP), "--set", "replicas=3")
        self.assertEqual(ended.returncode, 0, ended)
        answer = json.loads(ended.stdout)
        self.assertEqual((answer["trials"], answer["spec"]["replicas"], answer["spec"]["job"]["time"]["step_s"]), (12, 3, 5e-8))
        again = self.scree("--json", "check", self.spec(answer["spec"], "again.json"))
        self.assertEqual(json.loads(again.stdout), answer)
        self.refused(self.scree("check", self.spec(SWEEP), "--set", "replicas=0"), "replicas: 0 is outside 1..64")

    def test_scenarios_tells_of_studies(self):
        shown = self.scree("scenarios", "bisect").stdout
        for word in ("raise_low_when", "seed 000 S4.3", "Required: over, low, high, raise_low_when.", "replica_seeds"):
            self.assertIn(word, shown)
        fields = json.loads(self.scree("--json", "scenarios", "root").stdout)
        self.assertEqual((fields["name"], fields["required"]), ("root", ["over", "low", "high", "number", "target"]))

    def test_verbs_take_studies(self):
        self.start()
        study = self.scree("submit", self.spec(SWEEP)).stdout.strip()
        self.assertEqual(study, "s1")
        self.assertEqual(self.scree("wait", study).stdout, "s1 done complete\n")
        listed = self.scree("list").stdout
        self.assertIn("s1", listed)
        self.assertNotIn("j1", listed)
        self.assertIn("j1", self.scree("list", "--trials").stdout)
        self.assertEqual([json.loads(line)["id"] for line in self.scree("--json", "list").stdout.splitlines()], ["s1"])
        shown = self.scree("show", study).stdout
        for word in ("sweep", "8 done of 8", "speed_m_s 0.1, partner \"plane\""):
            self.assertIn(word, shown)
        self.assertEqual(len(json.loads(self.scree("--json", "show", study).stdout)["trials"]), 8)
        watched = self.scree("watch", study)
        self.assertEqual((watched.returncode, "8 done of 8" in watched.stdout), (0, True))
        fetched = self.scree("fetch", study)
        self.assertEqual(fetched.stdout, "s1.h5\ns1.csv\n")
        self.assertEqual(self.scree("cancel", study).stdout, "s1 done\n")
        self.assertEqual(self.scree("show", "s2").returncode, 2)

    def test_plot_draws_jobs_and_studies(self):
        self.start(workers=2)
        spec = {**FLOW, "record": {"basal_force": {"every_s": 2e-5}}, "time": {"step_s": 2e-6, "end_s": 0.1}}
        ids = self.scree("submit", self.spec({**BISECT, "digits": 1}, "b.json"), self.spec(SWEEP, "s.json"), self.spec(ROOT, "r.json"),
                         self.spec(spec, "j.json")).stdout.split()
        self.assertEqual(self.scree("wait", *ids).returncode, 0)
        for name in ids:
            drawn = self.scree("plot", name)
            self.assertEqual((drawn.returncode, drawn.stdout, drawn.stderr), (0, name + ".png\n", ""))
            with open(os.path.join(self.work, name + ".png"), "rb") as file:
                picture = file.read()
            self.assertEqual((picture[:8], picture[-8:-4]), (b"\x89PNG\r\n\x1a\n", b"IEND"))
            self.assertGreater(len(picture), 5000)
        self.assertEqual(self.scree("plot", ids[1], "-o", "x.svg", "--x", "params.speed_m_s", "--y", "restitution").returncode, 0)
        with open(os.path.join(self.work, "x.svg")) as file:
            drawn = file.read()
        for word in ("</svg>", "params.speed_m_s (m/s)", "restitution", "partner plane", "s2  sweep  done  complete"):
            self.assertIn(word, drawn)
        self.refused(self.scree("plot", ids[1], "--y", "restituion"), "restituion", '"restitution"')
        self.refused(self.scree("plot", ids[1], "-o", "x.jpg"), ".png or .svg")
        self.refused(self.scree("plot", ids[3], "--y", "restitution"), "sweeps")
        self.refused(self.scree("plot", ids[0], PATH="/nowhere"), "gnuplot", "apt-get install", code=1)
        self.refused(self.scree("plot", ids[0], "-o", "no/such/folder.png"), "no/such/folder.png")

    def test_progress_table_on_a_terminal(self):
        # A line for the study, a line for each trial on its way, redrawn in place and gone at the end.
        spec = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}}, "grid": {"seed": [1, 2, 3, 4, 5, 6]}, "at_once": 2}
        self.start(workers=2)
        ended, shown = self.on_terminal("run", self.spec(spec), "-o", "out")
        self.assertEqual(ended, 0, shown)
        for word in ("s1 sweep", " of 6 trials", "t ", "seed = "):
            self.assertIn(word, shown)
        self.assertIn("\x1b[A", shown)
        self.assertIn("\x1b[Ks1  sweep  incline", shown)


class StudiesOverTheNetwork(Keyed):
    def test_roles_and_limits_hold_for_studies(self):
        self.start("--max-jobs-per-user", "1")
        ann, bob = self.control(self.user("ann", "submit")), self.control(self.user("bob", "view"))
        self.denied(bob, "submit", {"spec": SWEEP})
        long = {"study": "sweep", "job": {**FLOW, "stop": {"when": []}, "time": {"step_s": 2e-6, "end_s": 1000}}, "grid": {"seed": [1]}}
        study = ann.submit(long, request="r")
        self.assertEqual(ann.submit(long, request="r"), study)
        with self.assertRaises(Refused) as refused:
            ann.submit(SWEEP)
        self.assertEqual(refused.exception.code, "busy")
        self.denied(ann, "cancel", {"job": study})
        # Another user's id of a submit gives nothing away, and takes nothing away.
        carl = self.control(self.user("carl", "steer"))
        other = carl.submit(SWEEP, request="r")
        self.assertNotEqual(other, study)
        self.assertEqual(carl.ask("cancel", {"job": study})["state"], "cancelled")
        carl.wait(other)
        self.assertEqual(len(bob.ask("table", {"job": other})["rows"]), 8)
        self.assertEqual(bob.ask("show", {"job": other})["state"], "done")


if __name__ == "__main__":
    unittest.main(verbosity=2)
