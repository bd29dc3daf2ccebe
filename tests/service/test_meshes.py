# SPDX-License-Identifier: GPL-3.0-or-later
"""A chute of the user's own: a file that the client reads, the daemon keeps, and a job runs on."""
import base64
import hashlib
import importlib
import json
import os
import random
import shutil
import signal
import struct
import sys
import unittest

import h5py

from raw import Refused
from test_client import Client

EXAMPLES = os.path.join(os.environ["SCREE_SOURCE"], "client", "examples")
with open(os.path.join(EXAMPLES, "own-chute.json"), encoding="utf-8") as spec_file:
    OWN = json.load(spec_file)
SHORT = {**OWN, "params": {**OWN["params"], "mass_g": 3}, "time": {**OWN["time"], "end_s": 0.02}}
FILE = OWN["params"]["mesh"]["file"]

# A tetrahedron, its faces turned outwards; and what may be wrong with one.
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def obj(corners, faces):
    return ("".join("v %r %r %r\n" % corner for corner in corners)
            + "".join("f %d %d %d\n" % tuple(k + 1 for k in face) for face in faces)).encode()


def stl(corners, faces):
    return bytes(80) + struct.pack("<I", len(faces)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *corners[a], *corners[b], *corners[c], 0) for a, b, c in faces)


class Meshes(Client):
    def setUp(self):
        super().setUp()
        shutil.copy(os.path.join(EXAMPLES, FILE), self.work)
        with open(os.path.join(EXAMPLES, FILE), "rb") as file:
            self.trough = file.read()

    def put(self, control, data):
        return control.ask("mesh", {"data": base64.b64encode(data).decode()})

    def test_a_job_runs_on_a_file_and_says_which(self):
        daemon = self.start()
        job = self.scree("submit", self.spec(SHORT)).stdout.strip()
        record = daemon.control.wait(job)
        self.assertEqual(record["state"], "done", record["error"])
        mesh = record["spec"]["params"]["mesh"]
        self.assertEqual(mesh["sha256"], hashlib.sha256(self.trough).hexdigest())
        self.assertEqual((mesh["file"], mesh["unit_m"], mesh["closed"]), (FILE, 0.001, False))
        kept = os.path.join(self.folder, "data", "meshes", mesh["sha256"])
        with open(kept, "rb") as file:
            self.assertEqual(file.read(), self.trough)
        shown = self.put(daemon.control, self.trough)["triangles"]
        self.assertEqual(record["streams"]["walls"]["samples"], shown)  # pictures show this wall, not the built one
        # The spec as it was resolved is enough: no file, the same job.
        again = daemon.control.ask("submit", {"spec": record["spec"]})
        self.assertEqual((again["job"], again["reused"]), (job, True))
        # Another file is another mesh, and another job.
        with open(os.path.join(self.work, FILE), "ab") as file:
            file.write(b"# another\n")
        other = self.scree("submit", self.spec(SHORT)).stdout.strip()
        self.assertNotEqual(other, job)
        self.assertEqual(daemon.control.wait(other)["hash"], record["hash"])  # a comment moves no grain

    def test_a_private_daemon_is_given_it_too(self):
        os.mkdir(os.path.join(self.work, "specs"))
        os.rename(os.path.join(self.work, FILE), os.path.join(self.work, "specs", FILE)) # seen from the spec's folder
        ended = self.scree("run", self.spec(SHORT, os.path.join("specs", "job.json")), "-o", "out.h5")
        self.assertEqual(ended.returncode, 0, ended)
        with h5py.File(os.path.join(self.work, "out.h5")) as result:
            texts = []
            result.visititems(lambda _, item: texts.extend(item.attrs.values()))
            self.assertTrue(any(hashlib.sha256(self.trough).hexdigest() in str(text) for text in texts))
        self.nothing_left()

    def test_the_python_client_brings_one(self):
        daemon = self.start()
        sys.path.insert(0, os.path.join(os.environ["SCREE_SOURCE"], "client", "python"))
        scree = importlib.import_module("scree")
        with scree.connect(daemon.endpoint) as other:
            self.assertEqual(other.mesh(os.path.join(self.work, FILE)), hashlib.sha256(self.trough).hexdigest())

    def test_a_study_brings_one_mesh_for_all_trials(self):
        daemon = self.start()
        study = self.scree("submit", self.spec({"study": "sweep", "job": SHORT, "grid": {"seed": [1, 2]}})).stdout.strip()
        self.assertEqual(daemon.control.wait(study)["state"], "done")
        self.assertEqual(len(os.listdir(os.path.join(self.folder, "data", "meshes"))), 1)

    def test_what_is_no_surface_is_refused_by_its_triangle(self):
        self.start()
        flat = CORNERS[:3] + [(2, 0, 0)]
        cases = [(obj(CORNERS, FACES[:3]), "the mesh is open: triangle "),
                 (obj(flat, [(0, 1, 2), (0, 1, 3)]), "triangle 1 is degenerate"),
                 (obj(CORNERS + [(1, 1, 1)], FACES + [(4, 0, 1)]), "triangle 4 shares its edge"),
                 (obj(CORNERS, [(1, 2, 0)] + FACES[1:]), "is turned the other way round than its neighbour"),
                 (stl(CORNERS, FACES)[:-1], "not a statement of an OBJ file (nor is the file STL)"),
                 (b"", "the mesh has no triangle"),
                 (b"v 1 2 nan\n", "line 1 of the mesh: expected three finite numbers"),
                 (stl(CORNERS, FACES), "not below -0.1577, 0, 0.4577 m")]
        spec = {**SHORT, "params": {**SHORT["params"], "mesh": {"file": "bad"}}}
        for data, message in cases:
            self.spec(data, "bad")
            self.refused(self.scree("submit", self.spec(spec)), "job.json: ", message)
        self.spec(bytes(768001), "bad")
        self.refused(self.scree("check", self.spec(spec)), "bad is above 768000 bytes", "15358 triangles")
        os.unlink(os.path.join(self.work, "bad"))
        self.refused(self.scree("submit", self.spec(spec)), "params.mesh.file: cannot open bad: No such file")

    def test_the_daemon_trusts_no_client(self):
        daemon = self.start()
        with self.assertRaisesRegex(Refused, "data: the base64"):
            daemon.control.ask("mesh", {"data": "*"})
        with self.assertRaisesRegex(Refused, "data: the base64"):
            daemon.control.ask("mesh", {})
        with self.assertRaisesRegex(Refused, "above 768000"):
            self.put(daemon.control, bytes(770000))
        params = {**SHORT["params"], "mesh": {"file": FILE}}
        with self.assertRaisesRegex(Refused, "The name of one is missing"):  # the daemon opens no file of its machine
            daemon.control.submit({**SHORT, "params": params})
        for name in ("0" * 64, "../" * 21 + "x"):
            with self.assertRaisesRegex(Refused, "params.mesh.sha256"):
                daemon.control.submit({**SHORT, "params": {**params, "mesh": {"sha256": name}}})
        rng = random.Random(6)
        for _ in range(300): # hostile bytes: every answer is a mesh or a refusal
            data = bytearray(stl(CORNERS, FACES) if rng.random() < 0.5 else obj(CORNERS, FACES))
            for _ in range(rng.randint(1, 6)):
                data[rng.randrange(len(data))] = rng.randrange(256)
            try:
                self.assertEqual(self.put(daemon.control, bytes(data))["sha256"], hashlib.sha256(data).hexdigest())
            except Refused as refusal:
                self.assertEqual(refusal.code, "invalid")

    def test_a_mesh_that_was_acknowledged_survives_a_kill(self):
        daemon = self.start()
        answer = self.put(daemon.control, stl(CORNERS, FACES))
        self.assertEqual((answer["vertices"], answer["triangles"], answer["closed"]), (4, 4, True))
        self.assertEqual((answer["low"], answer["high"]), ([0, 0, 0], [1, 1, 1]))
        name = self.put(daemon.control, self.trough)["sha256"]
        mesh = {**OWN["params"]["mesh"], "sha256": name}
        job = daemon.control.submit({**SHORT, "params": {**SHORT["params"], "mesh": mesh}})
        daemon.stop(signal.SIGKILL)
        self.assertEqual(self.start().control.wait(job)["state"], "done")


if __name__ == "__main__":
    unittest.main()
