# SPDX-License-Identifier: GPL-3.0-or-later
"""Seed 002's results by the shipped examples: every number is that of a job of the
daemon. continuum.md beside this holds what they came to, with the published values;
here each must stay within its tolerance. By itself it runs enough of each example to
tell whether its statement still holds; SCREE_WHOLE=1 runs all of every example.

    python3 tests/results/test_continuum.py Collapses     # one of them
"""
import json
import math
import os
import tempfile
import unittest

import numpy

from raw import Daemon

EXAMPLES = os.path.join(os.environ["SCREE_SOURCE"], "client", "examples")
LONGEST_S = 2 * 3600
WHOLE = bool(os.environ.get("SCREE_WHOLE"))


class Study(unittest.TestCase):
    """Runs the class's example once; rows are (values, numbers) of its trials."""
    example = None

    @classmethod
    def shorten(cls, study):
        """Takes what need not run every time out of the example."""

    @classmethod
    def setUpClass(cls):
        if cls is Study or cls.example is None:
            raise unittest.SkipTest("the base of the others")
        folder = tempfile.TemporaryDirectory(prefix="scree-test-")
        cls.addClassCleanup(folder.cleanup)
        cls.daemon = Daemon(folder=folder.name)
        cls.addClassCleanup(cls.daemon.stop)
        with open(os.path.join(EXAMPLES, cls.example)) as file:
            study = json.load(file)
        if not WHOLE:
            cls.shorten(study)
        cls.study = cls.daemon.control.submit(study)
        cls.record = cls.daemon.control.wait(cls.study, timeout_s=LONGEST_S)
        cls.rows = []
        for trial in cls.record["trials"]:
            job = cls.daemon.control.ask("show", {"job": trial["job"]})
            cls.rows.append((trial, {row["name"]: row["value"] for row in job["numbers"]}))
            print(trial["values"], {name: float("%.4g" % value) for name, value in cls.rows[-1][1].items()}, flush=True)

    def check_rest_and_volume(self):
        """S2-11; published: below 3 %, with eight times the points. The farther it flows, the more."""
        for trial, numbers in self.rows:
            self.assertEqual(trial["verdict"], "rest", trial["values"])
            self.assertLess(numbers["volume_lost"], 7 if trial["values"].get("params.run") == "B20" else 4, trial["values"])


class Collapses(Study):
    example = "collapses.json"

    @classmethod
    def shorten(cls, study):
        study["grid"]["params.run"] = ["B00", "G05"]

    def test_tables_2_and_3(self):
        """Run-out of the published simulation and its error, m (S2-02, S2-03), and what stays at the back wall."""
        published = {"B00": (.19, .01), "B05": (.21, .02), "B10": (.30, .03), "B15": (.46, .03), "B20": (.88, .05),
                     "G00": (.10, .01), "G05": (.13, .01), "G10": (.15, .02), "G15": (.19, .03)}
        self.check_rest_and_volume()
        for trial, numbers in self.rows:
            run = trial["values"]["params.run"]
            expect, error = published[run]
            steep = run[1:] in ("15", "20")  # whose toe is hardly deeper than the rule's 2 mm over its last tenth of a metre
            self.assertLess(abs(numbers["run_out"] - expect), (3.5 if steep else 1.5) * error, run)
            if run[0] == "B":
                self.assertEqual(numbers["unconverged_steps"], 0, run)


class Widths(Study):
    example = "collapse-widths.json"

    @classmethod
    def shorten(cls, study):
        study["grid"]["params.width_m"] = [0.01, 0.04]

    def test_a_narrow_deposit_is_higher_and_shorter(self):
        """S2-05: the narrower, the higher at the back and the shorter."""
        self.check_rest_and_volume()
        heights = [numbers["height_back"] for _, numbers in self.rows]
        reaches = [numbers["run_out"] for _, numbers in self.rows]
        self.assertEqual(heights, sorted(heights, reverse=True))
        self.assertEqual(reaches, sorted(reaches))


class Laws(Study):
    example = "collapse-laws.json"

    @classmethod
    def shorten(cls, study):
        study["cases"] = [case for case in study["cases"]
                          if "hysteretic" not in case.get("params.continuum.law", "") and case.get("params.width_m", 0.02) == 0.02]

    usual = {"law": "constant", "mu": 0.44, "inertial_star": 0.04, "mu_gate": 0.23, "width_m": 0.06}

    def reach(self, **values):
        """Run-out of the trial that differs from the usual run by these values alone."""
        wanted = {**self.usual, **values}
        [found] = [numbers["run_out"] for trial, numbers in self.rows
                   if all(wanted[path.split(".")[-1]] == value for path, value in trial["values"].items())]
        return found

    def test_lower_friction_runs_farther(self):
        """S2-08: mu_stop, mu(I) from it, and the avalanche angle's."""
        stop, mu_i, avalanche = self.reach(mu=0.38), self.reach(law="mu(I)", mu=0.38), self.reach()
        self.assertGreaterEqual(stop, mu_i)
        self.assertGreater(mu_i, avalanche)

    def test_the_gate_does_not_matter(self):
        """S2-10; published: no difference to be seen. Here, half a cell."""
        self.assertLess(abs(self.reach(mu_gate=0.18) - self.reach(mu_gate=1)), 0.03 * self.reach())

    def test_a_wider_channel_runs_farther(self):
        """S2-07."""
        widths = sorted({trial["values"]["params.width_m"] for trial, _ in self.rows})
        reaches = [self.reach(width_m=width) for width in widths]
        self.assertGreater(len(reaches), 1)
        self.assertEqual(reaches, sorted(reaches))

    @unittest.skipUnless(WHOLE, "hysteretic laws are left out")
    def test_hysteresis_brackets_the_avalanche_angle(self):
        """S2-09: the paper's I* = 0.04 stops short of mu = 0.44, the published run script's 0.005 goes on beyond it."""
        stepwise = [self.reach(law="hysteretic-step", mu=0.38, inertial_star=star) for star in (0.04, 0.005)]
        self.assertLess(stepwise[0], self.reach())
        self.assertGreater(stepwise[1], self.reach())
        self.assertLess(stepwise[0], self.reach(law="hysteretic", mu=0.38))


class AvalancheAngle(Study):
    example = "avalanche-angle.json"

    @classmethod
    def shorten(cls, study):
        study["cases"] = study["cases"][:1]

    def test_the_surface_stays_at_atan_mu(self):
        """S2-01: the surface follows the box, and in the end lies at the angle of friction to half a degree."""
        for trial, _ in self.rows:
            chunks, _ = self.daemon.streams().read_all("d", trial["job"], "deposit")
            names = chunks[0][0]["columns"]
            deposit = numpy.concatenate([numpy.frombuffer(payload, "<f8").reshape(-1, len(names)) for _, payload in chunks])
            box, surface = deposit[:, names.index("inclination")], deposit[:, names.index("surface_angle")]
            before = box <= math.degrees(math.atan(0.44)) - 0.5
            self.assertLess(abs(surface - box)[before].max(), 0.2)
            self.assertLess(abs(surface[-1] - math.degrees(math.atan(0.44))), 0.5)


class AspectRatios(Study):
    example = "aspect-ratios.json"

    @classmethod
    def shorten(cls, study):
        study["cases"] = study["cases"][0:10:3] + study["cases"][16:23:2]

    def fit(self, plane, number, low, high):
        """Factor and exponent over a in [low, high]."""
        pick = [(n["aspect_ratio"], n[number]) for t, n in self.rows
                if t["values"]["params.plane"] == plane and low <= n["aspect_ratio"] <= high]
        slope, offset = numpy.polyfit(*numpy.log(numpy.array(pick).T), 1)
        return math.exp(offset), slope

    def test_power_laws(self):
        """S2-04, Table 4: exponents to 0.1 or so, factors to a fifth."""
        laws = [(True, "run_out_ratio", 1, 7, 2.0, 1.0), (True, "height_ratio", 1, 7, 1.3, 0.67),
                (False, "height_ratio", 1, 20, 1.2, 0.5)]
        if WHOLE:  # above a = 7; and the narrow run-out, which is not the published one: cells are as large as the channel is wide
            laws += [(True, "run_out_ratio", 7, 20, 3.4, 0.65)]
        for plane, number, low, high, factor, exponent in laws:
            got = self.fit(plane, number, low, high)
            print(plane, number, low, high, got, "published", factor, exponent)
            self.assertLess(abs(got[1] - exponent), 0.15)
            self.assertLess(abs(got[0] / factor - 1), 0.25)


if __name__ == "__main__":
    unittest.main()
