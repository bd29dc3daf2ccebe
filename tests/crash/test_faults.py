# SPDX-License-Identifier: GPL-3.0-or-later
"""The N-th write, fsync, rename or malloc of a daemon fails, N = 1, 2, ... until
none is left to fail. The daemon may refuse, hold a job and try again, or fall over;
what it has acknowledged it must still know, and no job may come to other bits."""
import os
import sys
import tempfile
import unittest

from model import FAULTS, SLOW, Session, tiny

# In the fast version N grows in steps; in the slow one every N is taken up to EVERY, and from there on one in a hundred.
FAST = {"write": (1, 2, 5, 13, 40), "fsync": (1, 2, 4, 9, 20), "rename": (1, 2), "malloc": (1, 3, 20, 150, 900)}
EVERY = 100


def numbers(kind):
    if not SLOW:
        yield from FAST[kind]
        return
    number = 1
    while True:
        yield number
        number += 1 + number // EVERY


@unittest.skipUnless(FAULTS, "SCREE_FAULTS does not name the library of faults")
class Faults(unittest.TestCase):
    def live(self, session):
        from raw import Refused
        for act in (lambda: session.submit(tiny(end_s=0.02)), lambda: session.submit(tiny(seed=2, end_s=0.02))):
            try:
                act()
            except Refused as refused:  # said so, and did nothing
                self.assertIn(refused.code, ("io", "no_memory", "bad_request"), refused)
        for name in list(session.jobs):
            for op, assignments in (("set", ["params.slope_deg=28"]), ("checkpoint", None), ("pause", None), ("resume", None)):
                try:
                    session.steer(op, name, assignments)
                except (Refused, AssertionError) as refused:
                    if isinstance(refused, AssertionError) and '"code": "io"' not in str(refused) and "no_memory" not in str(refused):
                        raise
        session.wait_all()

    def once(self, kind, number, count=1):
        """True if there was a call to fail."""
        with tempfile.TemporaryDirectory(prefix="scree-crash-") as folder:
            mark = os.path.join(folder, "mark")
            session = Session(folder, SCREE_FAULT=f"{kind}:{number}:{count}", SCREE_FAULT_MARK=mark)
            try:
                self.live(session)
                session.daemon.stop()
                session.start()
                session.judge(replays=1 if SLOW else 0)
            except BaseException:
                sys.stderr.write(f"{kind}:{number}:{count}\n" + session.daemon.log())
                raise
            finally:
                session.close()
            return os.path.exists(mark)

    def sweep(self, kind):
        for number in numbers(kind):
            with self.subTest(kind=kind, number=number):
                if not self.once(kind, number):
                    print(f"{kind}: clean at {number}", file=sys.stderr)
                    return

    def test_writes(self):
        self.sweep("write")

    def test_syncs(self):
        self.sweep("fsync")

    def test_renames(self):
        self.sweep("rename")

    def test_memory(self):
        self.sweep("malloc")

    def test_a_disk_that_fails_for_a_while(self):
        # Not one write but the next hundred: jobs are held, tried again, and come to their end.
        self.once("write", 20, 100)


if __name__ == "__main__":
    unittest.main()
