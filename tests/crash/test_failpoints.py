# SPDX-License-Identifier: GPL-3.0-or-later
"""Killed at every named failpoint of journal, log, checkpoint and result, the first
and a later time that it is passed; judged by tests/support/model.py."""
import os
import re
import sys
import tempfile
import time
import unittest

from model import FAULTS, SLOW, Session, tiny

SOURCE = os.environ["SCREE_SOURCE"]
PASSAGES = (1, 2, 3, 5, 8) if SLOW else (1,)


def failpoints():
    """Every name in the sources, so that none is forgotten."""
    names = set()
    for room in ("src", "server"):
        for folder, _, files in os.walk(os.path.join(SOURCE, room)):
            for file in files:
                if file.endswith(".c"):
                    with open(os.path.join(folder, file)) as text:
                        names.update(re.findall(r'FAILPOINT\("([a-z-]+)"\)', text.read()))
    return sorted(names)


@unittest.skipUnless(FAULTS, "SCREE_FAULTS does not name the library of faults")
class Failpoints(unittest.TestCase):
    def live(self, session):
        """Passes every failpoint at least once."""
        job = session.submit(tiny(end_s=0.3))  # longer than the calls below take
        while session.ask("show", {"job": job})["state"] == "queued":  # what has not begun cannot be forked
            time.sleep(0.005)
        session.steer("set", job, ["params.slope_deg=28"])
        session.steer("checkpoint", job)
        session.steer("fork", job, ["material.mu_t=0.4"])
        session.steer("pause", job)
        session.steer("resume", job)
        session.read(job)

    def test_nothing_is_lost_at_any_of_them(self):
        names = failpoints()
        self.assertGreater(len(names), 15)
        for name in names:
            for passage in PASSAGES:
                with self.subTest(failpoint=name, passage=passage), tempfile.TemporaryDirectory(prefix="scree-crash-") as folder:
                    session = Session(folder, SCREE_FAILPOINT=f"{name}:{passage}")
                    try:
                        self.live(session)
                        session.wait_all()
                        if passage == 1:
                            self.assertFalse(session.deaths == 0 and session.daemon.alive(), "the failpoint was not passed")
                        session.revive()  # the judge replays jobs, which must not pass the failpoint
                        session.judge(replays=1 if SLOW else 0)
                    except BaseException:
                        sys.stderr.write(f"failpoint {name}\n" + session.daemon.log())
                        raise
                    finally:
                        session.close()


if __name__ == "__main__":
    unittest.main()
