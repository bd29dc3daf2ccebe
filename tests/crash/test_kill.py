# SPDX-License-Identifier: GPL-3.0-or-later
"""kill -9 at random instants under a mixed load of submits, steering, forks and
readers: judged by tests/support/model.py. 25 kills; 1,000 in the slow version."""
import os
import random
import sys
import tempfile
import time
import unittest

from model import SLOW, Session, tiny

KILLS = int(os.environ.get("SCREE_KILLS", 1000 if SLOW else 25))
KILLS_A_ROUND = 25  # then the history is judged and a new data directory begun


class Kill(unittest.TestCase):
    def act(self, session, rng, live):
        """One thing that a client may do."""
        if not live or (len(live) < 3 and rng.random() < 0.3):
            live.append(session.submit(tiny(seed=rng.randrange(1, 4), end_s=rng.choice((0.03, 0.06, 0.1)))))
            return
        name = rng.choice(live)
        action = rng.choices(("set", "pause", "resume", "checkpoint", "fork", "cancel", "look", "read"),
                             (4, 2, 4, 2, 1, 0.3, 3, 6))[0]
        if action == "set":
            session.steer("set", name, [f"params.slope_deg={rng.randrange(20, 30)}"])
        elif action == "fork" and len(session.jobs) < 12:
            answer = session.steer("fork", name, [f"material.mu_t={rng.randrange(1, 9) / 10}"])
            if answer and answer["fork"]:
                live.append(answer["fork"])
        elif action in ("pause", "resume", "checkpoint"):
            session.steer(action, name)
        elif action == "cancel":
            session.cancel(name)
        elif action == "look":
            session.look(name)
        elif action == "read":
            session.read(name)
        if session.ask("show", {"job": name})["state"] in ("done", "cancelled"):
            live.remove(name)

    def round(self, seed, kills):
        rng = random.Random(seed)
        with tempfile.TemporaryDirectory(prefix="scree-crash-") as folder:
            session = Session(folder)
            try:
                live = []
                for _ in range(kills):
                    end = time.monotonic() + rng.uniform(0.02, 0.3)
                    while time.monotonic() < end:
                        self.act(session, rng, live)
                    session.daemon.process.kill()  # whatever it is doing; the next request finds out
                    session.daemon.process.wait()
                    session.revive()
                session.judge(replays=4)
            except BaseException:
                sys.stderr.write(f"seed {seed}\n" + session.daemon.log())
                raise
            finally:
                session.close()

    def test_nothing_acknowledged_is_lost_or_doubled(self):
        first = int(os.environ.get("SCREE_SEED", 1))
        for k in range((KILLS + KILLS_A_ROUND - 1) // KILLS_A_ROUND):
            self.round(first + k, min(KILLS_A_ROUND, KILLS - k * KILLS_A_ROUND))


if __name__ == "__main__":
    unittest.main()
