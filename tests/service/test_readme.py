# SPDX-License-Identifier: GPL-3.0-or-later
"""The README is what people try first: its reader must run as printed."""
import os
import re
import subprocess
import sys
import unittest

import h5py
import numpy

from raw import Daemon

JOB = {
    "scenario": "incline",
    "params": {"nx": 4, "ny": 4, "nz": 3},
    "time": {"end_s": 0.05},
    "stop": {"when": []},
    "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}},
}


class Readme(unittest.TestCase):
    def setUp(self):
        with open(os.path.join(os.environ["SCREE_SOURCE"], "README.md"), encoding="utf-8") as file:
            self.text = file.read()

    def test_the_ten_line_reader_prints_the_force(self):
        # Live, with no more than python3-zmq and python3-numpy: the promise of the protocol.
        programs = re.findall(r"```python\n(.*?)```", self.text, re.DOTALL)
        self.assertEqual(len(programs), 1)
        self.assertEqual(len(programs[0].splitlines()), 10)
        daemon = Daemon()
        self.addCleanup(daemon.remove)
        self.addCleanup(daemon.stop)
        job = daemon.control.submit(JOB)
        ended = subprocess.run([sys.executable, "-c", programs[0], daemon.about["stream_endpoint"], job], stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        printed = [[float(word) for word in re.findall(r"[-+.e\d]+", line)] for line in ended.stdout.splitlines()]
        self.assertEqual(len(printed), 20)
        place = daemon.control.ask("fetch", {"job": job})
        with h5py.File(place["path"], "r") as result:
            means = result["/observables/basal_force/value"][...].reshape(20, 100, 3).mean(axis=1)
        self.assertTrue(numpy.any(means[:, 2] != 0))
        for (time_s, *force), mean, k in zip(printed, means, range(20)):
            self.assertAlmostEqual(time_s, (100 * k + 1) * 2.5e-5, places=9)
            numpy.testing.assert_allclose(force, mean, rtol=1e-4, atol=1e-7)  # as many digits as are printed

    def test_files_it_names_exist(self):
        # A tour that leads to places that were moved is worse than none.
        named = set(re.findall(r"\]\(([^)#:]+)\)", self.text)) | set(re.findall(r"`((?:src|server|client|protocol|tests|deploy)/[^`* ]*)`", self.text))
        self.assertGreater(len(named), 15)
        missing = [name for name in sorted(named) if not os.path.exists(os.path.join(os.environ["SCREE_SOURCE"], name))]
        self.assertEqual(missing, [])


if __name__ == "__main__":
    unittest.main()
