# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage on disk while no daemon runs: a checkpoint or a row of the stream log with
a byte flipped or its end cut off. What is damaged is refused by name; what can be
computed again is, to the same bits."""
import glob
import os
import random
import signal
import sqlite3
import struct
import tempfile
import time
import unittest

from model import SLOW, Session, tiny
from raw import Refused

ROUNDS = 40 if SLOW else 2


def damaged(row, rng):
    """(column, value): each byte of a row of the log with one bit changed, its payload cut short."""
    for column, code in (("t0", "<d"), ("dt", "<d"), ("rows", "<q"), ("crc", "<q"), ("hash", "<q"), ("payload", None)):
        value = bytearray(struct.pack(code, row[column]) if code else row[column])
        for place in range(len(value)):
            value[place] ^= (bit := 1 << rng.randrange(8))
            yield column, struct.unpack(code, value)[0] if code else bytes(value)
            value[place] ^= bit
    for length in range(len(row["payload"])):
        yield "payload", row["payload"][:length]


class Damage(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-crash-"))
        self.session = Session(self.folder, workers=1)
        self.addCleanup(self.session.close)

    def path(self, job, pattern):
        return sorted(glob.glob(os.path.join(self.folder, "data", "jobs", job, pattern)))

    def killed_in_the_middle(self, **more):
        """A job with two checkpoints, its daemon killed."""
        job = self.session.submit(tiny(end_s=1.5, **more))  # a job that ends keeps no checkpoints
        end = time.monotonic() + 30
        while len(self.path(job, "checkpoint-*.h5")) < 2:
            assert time.monotonic() < end, "no checkpoints"
            time.sleep(0.02)
        self.session.read(job, 0.2)
        self.session.daemon.stop(signal.SIGKILL)
        return job

    def spoil(self, path, rng, cut):
        size = os.path.getsize(path)
        place = rng.randrange(size)
        with open(path, "r+b") as file:
            if cut:
                file.truncate(place)
            else:
                file.seek(place)
                byte = file.read(1)[0]
                file.seek(place)
                file.write(bytes((byte ^ 1 << rng.randrange(8),)))

    def test_older_checkpoint_takes_the_place_of_a_damaged_one(self):
        rng = random.Random(1)
        for k in range(ROUNDS):
            job = self.killed_in_the_middle(seed=k + 1)
            older, newest = self.path(job, "checkpoint-*.h5")[-2:]
            self.spoil(newest, rng, k % 2)
            self.session.start()
            self.session.daemon.control.wait(job)
            log = self.session.daemon.log()
            self.assertIn(os.path.basename(newest), log)
            self.assertIn(f"{job} resumed at step={int(os.path.basename(older).split('-')[1])}", log)
        self.session.judge(replays=1)

    def test_without_a_sound_checkpoint_it_starts_from_nothing(self):
        rng = random.Random(2)
        job = self.killed_in_the_middle()
        for path in self.path(job, "checkpoint-*.h5"):
            self.spoil(path, rng, False)
        self.session.start()
        self.session.judge(replays=1)
        self.assertNotIn("resumed", self.session.daemon.log())

    def change_row(self, job, seq, column="payload"):
        with sqlite3.connect(self.path(job, "streams.db")[0]) as database:
            value, = database.execute(f"SELECT {column} FROM chunks WHERE stream = 'basal_force' AND seq = ?", (seq,)).fetchone()
            changed = bytes((value[0] ^ 1,)) + value[1:] if column == "payload" else value + 1e-6 if column in ("t0", "dt") else value ^ 1
            database.execute(f"UPDATE chunks SET {column} = ? WHERE stream = 'basal_force' AND seq = ?", (changed, seq))
        database.close()

    def last_row(self, job):
        with sqlite3.connect(self.path(job, "streams.db")[0]) as database:
            last, = database.execute("SELECT MAX(seq) FROM chunks WHERE stream = 'basal_force'").fetchone()
        database.close()
        return last

    def test_damaged_row_of_a_running_job_is_written_again(self):
        # A checkpoint that stands behind it is not enough then: the log must have what it builds on.
        for column in ("payload", "t0"):
            job = self.killed_in_the_middle(seed=3 + (column == "t0"))
            self.change_row(job, self.last_row(job), column)
            self.session.start()
            self.session.daemon.control.wait(job)
        self.session.judge(replays=1)

    def test_damaged_row_of_an_ended_job_is_refused_by_name(self):
        """Every byte of a row changed in one bit, and its payload cut short by every number of bytes."""
        rng = random.Random(3)
        job = self.session.submit(tiny(record={"basal_force": {"every_s": 1e-4, "chunk": 16}}, end_s=0.02))
        self.session.daemon.control.wait(job)
        streams = self.session.daemon.streams()
        self.addCleanup(streams.close)
        path, = self.path(job, "streams.db")
        with sqlite3.connect(path, isolation_level=None) as database:
            where = "WHERE stream = 'basal_force' AND seq = 7"
            columns = ("t0", "dt", "rows", "crc", "hash", "payload")
            row = dict(zip(columns, database.execute(f"SELECT {', '.join(columns)} FROM chunks {where}").fetchone(), strict=True))
            for column, value in damaged(row, rng):
                database.execute(f"UPDATE chunks SET {column} = ? {where}", (value,))
                with self.assertRaises(Refused) as refused:
                    streams.read_all("k", job, "basal_force", 7)
                self.assertEqual(refused.exception.code, "corrupt", (column, value))
                self.assertIn("chunk 7 of basal_force", refused.exception.message)
                database.execute(f"UPDATE chunks SET {column} = ? {where}", (row[column],))
            database.execute(f"UPDATE chunks SET payload = x'00' {where}")
        self.assertEqual(len(streams.read_all("later", job, "basal_force", 8)[0]), self.last_row(job) - 7)
        with self.assertRaises(Refused):
            streams.read_all("all", job, "basal_force")

    def test_lost_row_is_no_end_of_the_stream(self):
        job = self.session.submit(tiny())
        self.session.daemon.control.wait(job)
        self.session.daemon.stop()
        with sqlite3.connect(self.path(job, "streams.db")[0]) as database:
            database.execute("DELETE FROM chunks WHERE stream = 'basal_force' AND seq = 5")
        database.close()
        self.session.start()
        streams = self.session.daemon.streams()
        self.addCleanup(streams.close)
        with self.assertRaises(Refused) as refused:
            streams.read_all("k", job, "basal_force")
        self.assertIn("chunk 5 of basal_force", refused.exception.message)


if __name__ == "__main__":
    unittest.main()
