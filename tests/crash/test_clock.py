# SPDX-License-Identifier: GPL-3.0-or-later
"""Time of day is shown and nothing else: a clock that is set back an hour or forward a
year, under a running job, stops nothing and loses nothing."""
import os
import struct
import tempfile
import time
import unittest

from model import FAULTS, Session, tiny

HOUR_S, YEAR_S = 3600, 365 * 86400


@unittest.skipUnless(FAULTS, "SCREE_FAULTS does not name the library of faults")
class Clock(unittest.TestCase):
    def test_clock_that_jumps(self):
        folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-crash-"))
        clock = os.path.join(folder, "clock")

        def set_ahead(seconds):
            with open(clock, "r+b" if os.path.exists(clock) else "wb") as file:
                file.write(struct.pack("<q", seconds))

        set_ahead(0)
        session = Session(folder, SCREE_CLOCK=clock)
        self.addCleanup(session.close)
        job = session.submit(tiny(end_s=1))
        session.daemon.control.wait(job, states=("running",))
        for slope, seconds in enumerate((-HOUR_S, 2 * HOUR_S, YEAR_S, -YEAR_S), 20):
            set_ahead(seconds)
            self.assertIsNotNone(session.steer("set", job, [f"params.slope_deg={slope}"]))
            session.steer("checkpoint", job)
            session.read(job, 0.1)
            at = session.look(job)["steering"][-1]["at"]
            self.assertLess(abs(at - seconds - time.time()), 60)  # the daemon does see that clock
        session.steer("set", job, ["time.end_s=1e-3"])
        session.judge(replays=1)


if __name__ == "__main__":
    unittest.main()
