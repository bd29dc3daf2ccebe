# SPDX-License-Identifier: GPL-3.0-or-later
"""A disk without room, on a small file system of its own: jobs are held with the
reason, queries still work, and all goes on by itself once there is room again."""
import os
import shutil
import subprocess
import tempfile
import time
import unittest

from model import Session, tiny

SIZE = 48 << 20


class Disk(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-crash-"))
        mounted = self.mount_image() or self.mount("-t", "tmpfs", "-o", f"size={SIZE}", "scree")
        if not mounted:
            self.skipTest("mounting a file system is not permitted here")
        self.addCleanup(subprocess.run, ["umount", "-l", self.folder], check=False)
        self.ballast = os.path.join(self.folder, "ballast")

    def mount(self, *arguments):
        return subprocess.run(["mount", *arguments, self.folder], capture_output=True, check=False).returncode == 0

    def mount_image(self):
        """A real file system in a file; where there is no loop device for it, one in memory does."""
        image = self.enterContext(tempfile.NamedTemporaryFile(prefix="scree-disk-"))
        image.truncate(SIZE)
        made = shutil.which("mkfs.ext4") and subprocess.run(["mkfs.ext4", "-q", "-m", "0", image.name], capture_output=True, check=False)
        return made and made.returncode == 0 and self.mount("-o", "loop", image.name)

    def session(self, floor_gb):
        session = Session(self.folder, workers=1, options=("--checkpoint-s", "0.2", "--disk-floor", str(floor_gb)))
        self.addCleanup(session.close)
        return session

    def fill(self, left):
        """Leaves so many bytes free."""
        try:
            while (disk := os.statvfs(self.folder)).f_bavail * disk.f_frsize > left:
                with open(self.ballast, "ab") as file:
                    file.write(bytes(min(1 << 16, disk.f_bavail * disk.f_frsize - left)))
        except OSError:
            pass  # a job was quicker

    def test_below_the_floor_jobs_wait_and_go_on_by_themselves(self):
        session = self.session(0.004)
        running = session.submit(tiny(end_s=4, record={"basal_force": None}))
        queued = session.submit(tiny(seed=2))
        control = session.daemon.control
        control.wait(running, states=("running",))
        time.sleep(0.2)
        self.fill(3 << 20)
        for name in (running, queued):
            record = control.wait(name, states=("held",), timeout_s=20)
            self.assertRegex(record["why"], r"^disk 3 MB free, floor 4 MB$")
        self.assertEqual({job["state"] for job in control.ask("list")["jobs"]}, {"held"})
        self.assertGreaterEqual(control.ask("ping")["jobs"]["held"], 2)
        os.remove(self.ballast)
        control.wait(running)
        self.assertIn("resumed at step", session.daemon.log())
        for name in (running, queued):
            session.judge_state(name, 60)

    def test_a_disk_that_runs_full_loses_nothing(self):
        # No floor: writes fail for want of room, in the log, the journal or a checkpoint.
        session = self.session(0)
        job = session.submit(tiny(end_s=0.6, record={"basal_force": {"every_s": 2.5e-6, "chunk": 512}}))
        session.daemon.control.wait(job, states=("running",))
        self.fill(600 << 10)
        record = session.daemon.control.wait(job, states=("held",), timeout_s=30)
        self.assertTrue(record["why"])
        session.read(job, 0.3)
        os.remove(self.ballast)
        session.judge(replays=1)

    def test_submits_on_a_full_disk_are_refused_and_not_half_taken(self):
        from raw import Refused
        session = self.session(0)
        self.fill(0)
        with self.assertRaises(Refused) as refused:
            for seed in range(1, 200):
                session.submit(tiny(seed=seed))
        self.assertEqual(refused.exception.code, "io")
        os.remove(self.ballast)
        session.judge(replays=0)


if __name__ == "__main__":
    unittest.main()
