# SPDX-License-Identifier: GPL-3.0-or-later
"""A continuum under the same roof as grains: its streams and numbers, its pictures, and a
sweep that runs both."""
import os
import subprocess
import tempfile
import unittest

import h5py
import numpy

from raw import PATIENCE_S, Daemon

BIN = os.environ["SCREE_BIN"]
COLLAPSE = {"scenario": "collapse",
            "params": {"run": "B15", "cell_m": 0.03, "cell_height_m": 0.0138, "gate_wait_s": 0.01, "continuum": {"points": 2}},
            "time": {"end_s": 0.2}, "record": {"basal_force": {}, "bulk": {}, "surface": {"every_s": 0.05}}}


class Continuum(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="scree-test-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.daemon = Daemon(folder=cls.folder)
        cls.addClassCleanup(cls.daemon.stop)

    def scree(self, *words, code=0):
        done = subprocess.run([os.path.join(BIN, "scree"), "--connect", self.daemon.endpoint, *words],
                              capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def picture(self, *words):
        """The text of a drawing."""
        path = os.path.join(self.folder, "p.svg")
        self.scree("plot", *words, "-o", path)
        with open(path) as file:
            return file.read()

    def run_to_end(self, spec):
        job = self.daemon.control.submit(spec)
        self.assertEqual(self.daemon.control.wait(job)["state"], "done")
        return job

    def test_a_collapse_shows_its_surface(self):
        job = self.run_to_end(COLLAPSE)
        path = os.path.join(self.folder, "c.h5")
        self.scree("fetch", job, "-o", path)
        with h5py.File(path) as file:
            frames = file["observables/surface"]
            rows = int(frames["frame_rows"][0])
            self.assertTrue(numpy.allclose(frames["frame_time"][:], [0, .05, .1, .15, .2]))
            first = frames["surface"][:rows]
            column = frames["x"][:rows] < 0.22
            self.assertLess(abs(first[column] - (0.01385 + 0.1108)).max(), 0.01)  # bed and column, before anything flows
            self.assertTrue((frames["static"][:] <= frames["surface"][:] + 1e-12).all())
            self.assertEqual(len(file["observables/deposit/value"]), 12)  # every 1/60 s
        numbers = {row["name"]: row["value"] for row in self.daemon.control.ask("show", {"job": job})["numbers"]}
        self.assertAlmostEqual(numbers["aspect_ratio"], 0.1108 / 0.2244)
        self.assertTrue(0 < numbers["residual_mean"] <= numbers["residual_largest"])
        self.assertGreater(-numbers["mean_force_z"] / numbers["weight_normal"], 0.5)
        drawing = self.picture(job)
        self.assertIn("free surface", drawing)
        self.assertNotIn("largest and least", drawing)  # no collisions, no blows

    def test_a_sweep_over_scenarios_is_drawn_side_by_side(self):
        study = self.daemon.control.submit({
            "study": "sweep",
            "cases": [{"params.nx": 3, "params.ny": 3, "params.nz": 2},
                      {"scenario": "layer", "params.depth_m": 0.01, "time.step_s": 5e-4, "record.basal_force.every_s": 1e-3,
                       "record.bulk.every_s": 0.01, "record.surface.every_s": 0.01}],
            "job": {"scenario": "incline", "params": {"slope_deg": 23.5}, "time": {"end_s": 0.02}, "stop": {"when": []},
                    "record": {"basal_force": {"chunk": 16}, "bulk": {"every_s": 1e-3}}}})
        self.daemon.control.wait(study)
        record = self.daemon.control.ask("show", {"job": study})
        self.assertEqual([trial["state"] for trial in record["trials"]], ["done", "done"])
        self.assertEqual(record["trials"][1]["values"]["scenario"], "layer")
        drawing = self.picture(study)
        self.assertIn("scenario incline", drawing)
        self.assertIn("it has no collisions, so there is no high-frequency force in it", drawing)

    def test_power_laws_are_fitted(self):
        spec = {"scenario": "layer", "time": {"end_s": 0.02}, "record": {"basal_force": {}, "bulk": {}}}
        study = self.daemon.control.submit({"study": "sweep", "grid": {"params.depth_m": [0.01, 0.02, 0.04]}, "job": spec})
        self.daemon.control.wait(study)
        axes = ("--x", "params.depth_m", "--y", "weight_normal", "--log")
        drawing = self.picture(study, *axes, "--beside", "2,1 3.4,0.65")
        self.assertIn("x^1.00", drawing)  # weight is proportional to depth
        self.assertIn("beside: 3.4 x^0.65", drawing)
        for law in ("2", "2,1 3.4", "-1,1", "2,x"):
            self.assertIn("FACTOR,EXPONENT", self.scree("plot", study, *axes, "--beside", law, code=2).stderr)
        self.scree("plot", study, "--by", "params.nothing", code=2)


if __name__ == "__main__":
    unittest.main()
