# SPDX-License-Identifier: GPL-3.0-or-later
"""What a job measures, as a user gets it: in the fetched result, in the summary, in
a picture; spectra and collisions computed anew from the stored streams are the
daemon's own."""
import json
import os
import subprocess
import tempfile
import unittest

import h5py
import numpy

from model import tiny
from raw import PATIENCE_S, Daemon

BIN = os.environ["SCREE_BIN"]
SOURCE = os.environ["SCREE_SOURCE"]
EVERY, WINDOW, SEGMENTS = 2.5e-6, 0.02, 8
SPEC = tiny(end_s=0.1, params={"nx": 4, "ny": 4, "nz": 4, "slope_deg": 25}, record={
    "basal_force": {"every_s": EVERY}, "bulk": {}, "profiles": {"frame_s": 0.02}, "collisions": {"from_s": 0.05},
    "connectivity": {}, "spectrum": {"window_s": WINDOW, "segments": SEGMENTS}, "forces": {"every_s": 0.02}, "energy": {},
    "snapshots": {"every_s": 0.02}})
THREE_BEADS = {"scenario": "dam_break", "title": "Three beads in one layer, which the gate lets go", "material": {
    "preset": "hopper-beads", "stiffness_N_m": 2e3, "stiffness_t_N_m": 500, "gamma_t_1_s": 100}, "params": {
        "count": 3, "length_m": 0.1, "width_m": 0.03, "column_m": 0.03, "settle_s": 0.06, "body": {"shape": "sphere", "radius_m": 5e-3}},
    "time": {"step_s": 2e-5, "end_s": 0.13}, "record": {"views": {"every_s": 0.02, "pixels": 40}}}


def welch(x, dt, segments):
    """Half-overlapping Hann windows, mean of all removed; two-sided."""
    half = len(x) // (segments + 1)
    length = 2 * half
    hann = numpy.sin(numpy.pi * numpy.arange(length) / length) ** 2
    x = x - x.mean()
    power = sum(abs(numpy.fft.rfft(hann * x[s * half:s * half + length])) ** 2 for s in range(segments))
    return numpy.fft.rfftfreq(length, dt), power * dt / (segments * (hann ** 2).sum())


class Measurements(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="scree-test-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.daemon = Daemon(folder=cls.folder.name)
        cls.addClassCleanup(cls.daemon.stop)
        cls.job = cls.daemon.control.submit(SPEC)
        cls.daemon.control.wait(cls.job)
        cls.record = cls.daemon.control.ask("show", {"job": cls.job})
        cls.numbers = {row["name"]: row["value"] for row in cls.record["numbers"]}
        cls.file = os.path.join(cls.folder.name, "r.h5")
        cls.scree("fetch", cls.job, "-o", cls.file)

    @classmethod
    def scree(cls, *words, code=0):
        done = subprocess.run([os.path.join(BIN, "scree"), "--connect", cls.daemon.endpoint, *words],
                              capture_output=True, text=True, timeout=PATIENCE_S)
        assert done.returncode == code, done.stderr
        return done

    def test_frames_are_in_the_result_with_times_and_units(self):
        with h5py.File(self.file) as file:
            for stream, frames, column, unit in (("profiles", 5, "phi", b"1"), ("profiles_mean", 1, "T", b"m2/s2"),
                                                 ("spectrum", 5, "Pz", b"N2/Hz"), ("spectrum_mean", 1, "Pz_fit", b"N2/Hz"),
                                                 ("spectrum_octaves", 5, "f", b"Hz")):
                group = file["observables"][stream]
                self.assertEqual(len(group["frame_time"]), frames, stream)
                self.assertEqual(group["frame_rows"][:].sum(), len(group[column]), stream)
                self.assertEqual(group[column].attrs["unit"], unit)
            self.assertTrue(numpy.allclose(file["observables/profiles/frame_time"][:], [0.02, 0.04, 0.06, 0.08, 0.1]))
            self.assertEqual(file["observables/profiles/frame_rows"][0], 16 * 4)

    def test_every_number_of_the_result_has_a_unit(self):
        bare = []

        def look(name, node):
            if isinstance(node, h5py.Dataset) and "unit" not in node.attrs and not name.endswith(("/step", "/frame_rows")):
                bare.append(name)
        with h5py.File(self.file) as file:
            file["observables"].visititems(look)
            self.assertEqual(set(SPEC["record"]) - set(file["observables"]), {"snapshots"})  # which are under particles
            self.assertEqual(len(file["particles/grains/position/time"]), 6 + 1)  # and `grains`
        self.assertEqual(bare, [])

    def test_no_stream_is_left_out_where_all_are_asked_for(self):
        empty = [name for name, stream in self.record["streams"].items() if stream["chunks"] == 0]
        self.assertEqual((len(self.record["streams"]), empty), (13, []))
        for name, stream in self.record["streams"].items():
            lines = self.scree("tail", self.job, name, "--format", "csv", "--from", str(stream["chunks"] - 1)).stdout.splitlines()
            self.assertGreater(len(lines), 1, name)

    def test_the_spectrum_follows_from_the_stored_force(self):
        with h5py.File(self.file) as file:
            force, count = file["observables/basal_force/value"][:], round(WINDOW / EVERY)
            stored, rows = file["observables/spectrum"], int(file["observables/spectrum/frame_rows"][0])
            for window in range(5):
                for axis, name in enumerate(("Px", "Py", "Pz")):
                    f, power = welch(force[window * count:(window + 1) * count, axis], EVERY, SEGMENTS)
                    power /= numpy.sinc(f * EVERY) ** 2
                    band = (f / 1e3 + 1e-9).astype(int)
                    for b in (1, 7, 60, 150):
                        here = stored[name][window * rows + b]
                        self.assertAlmostEqual(here / power[(band == b) & (f > 0)].mean(), 1, 9)

    def test_the_summary_counts_what_the_log_holds(self):
        with h5py.File(self.file) as file:
            log = file["observables/collisions"]
            self.assertGreaterEqual(log["time"][0], 0.05)  # asked from then on
            self.assertEqual(self.numbers["collisions"], len(log["dn"]))  # the summary's window is the last half
            self.assertAlmostEqual(self.numbers["impact_normal2"] / (log["dn"][:] ** 2).mean(), 1, 9)
            self.assertAlmostEqual(self.numbers["impact_median"] / numpy.median(abs(log["dn"][:])), 1, 1)
            self.assertAlmostEqual(self.numbers["collisions_per_s"] / (len(log["dn"]) / 0.05), 1, 9)

    def test_profiles_hold_the_mass_of_the_flow(self):
        with h5py.File(self.file) as file:
            mean = file["observables/profiles_mean"]
            mass = (mean["phi"][:] * numpy.diff(mean["z"][:])[0]).sum() * 2530 * (4 * 2e-3) ** 2
            grains = file["particles/grains"]
            self.assertAlmostEqual(mass * 9.81 * numpy.cos(numpy.radians(25)) / self.numbers["weight_normal"], 1, 2)
            self.assertAlmostEqual(self.numbers["base_pressure"] * (4 * 2e-3) ** 2 / self.numbers["weight_normal"], 1, 2)
            self.assertGreater(len(grains["mass"]), 64)

    def test_models_stand_beside_what_was_measured(self):
        for name in ("spectrum_power", "spectrum_corner", "model_minimal", "model_thin", "model_thick", "model_attenuated",
                     "model_pressure", "force_fluctuation"):
            self.assertGreater(self.numbers[name], 0, name)
        docs = {row["name"]: row["doc"] for row in self.record["numbers"] if row["name"].startswith("model_")}
        for name, doc in docs.items():
            self.assertTrue("this project's formulation" in doc or name == "model_pressure", name)

    def test_the_picture_has_spectrum_and_profiles(self):
        picture = os.path.join(self.folder.name, "j.svg")
        self.scree("plot", self.job, "-o", picture)
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        for word in ("corner", "Pz_fit", "solid fraction", "height over the base", "frequency (Hz)"):
            self.assertIn(word, text)

    def test_a_sweeps_picture_says_how_models_did(self):
        sweep = os.path.join(self.folder.name, "s.json")
        with open(sweep, "w", encoding="utf-8") as file:
            json.dump({"study": "sweep", "grid": {"params.slope_deg": [24, 28]}, "job": {**SPEC, "title": ""}}, file)
        study, picture = self.scree("submit", sweep).stdout.strip(), os.path.join(self.folder.name, "s.svg")
        self.scree("wait", study)
        self.scree("plot", study, "-o", picture)
        table = self.daemon.control.ask("table", {"job": study})
        names = [head["name"] for head in table["columns"]]
        power, minimal, pressure = (numpy.array([row[names.index(name)] for row in table["rows"]])
                                    for name in ("spectrum_power", "model_minimal", "model_pressure"))
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        error = numpy.exp(numpy.sqrt((numpy.log(minimal / power) ** 2).mean()))
        self.assertIn(f"minimal: {error:.3g}", text)
        off = numpy.log(pressure / power)  # its factor is free
        self.assertIn(f"pressure (fitted): {numpy.exp(off.std()):.3g}", text)
        self.assertIn("inertial number", text)

    def test_windows_that_do_not_fit_are_refused_with_what_is_needed(self):
        for spectrum, message in (({"window_s": 0.2}, "record.spectrum.window_s: 0.2 s is longer than the run, which ends at 0.1 s"),
                                  ({"window_s": 1e-4}, "record.spectrum.window_s: 0.0001 s holds 40 blocks of "
                                                       "record.basal_force.every_s = 2.5e-06 s, and 8 segments need at least 72")):
            name = os.path.join(self.folder.name, "bad.json")
            with open(name, "w", encoding="utf-8") as file:
                json.dump({**SPEC, "record": {**SPEC["record"], "spectrum": spectrum}}, file)
            self.assertIn(message, self.scree("check", name, code=2).stderr)

    def test_views_show_what_is_there(self):
        job, name = self.daemon.control.submit(THREE_BEADS), os.path.join(self.folder.name, "beads.h5")
        self.daemon.control.wait(job)
        self.scree("fetch", job, "-o", name)
        pixel, bead = 2 * 5e-3 / 40, numpy.pi * 5e-3 ** 2
        with h5py.File(name) as file:
            for view, axes in (("view_above", "xyz"), ("view_aside", "xzy")):
                group = file["observables"][view]
                self.assertTrue(numpy.allclose(group["frame_time"], [0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.13]), view)
                self.assertEqual(group["frame_rows"][:].sum(), len(group["x"]))
                self.assertEqual([group[axis].attrs["unit"] for axis in axes], 3 * [b"m"])
                self.assertEqual(group["speed"].attrs["unit"], b"m/s")
            rows, bodies = file["observables/view_above/frame_rows"][:].astype(int), file["observables/bodies"]
            self.assertAlmostEqual(rows[0] * pixel ** 2 / (3 * bead), 1, 2)  # none hides another in one layer
            self.assertAlmostEqual(rows[-1] * pixel ** 2 / (3 * bead), 1, 2)
            last = {column: file["observables/view_above"][column][-rows[-1]:] for column in ("x", "y", "z", "speed")}
            for x, y, z, v in zip(bodies["x"], bodies["y"], bodies["z"], numpy.hypot(numpy.hypot(bodies["vx"], bodies["vy"]), bodies["vz"])):
                here = numpy.hypot(last["x"] - x, last["y"] - y) < 4e-3
                self.assertAlmostEqual(here.sum() * pixel ** 2 / (numpy.pi * 4e-3 ** 2), 1, 1)
                self.assertTrue(numpy.allclose(last["z"][here], z) and numpy.allclose(last["speed"][here], v))
        picture = os.path.join(self.folder.name, "beads.svg")
        self.scree("plot", job, "-o", picture)
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        for word in ("0 s after the gate", "sqrt(H0 / g)", "x (cm)", "z (cm)", "y (cm)", "hue: speed"):
            self.assertTrue(word in text, word)
        runout = {row["name"]: row["value"] for row in self.daemon.control.ask("show", {"job": job})["numbers"]}["runout"]
        self.assertTrue(f"L {100 * runout:.3g} cm" in text, runout)

    def test_a_channel_is_measured_in_the_half_at_its_midline(self):
        spec = {**tiny(end_s=0.12, record={"basal_force": {}, "bulk": {}, "profiles": {"frame_s": 0.02}, "connectivity": {},
                                           "collisions": {}, "spectrum": {"window_s": 0.5e-1}, "forces": {"every_s": 0.02}},
                       params={"nx": 4, "ny": 8, "nz": 3, "slope_deg": 25}), "scenario": "channel"}
        job = self.daemon.control.submit(spec)
        self.daemon.control.wait(job)
        record = self.daemon.control.ask("show", {"job": job})
        self.assertEqual(record["state"], "done", record["error"])
        numbers = {row["name"]: row["value"] for row in record["numbers"]}
        area, name = 4 * 2e-3 * 4 * 2e-3, os.path.join(self.folder.name, "channel.h5")
        self.assertAlmostEqual(numbers["base_pressure"] * area / numbers["weight_normal"], 1, 2)
        self.assertLess(numbers["weight_normal"], 0.7 * 96 * 1.06e-5 * 9.81)  # about half of all 96 grains
        self.scree("fetch", job, "-o", name)
        with h5py.File(name) as file:
            self.assertIn(3, file["observables/collisions/partner"][:])  # grains hit wall and midline
            for group in ("basal_force", "profiles", "connectivity", "collisions", "spectrum", "forces", "bulk"):
                self.assertIn(group, file["observables"])

    def test_a_channel_too_narrow_to_measure_is_refused(self):
        name = os.path.join(self.folder.name, "narrow.json")
        with open(name, "w", encoding="utf-8") as file:
            json.dump({"scenario": "channel", "params": {"ny": 3}}, file)
        self.assertIn("params.ny: 3 grain diameters leave 1.5 in the half that is measured",
                      self.scree("check", name, code=2).stderr)

    def test_the_campaign_is_a_valid_sweep_with_every_measurement(self):
        name = os.path.join(SOURCE, "client/examples/slidequakes.json")
        self.assertIn("30 trials", self.scree("check", name).stderr)
        with open(name, encoding="utf-8") as file:
            record = json.load(file)["job"]["record"]
        for each in ("basal_force", "profiles", "collisions", "connectivity", "spectrum", "forces", "bulk"):
            self.assertIn(each, record)


if __name__ == "__main__":
    unittest.main()
