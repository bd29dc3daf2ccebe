# SPDX-License-Identifier: GPL-3.0-or-later
"""The client driven as a process: what it refuses, how it exits, what it prints,
and a run from a spec to a result with a daemon of its own."""
import csv
import fcntl
import json
import os
import pty
import re
import resource
import select
import shutil
import signal
import struct
import subprocess
import tempfile
import termios
import threading
import time
import unittest

from raw import BIN, PATIENCE_S, Daemon

SCREE = os.path.join(BIN, "scree")
WRAPPED = bool(os.environ.get("SCREE_WRAPPED"))  # by tests/service/under_valgrind
HDF5 = b"\x89HDF\r\n\x1a\n"
COLLISION = {"scenario": "collision"}
# Runs for a second or so; LONG for longer than any test looks at it.
FLOW = {"scenario": "incline", "params": {"nx": 3, "ny": 3, "nz": 3}, "time": {"end_s": 0.2}, "stop": {"when": []}}
LONG = {**FLOW, "time": {"end_s": 100000}, "record": {"basal_force": {"every_s": 1e-4, "chunk": 100}}}
# Fails by itself: grains so soft that their weight presses them through the base.
BLOWUP = {"scenario": "incline", "params": {"nx": 3, "ny": 3, "nz": 3, "gravity_m_s2": 1000}, "material": {"young_Pa": 1e5},
          "stop": {"when": []}}
RUNNING = ("running",)


class Client(unittest.TestCase):
    """A temporary folder to work in, and no daemon unless a test starts one."""

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        self.work = self.path("work")
        self.temporary = self.path("tmp")
        os.mkdir(self.work)
        os.mkdir(self.temporary)
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith(("SCREE_", "XDG_", "LC_", "LANG"))}
        self.environment.update(SCREE_RUNTIME=self.path("run"), TMPDIR=self.temporary, TERM="xterm", LC_ALL="C.UTF-8")

    def path(self, name):
        return os.path.join(self.folder, name)

    def spec(self, spec, name="job.json"):
        """A file in the working folder that holds a spec, or any text."""
        with open(os.path.join(self.work, name), "wb") as file:
            file.write(spec if isinstance(spec, bytes) else json.dumps(spec).encode())
        return name

    def start(self, **how):
        daemon = Daemon(folder=self.folder, **how)
        self.addCleanup(daemon.stop, signal.SIGKILL)
        return daemon

    def scree(self, *arguments, stdin=None, timeout_s=PATIENCE_S, **environment):
        return subprocess.run([SCREE, *arguments], input=stdin, stdin=None if stdin is not None else subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=timeout_s, cwd=self.work,
                              env={**self.environment, **environment}, check=False)

    def open(self, *arguments, **how):
        """The client as a running process, in a session of its own."""
        process = subprocess.Popen([SCREE, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, cwd=self.work, env=self.environment, start_new_session=True, **how)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def refused(self, ended, *words, code=2):
        """Exit code and message, in one line of stderr at least, and nothing on stdout."""
        self.assertEqual(ended.returncode, code, ended)
        self.assertEqual(ended.stdout, "", ended)
        self.assertTrue(ended.stderr.startswith("scree: "), ended)
        for word in words:
            self.assertIn(word, ended.stderr)

    def nothing_left(self):
        """No folder of a private daemon, no half file."""
        self.assertEqual(os.listdir(self.temporary), [])
        for folder, folders, files in os.walk(self.work):
            for name in folders + files:
                self.assertFalse(name.startswith(".scree") or ".part-" in name, os.path.join(folder, name))

    def until(self, what, timeout_s=PATIENCE_S):
        """Waits until what() is true and returns it."""
        end = time.monotonic() + timeout_s
        while True:
            value = what()
            if value:
                return value
            self.assertLess(time.monotonic(), end, "waited in vain")
            time.sleep(0.02)


class Usage(Client):
    def test_no_verb_shows_the_verbs_and_is_a_mistake(self):
        ended = self.scree()
        self.assertEqual((ended.returncode, ended.stdout), (2, ""))
        self.assertIn("usage: scree", ended.stderr)

    def test_unknown_verb_names_the_nearest(self):
        self.refused(self.scree("sumbit"), '"sumbit"', '"submit"')

    def test_unknown_option_names_the_nearest(self):
        self.refused(self.scree("tail", "j1", "basal_force", "--form", "csv"), "--form", "--from?")

    def test_option_without_its_value(self):
        self.refused(self.scree("run", "job.json", "-o"), "-o", "value")

    def test_option_given_twice(self):
        # Which of the two is meant is a guess.
        self.refused(self.scree("run", "job.json", "-o", "a", "-o", "b"), "-o", "twice")

    def test_missing_and_superfluous_words(self):
        self.refused(self.scree("run"), "missing", "usage: scree run FILE")
        self.refused(self.scree("watch", "j1", "j2"), '"j2"')

    def test_every_verb_explains_itself_with_an_example(self):
        overview = self.scree("--help")
        self.assertEqual(overview.returncode, 0)
        verbs = [line.split()[0] for line in overview.stdout.splitlines() if line.startswith("  ") and line[2:3].isalpha()]
        verbs = [verb for verb in verbs if verb != "scree"]
        for verb in ("run check submit list show wait watch tail cancel fetch scenarios materials bench ping shutdown").split():
            self.assertIn(verb, verbs)
            ended = self.scree(verb, "--help") if verb != "bench" else self.scree("help", verb)
            self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended)
            self.assertIn(f"usage: scree {verb}", ended.stdout)
            if verb != "bench":
                self.assertIn(f"\n  scree {verb}", ended.stdout)

    def test_version(self):
        ended = self.scree("--version")
        self.assertEqual(ended.returncode, 0)
        self.assertRegex(ended.stdout, r"^scree \d+\.\d+\.\d+\n$")

    def test_full_disk_behind_stdout_is_told(self):
        with open("/dev/full", "w") as full:
            ended = subprocess.run([SCREE, "scenarios"], stdout=full, stderr=subprocess.PIPE, text=True, env=self.environment, check=False)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("cannot write", ended.stderr)

    def test_endpoint_that_is_none_is_refused(self):
        # Before anything is tried: a network endpoint has a host and a port.
        for endpoint in ("tcp://127.0.0.1", "tcp://:5555", "tcp://127.0.0.1:", "tcp://127.0.0.1:70000", "udp://127.0.0.1:5555"):
            self.refused(self.scree("--connect", endpoint, "ping"), endpoint, "form")


class BadSpecs(Client):
    """Each is refused by check, run and submit alike, before anything is started or sent."""

    def all_refuse(self, text, *words, options=()):
        name = self.spec(text)
        for verb in ("check", "run", "submit"):
            self.refused(self.scree(verb, name, *options), *words)
        self.assertEqual(os.listdir(self.work), [name])
        self.nothing_left()

    def test_unreadable_file(self):
        for verb in ("check", "run", "submit"):
            self.refused(self.scree(verb, "none.json"), "none.json", "No such file")
            self.refused(self.scree(verb, "."), "directory")

    def test_invalid_json_with_line_and_column(self):
        self.all_refuse(b'{"scenario": "collision",\n  "seed": }', "job.json:2:11")

    def test_nan(self):
        self.all_refuse(b'{"scenario": "collision", "params": {"speed_m_s": NaN}}', "job.json:1:", "NaN")

    def test_number_beyond_double_precision(self):
        self.all_refuse(b'{"scenario": "collision", "seed": 1e400}', "job.json:1:35")

    def test_duplicate_key(self):
        self.all_refuse(b'{"scenario": "collision", "seed": 1, "seed": 2}', "job.json", "seed", "twice")

    def test_unknown_key_names_the_nearest(self):
        self.all_refuse({"scenario": "incline", "params": {"slop_deg": 20}}, "job.json: params.slop_deg", '"slope_deg"')

    def test_wrong_type(self):
        self.all_refuse({"scenario": "incline", "params": {"slope_deg": "steep"}}, "params.slope_deg", "a number", "a string")

    def test_out_of_range_names_value_range_and_unit(self):
        self.all_refuse({"scenario": "incline", "params": {"slope_deg": 123}}, "params.slope_deg: 123 is outside 0..60 deg")

    def test_step_too_large_for_the_stiffness(self):
        self.all_refuse({"scenario": "incline", "time": {"step_s": 1e-5}}, "time.step_s", "largest stable step")

    def test_domain_smaller_than_two_grains(self):
        self.all_refuse({"scenario": "incline", "params": {"nx": 1}}, "params.nx: 1 is outside 2..")

    def test_more_memory_than_there_is(self):
        # Says how much it needs. Only check knows this machine's memory; run and submit ask the daemon.
        name = self.spec({"scenario": "incline", "params": {"nx": 2000, "ny": 2000, "nz": 7}})
        self.refused(self.scree("check", name), "memory", "GB")
        self.refused(self.scree("run", name), "memory", "GB")
        self.nothing_left()

    def test_bad_setting(self):
        self.all_refuse(COLLISION, "--set", options=("--set", "seed"))
        self.all_refuse(COLLISION, "params.sped_m_s", '"speed_m_s"', options=("--set", "params.sped_m_s=1"))

    def test_one_bad_file_among_good_ones_submits_nothing(self):
        daemon = self.start()
        self.refused(self.scree("submit", self.spec(COLLISION, "a.json"), self.spec({"scenario": "x"}, "b.json")), "b.json")
        self.assertEqual(daemon.control.ask("list")["jobs"], [])


class NoDaemon(Client):
    def test_every_verb_that_needs_one_says_so(self):
        name = self.spec(COLLISION)
        for arguments in (["ping"], ["list"], ["show", "j1"], ["wait", "j1"], ["watch", "j1"], ["tail", "j1", "basal_force"],
                          ["cancel", "j1"], ["fetch", "j1"], ["shutdown"], ["submit", name]):
            self.refused(self.scree(*arguments), "no daemon", self.path("run"), code=69)
        self.assertEqual(os.listdir(self.work), [name])

    def test_a_daemon_that_was_named_is_not_replaced_by_a_private_one(self):
        # Else a typing mistake would run the job where nobody looks for it.
        name = self.spec(COLLISION)
        endpoint = "ipc://" + self.path("elsewhere")
        self.refused(self.scree("run", name, "--connect", endpoint), endpoint, code=69)
        self.refused(self.scree("run", name, SCREE_CONNECT=endpoint), endpoint, code=69)
        self.assertEqual(os.listdir(self.work), [name])

    def test_silent_socket_is_given_up(self):
        # Somebody listens and never answers: no call may wait for ever.
        import socket
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(self.path("mute"))
            listener.listen(64)
            start = time.monotonic()
            self.refused(self.scree("--connect", "ipc://" + self.path("mute"), "list"), "not answered", code=69)
            self.assertLess(time.monotonic() - start, 30)

    @unittest.skipIf(WRAPPED, "copies the program")
    def test_daemon_of_somebody_else(self):
        runtime = self.path("run")
        self.start()
        program = shutil.copy(SCREE, self.path("scree"))
        os.chmod(self.folder, 0o755)
        other = {"user": 65534, "group": 65534, "extra_groups": []} if os.getuid() == 0 else {}
        if not other:
            os.chmod(runtime, 0)
            self.addCleanup(os.chmod, runtime, 0o700)
        ended = subprocess.run([program, "ping"], capture_output=True, text=True, env=self.environment, check=False, **other)
        self.refused(ended, "somebody else", code=77)

    def test_check_needs_none(self):
        ended = self.scree("check", self.spec(FLOW), "--set", "params.slope_deg=24.125")
        self.assertEqual(ended.returncode, 0, ended)
        resolved = json.loads(ended.stdout)
        self.assertEqual(resolved["params"]["slope_deg"], 24.125)
        self.assertIn("grain-steps/s", ended.stderr)
        # What it prints is a spec that resolves to itself.
        again = self.scree("check", "-", stdin=ended.stdout)
        self.assertEqual(again.stdout, ended.stdout)

    def test_check_json_is_one_object_with_the_cost(self):
        ended = self.scree("check", self.spec(FLOW), "--set", "time.end_s=0.25", "--json")
        answer = json.loads(ended.stdout)
        self.assertEqual(ended.stdout.count("\n"), 1)
        self.assertEqual(answer["cost"]["moving"], 27)
        self.assertEqual(answer["cost"]["steps"], 1000000)
        self.assertEqual(answer["cost"]["grain_steps"], 27 * 1000000)
        self.assertGreater(answer["cost"]["seconds"], 0)
        self.assertGreater(answer["cost"]["bytes"], 0)

    def test_scenarios_show_units_ranges_and_defaults(self):
        listed = self.scree("scenarios")
        self.assertIn("incline", listed.stdout)
        one = self.scree("scenarios", "incline").stdout
        row = next(line for line in one.splitlines() if "params.slope_deg" in line)
        for word in ("23.5", "0..60", "deg"):
            self.assertIn(word, row.split())
        lines = [json.loads(line) for line in self.scree("scenarios", "--json").stdout.splitlines()]
        self.assertEqual([line["name"] for line in lines][:2], ["incline", "channel"])
        self.refused(self.scree("scenarios", "inclin"), '"incline"')

    def test_materials_carry_their_erratum(self):
        # Who takes beta from the preset must learn that it does not give the paper's restitution.
        self.assertIn("71.2 ns", self.scree("materials").stdout)
        self.assertIn("71.2 ns", " ".join(self.scree("materials", "glass-beads-2mm").stdout.split()))
        lines = [json.loads(line) for line in self.scree("--json", "materials").stdout.splitlines()]
        self.assertIn("71.2 ns", lines[0]["note"])
        self.refused(self.scree("materials", "glass-beds-2mm"), '"glass-beads-2mm"')


class PrivateRun(Client):
    def test_bodies_that_are_none_are_refused_before_they_are_queued(self):
        """What only geometry tells, by field: a job, a study of it, and one of whose trials only the last is none."""
        cube = "0 0 0, 0.02 0 0, 0 0.02 0, 0.02 0.02 0, 0 0 0.02, 0.02 0 0.02, 0 0.02 0.02, 0.02 0.02 0.02"
        dent = "0 0 0, 0.02 0 0, 0 0.02 0, 0 0 0.02, 0.004 0.004 0.004"
        flat = "0 0 0, 0.02 0 0, 0 0.02 0, 0.02 0.02 0"
        apart = "0 0 0, 0.02 0 0, 0 0.02 0, 0 0 0.02; 0.1 0 0, 0.12 0 0, 0.1 0.02 0, 0.1 0 0.02"
        for points, words in ((dent, "not convex"), (flat, "part 0"), (apart, "shares no volume")):
            job = {"scenario": "settle", "params": {"count": 2, "length_m": 0.3, "width_m": 0.3,
                                                    "body": {"shape": "hulls", "points_m": points}},
                   "material": {"stiffness_N_m": 1e7}, "time": {"step_s": 1e-6, "end_s": 1e-3}}
            for spec in job, {"study": "sweep", "job": job, "grid": {"seed": [1, 2]}}:
                self.refused(self.scree("run", self.spec(spec)), "params.body.points_m", words)
            good = {**job, "params": {**job["params"], "body": {"shape": "hulls", "points_m": cube}}}
            spec = {"study": "sweep", "job": good, "grid": {"params.body.points_m": [cube, cube, points]}}
            self.refused(self.scree("run", self.spec(spec)), "trial 2: params.body.points_m", words)
        self.nothing_left()

    def test_runs_fetches_and_leaves_nothing_else(self):
        ended = self.scree("run", self.spec(COLLISION), "-o", "out")
        self.assertEqual(ended.returncode, 0, ended)
        self.assertIn("starting a private one", ended.stderr)
        for word in ("verdict", "restitution", "result", "out/result.h5"):
            self.assertIn(word, ended.stdout)
        self.assertEqual(os.listdir(os.path.join(self.work, "out")), ["result.h5"])
        with open(os.path.join(self.work, "out", "result.h5"), "rb") as file:
            self.assertEqual(file.read(8), HDF5)
        self.nothing_left()
        self.assertEqual(self.scree("ping").returncode, 69)

    def test_flow_reports_force_against_weight(self):
        ended = self.scree("run", self.spec(FLOW), "-o", "flow.h5", timeout_s=240)
        self.assertEqual(ended.returncode, 0, ended)
        for word in ("of the weight", "solid_fraction", "mean_velocity", "grain-steps/s"):
            self.assertIn(word, ended.stdout)
        self.assertTrue(os.path.exists(os.path.join(self.work, "flow.h5")))

    def test_without_o_a_new_folder_each_time(self):
        # A later run must not write over an earlier one's result.
        name = self.spec(COLLISION)
        for _ in range(2):
            self.assertEqual(self.scree("run", name).returncode, 0)
        self.assertEqual(sorted(os.listdir(self.work)), [name, "scree-collision-j1", "scree-collision-j1-2"])

    def test_json_is_one_object(self):
        ended = self.scree("--json", "run", "-", "-o", "out", "--set", "params.speed_m_s=0.362", stdin=json.dumps(COLLISION))
        self.assertEqual(ended.returncode, 0, ended)
        self.assertEqual(ended.stdout.count("\n"), 1)
        record = json.loads(ended.stdout)
        self.assertEqual((record["state"], record["file"]), ("done", "out/result.h5"))
        self.assertEqual(record["spec"]["params"]["speed_m_s"], 0.362)

    def test_place_of_the_result_is_tried_before_the_run(self):
        name = self.spec(LONG)
        self.refused(self.scree("run", name, "-o", "/proc/scree/out"), "/proc/scree")
        self.refused(self.scree("run", name, "-o", "/proc/scree.h5"), "/proc")  # a folder that is there, and takes no file
        self.refused(self.scree("run", name, "-o", name), name, "Not a directory")
        os.mkdir(os.path.join(self.work, "folder.h5"))
        self.refused(self.scree("run", name, "-o", "folder.h5"), "folder.h5", "no file")

    def test_refused_place_leaves_no_new_folder(self):
        os.makedirs(os.path.join(self.work, "a", "x.h5"))
        self.refused(self.scree("run", self.spec(COLLISION), "-o", "a/x.h5"), "x.h5")
        self.assertEqual(os.listdir(os.path.join(self.work, "a")), ["x.h5"])

    def test_progress_lines_where_there_is_no_terminal(self):
        # Anything over two seconds says something, without escape sequences.
        process = self.open("run", self.spec(LONG), "-o", "out")
        self.until(lambda: "grain-steps/s" in process.stderr.readline())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 3, err)
        self.assertNotIn("\x1b", out + err)

    def test_interrupt_cancels_and_keeps_the_result(self):
        process = self.open("run", self.spec(LONG), "-o", "out")
        self.until(lambda: "running" in process.stderr.readline())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 3, err)
        self.assertIn("cancelled", out)
        self.assertEqual(os.listdir(os.path.join(self.work, "out")), ["result.h5"])
        self.nothing_left()

    def private_daemon(self, process):
        """Process id of the screed that a client has started."""
        def find():
            with open(f"/proc/{process.pid}/task/{process.pid}/children") as children:
                return [int(pid) for pid in children.read().split()]
        return self.until(find)[0]

    @staticmethod
    def runs(pid):
        try:
            with open(f"/proc/{pid}/stat") as stat:
                return stat.read().split()[2] != "Z"  # a zombie waits for an init that this machine may not have
        except FileNotFoundError:
            return False

    def test_killed_client_leaves_no_daemon(self):
        # Nobody is there to tidy up; the kernel tells the daemon.
        process = self.open("run", self.spec(LONG), "-o", "out")
        daemon = self.private_daemon(process)
        self.until(lambda: "running" in process.stderr.readline())
        process.kill()
        process.wait()
        self.until(lambda: not self.runs(daemon))

    def test_killed_private_daemon_is_told(self):
        process = self.open("run", self.spec(LONG), "-o", "out")
        daemon = self.private_daemon(process)
        self.until(lambda: "running" in process.stderr.readline())
        os.kill(daemon, signal.SIGKILL)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 69, err)
        self.assertIn("private daemon is gone", err)
        self.nothing_left()

    @unittest.skipIf(WRAPPED, "copies the program")
    def test_no_screed_beside_it(self):
        program = shutil.copy(SCREE, self.path("scree"))
        ended = subprocess.run([program, "run", self.spec(COLLISION), "-o", "out"], capture_output=True, text=True, cwd=self.work,
                               env=self.environment, check=False)
        self.refused(ended, self.path("screed"), code=69)
        self.assertFalse(os.path.exists(os.path.join(self.work, "out")))


class Terminal(Client):
    """On a terminal: the bar, the sparkline, the colours, and Ctrl-C from the keyboard."""

    def on_terminal(self, *arguments, until=None, columns=80, **environment):
        """Runs it on a terminal of its own; types Ctrl-C once `until` matches. (exit code, what was shown)."""
        pid, terminal = pty.fork()
        if pid == 0:
            os.chdir(self.work)
            os.execve(SCREE, [SCREE, *arguments], {**self.environment, **environment})
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        shown = b""
        end = time.monotonic() + 2 * PATIENCE_S
        try:
            while time.monotonic() < end:
                if not select.select([terminal], [], [], 0.2)[0]:
                    continue
                try:
                    piece = os.read(terminal, 65536)
                except OSError:  # Linux's way to say that the other side is closed
                    break
                if not piece:
                    break
                shown += piece
                if until and re.search(until, shown.decode(errors="replace")):
                    os.write(terminal, b"\x03")
                    until = None
        finally:
            os.close(terminal)
            if time.monotonic() >= end:
                os.kill(pid, signal.SIGKILL)
            _, status = os.waitpid(pid, 0)
        return os.waitstatus_to_exitcode(status), shown[-20000:].decode(errors="replace")

    def test_bar_rate_and_sparkline_until_the_keyboard_says_stop(self):
        code, shown = self.on_terminal("run", self.spec(LONG), "-o", "out", until=r"ETA .*grain-steps/s  Fz ")
        self.assertEqual(code, 3, shown)
        for word in ("grain-steps/s", "ETA", "░", "cancelled", "\x1b[K"):
            self.assertIn(word, shown)
        self.assertTrue(any(block in shown for block in "▁▂▃▄▅▆▇█"), shown)
        self.assertTrue(os.path.exists(os.path.join(self.work, "out", "result.h5")))

    def test_bar_stays_on_its_line(self):
        # A line that is longer than the terminal is wide cannot be rewritten.
        for columns in (30, 80, 200):
            code, shown = self.on_terminal("run", self.spec(LONG), "-o", "out", until="\x1b.Kj1.*%.*\r.*%.*\r", columns=columns)
            self.assertEqual(code, 3, shown)
            for bar in re.findall("\x1b.K(j1[^\r\n^]*%[^\r\n^]*)", shown):
                self.assertLess(len(bar), columns)

    def test_plain_characters_without_utf8(self):
        _, shown = self.on_terminal("run", self.spec(LONG), "-o", "out", until="  Fz ", LC_ALL="C")
        self.assertTrue(shown.isascii(), shown)
        self.assertIn("....", shown)

    def test_no_color(self):
        name = self.spec(COLLISION)
        _, coloured = self.on_terminal("run", name, "-o", "out")
        _, plain = self.on_terminal("run", name, "-o", "out", NO_COLOR="1")
        self.assertIn("\x1b[32mdone", coloured)
        self.assertNotRegex(plain, r"\x1b\[\d")


class WithDaemon(Client):
    def setUp(self):
        super().setUp()
        self.daemon = self.start()

    def submit(self, spec, *options):
        ended = self.scree("submit", self.spec(spec), *options)
        self.assertEqual(ended.returncode, 0, ended)
        return ended.stdout.strip()

    def test_submit_wait_show_fetch(self):
        job = self.submit(COLLISION)
        self.assertRegex(job, r"^j\d+$")
        waited = self.scree("wait", job)
        self.assertEqual((waited.returncode, waited.stdout.split()[:2]), (0, [job, "done"]))
        shown = self.scree("show", job, "--json")
        self.assertEqual(shown.stdout.count("\n"), 1)
        record = json.loads(shown.stdout)
        for key in ("id state scenario verdict time_s end_s steps grains grain_steps_per_s streams spec build error").split():
            self.assertIn(key, record)
        for stream in record["streams"].values():
            self.assertLessEqual({"chunks", "samples"}, set(stream))
        self.assertIn("restitution", self.scree("show", job).stdout)
        fetched = self.scree("fetch", job)
        self.assertEqual((fetched.returncode, fetched.stdout), (0, f"{job}.h5\n"))
        with open(os.path.join(self.work, f"{job}.h5"), "rb") as ours, open(record["result"], "rb") as theirs:
            self.assertEqual(ours.read(), theirs.read())
        self.nothing_left()

    def test_numbers_arrive_with_all_their_bits(self):
        # cJSON by itself prints this one as 0.3.
        job = self.submit(COLLISION, "--set", "params.speed_m_s=0.30000000000000004")
        record = json.loads(self.scree("show", job, "--json").stdout)
        self.assertEqual(record["spec"]["params"]["speed_m_s"], 0.30000000000000004)

    def test_run_uses_the_daemon_and_reuses_what_it_has(self):
        first = self.scree("run", self.spec(COLLISION), "-o", "a")
        self.assertEqual(first.returncode, 0, first)
        self.assertNotIn("private", first.stderr)
        second = self.scree("run", self.spec(COLLISION), "-o", "b")
        self.assertIn("before", second.stderr)
        self.assertEqual(len(self.daemon.control.ask("list")["jobs"]), 1)
        third = self.scree("run", self.spec(COLLISION), "-o", "c", "--again")
        self.assertEqual(third.returncode, 0)
        self.assertEqual(len(self.daemon.control.ask("list")["jobs"]), 2)

    def test_run_submits_nothing_when_the_result_has_no_place(self):
        self.refused(self.scree("run", self.spec(COLLISION), "-o", "/proc/scree.h5"), "/proc")
        self.assertEqual(self.daemon.control.ask("list")["jobs"], [])

    def test_list_is_one_object_a_line(self):
        jobs = [self.submit(COLLISION, "--again") for _ in range(3)]
        self.scree("wait", *jobs)
        lines = [json.loads(line) for line in self.scree("list", "--json").stdout.splitlines()]
        self.assertEqual([line["id"] for line in lines], jobs[::-1])
        self.assertEqual(len(self.scree("list", "--limit", "2", "--json").stdout.splitlines()), 2)
        self.assertEqual(self.scree("list", "--state", "queued", "--json").stdout, "")
        self.refused(self.scree("list", "--state", "bogus"), "states")
        self.assertIn(jobs[0], self.scree("list").stdout)

    def test_unknown_job_and_stream(self):
        for arguments in (["show", "j99"], ["wait", "j99"], ["watch", "j99"], ["tail", "j99", "basal_force"], ["cancel", "j99"],
                          ["fetch", "j99", "-o", "new"]):
            self.refused(self.scree(*arguments), '"j99"')
        self.assertEqual(os.listdir(self.work), [])
        job = self.submit(COLLISION)
        self.scree("wait", job)
        self.refused(self.scree("tail", job, "contatc"), '"contact"')
        self.refused(self.scree("tail", job, "contact", "--from", "100000"), "100000")
        self.refused(self.scree("tail", job, "contact", "--from", "-1"), "--from")
        self.refused(self.scree("tail", job, "contact", "--format", "xml"), "csv, ndjson, raw")

    def test_cancel_decides_how_wait_and_watch_exit(self):
        job = self.submit(LONG)
        waiting = self.open("wait", job)
        watching = self.open("watch", job)
        cancelled = self.scree("cancel", job)
        self.assertEqual(cancelled.returncode, 0, cancelled)
        self.assertEqual(waiting.wait(PATIENCE_S), 3)
        self.assertEqual(watching.wait(PATIENCE_S), 3)
        # Again changes nothing and is no mistake.
        self.assertEqual(self.scree("cancel", job).stdout, f"{job} cancelled\n")

    def test_failed_job_exits_with_one_and_says_why(self):
        # A job's own failure is 1, not 2: the spec was accepted.
        job = self.submit(BLOWUP)
        ended = self.scree("wait", job)
        self.assertEqual(ended.returncode, 1, ended)
        self.assertIn(f"{job} failed: ", ended.stderr)
        ran = self.scree("run", self.spec(BLOWUP), "-o", "out", "--again")
        self.assertEqual(ran.returncode, 1, ran)
        self.assertIn("failed", ran.stdout)

    def test_interrupt_leaves_a_shared_daemons_job_alone(self):
        process = self.open("run", self.spec(LONG), "-o", "out")
        self.until(lambda: "running" in process.stderr.readline())
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, -signal.SIGINT, err)
        self.assertIn("scree watch j1", err)
        self.assertEqual(self.daemon.control.ask("show", {"job": "j1"})["state"], "running")
        self.assertEqual(os.listdir(self.work), ["job.json"])

    def test_fetch_of_a_running_job_is_its_result_so_far(self):
        job = self.submit(LONG)
        self.until(lambda: self.daemon.control.ask("show", {"job": job})["streams"].get("basal_force", {}).get("chunks", 0) > 0)
        ended = self.scree("fetch", job, "-o", "early.h5", "--json")
        self.assertEqual(ended.returncode, 0, ended)
        answer = json.loads(ended.stdout)
        self.assertEqual((answer["complete"], answer["file"]), (False, "early.h5"))
        self.assertIn("so far", ended.stderr)
        self.assertEqual(os.path.getsize(os.path.join(self.work, "early.h5")), answer["bytes"])

    def test_fetch_checks_the_place(self):
        job = self.submit(COLLISION)
        self.scree("wait", job)
        self.refused(self.scree("fetch", job, "-o", "/proc/x.h5"), "/proc")
        self.refused(self.scree("fetch", job, "-o", "job.json"), "job.json")

    def test_fetch_that_cannot_be_finished_leaves_the_older_file(self):
        # The disk fills in the middle: no half result, and none in place of a whole one.
        job = self.submit(COLLISION)
        self.scree("wait", job)
        with open(os.path.join(self.work, f"{job}.h5"), "w") as older:
            older.write("older")
        limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))}
        process = self.open("fetch", job, **limit)
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 1, err)
        self.assertIn("cannot write", err)
        self.assertEqual(sorted(os.listdir(self.work)), [f"{job}.h5", "job.json"])
        with open(os.path.join(self.work, f"{job}.h5")) as older:
            self.assertEqual(older.read(), "older")

    def test_tail_formats_agree(self):
        job = self.submit(COLLISION)
        self.scree("wait", job)
        text = self.scree("tail", job, "contact").stdout
        header, *rows = list(csv.reader(text.splitlines()))
        self.assertEqual(header[0], "t (s)")
        self.assertTrue(all(" (" in name for name in header), header)
        table = [[float(cell) for cell in row] for row in rows]
        lines = [json.loads(line) for line in self.scree("tail", job, "contact", "--format", "ndjson").stdout.splitlines()]
        self.assertEqual([line["seq"] for line in lines], list(range(len(lines))))
        self.assertEqual([row for line in lines for row in line["rows"]], [row[1:] for row in table])
        raw = subprocess.run([SCREE, "tail", job, "contact", "--format", "raw"], capture_output=True, env=self.environment, check=True)
        self.assertEqual(memoryview(raw.stdout).cast("d").tolist(), [value for row in table for value in row[1:]])
        record = self.daemon.control.ask("show", {"job": job})
        self.assertEqual(len(rows), record["streams"]["contact"]["samples"])

    def test_tail_from_a_chunk_and_without_following(self):
        job = self.submit(LONG)
        self.until(lambda: self.daemon.control.ask("show", {"job": job})["streams"].get("basal_force", {}).get("chunks", 0) > 5)
        ended = self.scree("tail", job, "basal_force", "--from", "3", "--no-follow", "--json")
        self.assertEqual(ended.returncode, 0, ended)
        sequence = [json.loads(line)["seq"] for line in ended.stdout.splitlines()]
        self.assertEqual(sequence, list(range(3, 3 + len(sequence))))
        self.assertGreaterEqual(len(sequence), 3)

    def test_head_behind_tail_is_no_failure(self):
        job = self.submit(LONG)
        process = self.open("tail", job, "basal_force")
        for _ in range(3):
            process.stdout.readline()
        process.stdout.close()
        self.assertEqual(process.wait(PATIENCE_S), 0)
        self.assertEqual(process.stderr.read(), "")

    def test_ping_and_shutdown(self):
        pong = json.loads(self.scree("ping", "--json").stdout)
        self.assertEqual((pong["protocol"], pong["pid"]), ("SC1", self.daemon.process.pid))
        self.assertEqual(self.scree("shutdown").returncode, 0)
        self.assertEqual(self.daemon.process.wait(PATIENCE_S), 0)
        self.assertEqual(self.scree("ping").returncode, 69)

    def test_daemon_gone_mid_watch(self):
        job = self.submit(LONG)
        process = self.open("watch", job)
        self.until(lambda: "running" in process.stderr.readline())
        self.daemon.process.kill()
        start = time.monotonic()
        _, err = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 69, err)
        self.assertIn("gone", err)
        self.assertGreater(time.monotonic() - start, 5)  # it was given a chance to come back

    def test_full_queue_asks_to_try_again(self):
        # One long job keeps the only worker; the queue takes ten thousand more.
        control = self.daemon.control
        control.submit(LONG)
        control.wait("j1", RUNNING)
        header = '{"id": "fill-%d", "op": "submit"}'
        body = json.dumps({"spec": COLLISION, "again": True}).encode()
        refused = False
        for start in range(0, 12000, 500):
            for k in range(start, start + 500):
                control.socket.send_multipart([b"SC1", (header % k).encode(), body])
            refused = any([not control.reply()["ok"] for _ in range(500)])
            if refused:
                break
        self.assertTrue(refused)
        self.refused(self.scree("submit", self.spec(COLLISION), "--again"), code=75)


class Restart(Client):
    def test_tail_goes_on_across_a_restart_without_gap(self):
        daemon = self.start()
        spec = {**FLOW, "time": {"end_s": 1.5}, "record": {"basal_force": {"every_s": 2.5e-5, "chunk": 100}}}
        job = self.scree("submit", self.spec(spec)).stdout.strip()
        lines = []
        process = self.open("tail", job, "basal_force", "--json")
        reader = threading.Thread(target=lambda: lines.extend(iter(process.stdout.readline, "")))  # or a full pipe stops it
        reader.start()
        self.until(lambda: len(lines) >= 5)
        daemon.process.kill()
        daemon.process.wait()
        self.until(lambda: "gone" in process.stderr.readline())
        again = self.start()
        err = process.stderr.read()
        self.assertEqual(process.wait(2 * PATIENCE_S), 0, err)
        reader.join()
        seen = [json.loads(line) for line in lines]
        self.assertIn("back", err)
        self.assertEqual([chunk["seq"] for chunk in seen], list(range(len(seen))))
        record = again.control.wait(job)
        self.assertEqual(sum(chunk["n"] for chunk in seen), record["streams"]["basal_force"]["samples"])
        # And what was read before is what the rerun wrote.
        whole = [json.loads(line) for line in self.scree("tail", job, "basal_force", "--json").stdout.splitlines()]
        self.assertEqual(seen, whole)


if __name__ == "__main__":
    unittest.main(verbosity=2)
