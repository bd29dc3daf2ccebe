# SPDX-License-Identifier: GPL-3.0-or-later
"""What an administrator gets: the config file, the unit, the manual pages, the
completion; and what the service manager is told."""
import json
import os
import re
import shutil
import socket
import subprocess
import tempfile
import time
import unittest

from raw import BIN, Daemon

SCREE, SCREED = os.path.join(BIN, "scree"), os.path.join(BIN, "screed")
DEPLOY = os.path.join(os.environ["SCREE_SOURCE"], "deploy")
QUICK = {"scenario": "collision"}
# Minutes to fill, with nothing to report before it stands.
SLOW_START = {"scenario": "incline", "params": {"nx": 60, "ny": 60, "nz": 40}, "time": {"end_s": 1}}


def run(*command, **how):
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, stdin=subprocess.DEVNULL, **how)


def options_of_screed():
    found = re.findall(r"^  --([a-z-]+) [A-Z]", run(SCREED, "--help").stdout, re.MULTILINE)
    assert len(found) > 10, found
    return set(found) - {"config"}


def verbs():
    return re.findall(r"^  ([a-z]+) +\S", run(SCREE, "--help").stdout.split("scree VERB --help")[0], re.MULTILINE)


class ConfigFile(unittest.TestCase):
    def setUp(self):
        with open(os.path.join(DEPLOY, "screed.conf"), encoding="utf-8") as file:
            self.lines = file.read().splitlines()
        self.settings = [line[1:] for line in self.lines if re.match(r"#[a-z-]+ = ", line)]

    def test_names_every_option_and_no_other(self):
        # An option that is not in the file is not found by who edits it.
        self.assertEqual({line.split(" = ")[0] for line in self.settings}, options_of_screed())

    def test_says_nothing_until_it_is_edited(self):
        # All is comment: installing it changes nothing.
        self.assertEqual([line for line in self.lines if line and not line.startswith("#")], [])

    def test_every_line_parses_once_uncommented(self):
        # The last line is wrong on purpose: it must be the first that is refused.
        with tempfile.NamedTemporaryFile("w", suffix=".conf") as file:
            file.write("\n".join(self.settings) + "\nnonsense = 1\n")
            file.flush()
            ended = run(SCREED, "--config", file.name)
        self.assertEqual(ended.returncode, 2)
        self.assertIn(f":{len(self.settings) + 1}: unknown option \"nonsense\"", ended.stderr)


class ServiceManager(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory(prefix="scree-test-"))
        self.inbox = self.enterContext(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))
        self.inbox.bind(os.path.join(self.folder, "notify"))

    def start(self, *options, watchdog_s=0.2):
        environment = {"NOTIFY_SOCKET": os.path.join(self.folder, "notify"), "WATCHDOG_USEC": str(int(1e6 * watchdog_s))}
        daemon = Daemon(options=options, environment=environment)
        self.addCleanup(daemon.remove)
        self.addCleanup(daemon.stop)
        return daemon

    def hear(self, timeout_s):
        self.inbox.settimeout(timeout_s)
        try:
            return self.inbox.recv(256).decode()
        except socket.timeout:
            return None

    def test_ready_alive_stopping(self):
        # Type=notify waits for the first, WatchdogSec for the second again and again.
        daemon = self.start()
        self.assertEqual(self.hear(20), "READY=1")
        self.assertEqual(daemon.control.ask("ping")["jobs"]["running"], 0)
        for _ in range(3):
            self.assertEqual(self.hear(5), "WATCHDOG=1")
        daemon.stop()
        heard = []
        while (word := self.hear(0.2)) is not None:
            heard.append(word)
        self.assertEqual(heard[-1], "STOPPING=1", heard)

    def test_watchdog_starves_when_a_job_does_not_move(self):
        # A loop that answers pings while its workers hang is what a watchdog is for.
        daemon = self.start("--stall-s", "1")
        job = daemon.control.submit(SLOW_START)
        end = time.monotonic() + 40
        while self.hear(1.5) is not None:  # fed every 0.1..1 s as long as all is well
            self.assertLess(time.monotonic(), end, "the watchdog was fed all the time")
        self.assertIn(f"job={job} has not moved", daemon.log())
        self.assertEqual(daemon.control.ask("show", {"job": job})["state"], "running")  # it answers all the same
        daemon.process.kill()  # its slice takes long

    def test_watchdog_is_fed_while_a_job_moves(self):
        # Long jobs are no hung ones.
        daemon = self.start("--stall-s", "1")
        job = daemon.control.submit({"scenario": "incline", "params": {"nx": 4, "ny": 4, "nz": 3}, "time": {"end_s": 1000},
                                     "stop": {"when": []}})
        while daemon.control.ask("show", {"job": job})["steps"] == 0:  # filling it may take longer than the limit
            time.sleep(0.05)
        while self.hear(0.01) is not None:
            pass
        end = time.monotonic() + 5
        while time.monotonic() < end:
            self.assertIsNotNone(self.hear(2.5))

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze here")
    def test_unit_is_hardened(self):
        # As measured by systemd itself: 0 is best, 10 worst.
        with open(os.path.join(DEPLOY, "screed.service"), encoding="utf-8") as file:
            unit = file.read().replace("@SCREED_PROGRAM@", SCREED).replace("@SCREED_CONFIG@", "/etc/screed.conf")
        path = os.path.join(self.folder, "screed.service")
        with open(path, "w", encoding="utf-8") as file:
            file.write(unit)
        ended = run("systemd-analyze", "security", "--offline=true", "--no-pager", path)
        score = re.search(r"exposure level for screed.service: ([0-9.]+)", ended.stdout)
        self.assertTrue(score, ended)
        print(f"systemd-analyze security: {score[1]}")
        self.assertLessEqual(float(score[1]), 1.5)


class Words(unittest.TestCase):
    def test_ping_tells_how_the_daemon_is(self):
        # What a dashboard needs, in one line of JSON.
        daemon = Daemon()
        self.addCleanup(daemon.remove)
        self.addCleanup(daemon.stop)
        ended = run(SCREE, "--connect", daemon.endpoint, "--json", "ping")
        about = json.loads(ended.stdout)
        for key in ("version", "uptime_s", "workers", "jobs", "grain_steps_per_s", "disk", "memory"):
            self.assertIn(key, about)
        self.assertGreater(about["disk"]["total_bytes"], about["disk"]["free_bytes"] * 0.5)
        self.assertGreater(about["memory"]["used_bytes"], 1e6)
        self.assertGreater(about["memory"]["available_bytes"], 1e6)
        plain = run(SCREE, "--connect", daemon.endpoint, "ping").stdout
        for word in ("rate", "memory", "disk"):
            self.assertRegex(plain, rf"(?m)^{word} +\S")

    def test_log_lines_are_time_level_pairs(self):
        # One line an event, so that a log can be searched by machine.
        daemon = Daemon()
        self.addCleanup(daemon.remove)
        daemon.control.wait(daemon.control.submit(QUICK))
        daemon.stop()
        lines = daemon.log().splitlines()
        self.assertGreaterEqual(len(lines), 5)
        for line in lines:
            self.assertRegex(line, r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z (info|warning|error) (\w[\w-]*=|ended)")

    def test_manual_pages_know_every_verb_and_option(self):
        # They are written by the programs; here, that nothing is lost on the way.
        page = run(SCREE, "--man").stdout.replace("\\-", "-")
        for verb in verbs():
            self.assertRegex(page, rf"(?m)^\.SS {verb}\b")
        page = run(SCREED, "--man").stdout.replace("\\-", "-")
        for option in options_of_screed():
            self.assertIn(f"--{option}", page)

    @unittest.skipUnless(shutil.which("man"), "no man here")
    def test_manual_pages_are_clean_roff(self):
        for program in (SCREE, SCREED):
            with tempfile.NamedTemporaryFile("w", suffix=".1") as file:
                file.write(run(program, "--man").stdout)
                file.flush()
                ended = run("man", "--warnings=w", "-l", file.name, env={**os.environ, "MANPAGER": "cat", "MANWIDTH": "120"})
            self.assertEqual((ended.returncode, ended.stderr), (0, ""))

    def complete(self, *words):
        script = run(SCREE, "--completion").stdout
        line = " ".join(f"'{word}'" for word in words)
        ended = run("bash", "-c", f"{script}\nCOMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _scree; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
                    env={**os.environ, "PATH": BIN + ":" + os.environ["PATH"]})
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended)
        return ended.stdout.split()

    def test_completion(self):
        # Verbs, options of the verb, and the words an option takes.
        self.assertEqual(set(self.complete("scree", "")) - {"--connect", "--json", "--help", "--version"}, set(verbs()))
        self.assertEqual(self.complete("scree", "tru"), ["trust"])
        self.assertIn("--role", self.complete("scree", "--json", "trust", "--"))
        self.assertEqual(self.complete("scree", "trust", "--role", "s"), ["submit", "steer"])
        self.assertEqual(self.complete("scree", "tail", "j1", "basal_force", "--format", "n"), ["ndjson"])
        self.assertIn("incline", self.complete("scree", "scenarios", "inc"))

    def test_completion_knows_the_jobs(self):
        # Ids of the daemon that the environment names.
        daemon = Daemon()
        self.addCleanup(daemon.remove)
        self.addCleanup(daemon.stop)
        job = daemon.control.submit(QUICK)
        os.environ["SCREE_CONNECT"] = daemon.endpoint
        self.addCleanup(os.environ.pop, "SCREE_CONNECT")
        self.assertEqual(self.complete("scree", "show", "j"), [job])


if __name__ == "__main__":
    unittest.main()
