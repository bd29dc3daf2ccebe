# SPDX-License-Identifier: GPL-3.0-or-later
"""The calibrations of seed 000 and the calculator of seed 001 as a user runs them: each prints what came out beside the paper's
number, and what came out is right (targets S0-09, S0-11 to S0-13, S0-15, S0-17, S0-18, S1-05)."""
import os
import re
import unittest

from test_client import Client

EXAMPLES = os.path.join(os.environ["SCREE_SOURCE"], "client/examples")


class Calibrations(Client):
    def example(self, name, *options):
        """What `scree run` prints of an example."""
        ended = self.scree("run", os.path.join(EXAMPLES, name + ".json"), *options)
        self.assertEqual(ended.returncode, 0, ended)
        return ended.stdout

    def near(self, out, pattern, *expect, tolerance):
        """Numbers in the place of each # of the pattern."""
        found = re.search(re.escape(pattern).replace(r"\#", r"([-+0-9.e]*[0-9])"), out)
        self.assertTrue(found, f"{pattern} is not in\n{out}")
        for text, value in zip(found.groups(), expect, strict=True):
            self.assertLessEqual(abs(float(text) / value - 1), tolerance, f"{text} is not {value} in\n{out}")

    def test_damping(self):
        self.near(self.example("calibrate-beta"), "published 45.1 ns (a slip, see calibrate-beta-slip.json), recomputed 71.2 ns; here # s",
                  71.2e-9, tolerance=1e-3)
        out = self.example("calibrate-beta-slip")
        for word, beta, e in (("e = 0.97; here # s and #", 71.2e-9, 0.97), ("e = 0.9809; here # s and #", 45.06e-9, 0.9809),
                              ("35.6 ns; here # s, and e = #", 35.6e-9, 0.9849)):
            self.near(out, word, beta, e, tolerance=1e-3)

    def test_restitution_and_contact_time(self):
        out = self.example("calibrate-restitution")
        for speed, e, time in ((0.01, 0.9888, 14.86e-6), (0.14, 0.9811, 8.774e-6), (0.362, 0.9772, 7.259e-6), (1.2, 0.97113, 5.715e-6)):
            line = next(line for line in out.splitlines() if f"at {speed} m/s" in line)
            self.near(line, "here #, # s", e, time, tolerance=3e-3)

    def test_rolling_resistance(self):
        self.near(self.example("calibrate-rocking"), "here #, # s (by k_r", 0.742, 2e-3, tolerance=2e-3)
        soft = ("--set", "job.material.young_Pa=74e6", "--set", "job.time.step_s=4e-6")  # a sixteenth of the time
        self.near(self.example("calibrate-kappa", *soft), "without slip; here #", 0.742, tolerance=3e-3)
        self.near(self.example("calibrate-beta_r", *soft), "without slip; here # s", 2e-3, tolerance=5e-3)
        self.near(self.example("calibrate-mu_r", "--set", "digits=2"), "here # deg", 1.0, tolerance=0.01)

    def test_time_step(self):
        self.near(self.example("calibrate-step"), "recomputed 5.75e-7 s; here # s", 5.75e-7, tolerance=0.02)

    def test_calculations(self):
        self.near(self.example("calibrate-yield"), "here # and #. Onset", 0.7505, 0.7841, tolerance=5e-4)
        self.near(self.example("contact-parameters"), "here #, #, #. Steps", 7.34e5, 2.259e5, 3.973e4, tolerance=1e-3)
        self.near(self.example("contact-parameters", "--set", "params.partner=wall", "--set", "params.mass_kg=2.4024e-4",
                               "--set", "params.overlap_m=5e-5", "--set", "params.speed_m_s=2.426", "--set", "params.restitution=0.85"),
                  "here #, ", 4.83e5, tolerance=2e-3)

    def test_what_the_paper_says_waits_for_its_number(self):
        """A name that is no number's is told as a dash, in a text that is cut nowhere."""
        text = "x" * 340 + " {restitution} {nothing}"
        self.spec({"scenario": "collision", "paper": text})
        out = self.scree("run", "job.json").stdout
        self.assertRegex(out, r"paper +x{340} 0\.98[0-9]+ -\n")
        self.spec({"scenario": "collision", "paper": "x" * 384})
        self.refused(self.scree("run", "job.json"), "paper: 384 bytes are more than the 383 that are accepted")


if __name__ == "__main__":
    unittest.main()
