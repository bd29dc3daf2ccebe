#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The power spectrum of the normal force on the base, while the flow runs.

    PYTHONPATH=client/python python3 client/python/examples/live_spectrum.py client/examples/slidequake.json
    PYTHONPATH=client/python python3 client/python/examples/live_spectrum.py j1 --png spectrum.png

The argument is a job to submit (a file) or one that is there (an id). Prints a bar
for each third of an octave, in dB above the quietest, once a second; --png draws the
last one if matplotlib is there. Welch's method: segments of `--segment` samples that
overlap by half, each with a Hann window; the mean of their one-sided power
spectral densities, in N^2/Hz."""
import argparse
import os
import sys
import time

import numpy

import scree


class Welch:
    """The running mean of periodograms."""

    def __init__(self, segment):
        self.window = numpy.hanning(segment)
        self.left = numpy.empty(0)
        self.total, self.count = numpy.zeros(segment // 2 + 1), 0

    def add(self, samples, dt_s):
        self.left = numpy.concatenate([self.left, samples])
        size = self.window.size
        while self.left.size >= size:
            piece = self.left[:size]
            power = numpy.abs(numpy.fft.rfft((piece - piece.mean()) * self.window)) ** 2
            self.total += 2 * dt_s * power / (self.window**2).sum()
            self.count += 1
            self.left = self.left[size // 2 :]

    def density(self):
        return self.total / max(1, self.count)


def thirds(frequency, density):
    """Mean density in bands of a third of an octave."""
    edges = frequency[1] * 2 ** (numpy.arange(0, 3 * numpy.log2(frequency[-1] / frequency[1]) + 1) / 3)
    for low, high in zip(edges[:-1], edges[1:]):
        inside = (frequency >= low) & (frequency < high)
        if inside.any():
            yield low, density[inside].mean()


def show(job, t, welch, dt_s):
    frequency = numpy.fft.rfftfreq(welch.window.size, dt_s)
    bands = [(f, d) for f, d in thirds(frequency, welch.density()) if d > 0]
    if not bands:
        return
    if sys.stdout.isatty():
        print("\x1b[H\x1b[J", end="")
    print(f"{job.id}  t = {t:.4g} s, {welch.count} segments")
    quietest = min(d for _, d in bands)
    for f, d in bands:
        level = 10 * numpy.log10(d / quietest)
        print(f"{f:10.4g} Hz {d:10.3e} N^2/Hz {'#' * int(level)}")
    sys.stdout.flush()


def draw(path, welch, dt_s):
    import matplotlib  # pylint: disable=import-outside-toplevel

    matplotlib.use("Agg")
    from matplotlib import pyplot  # pylint: disable=import-outside-toplevel

    pyplot.loglog(numpy.fft.rfftfreq(welch.window.size, dt_s)[1:], welch.density()[1:])
    pyplot.xlabel("frequency (Hz)")
    pyplot.ylabel("power spectral density of the normal force (N$^2$/Hz)")
    pyplot.savefig(path, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("job", help="a JSON file to submit, or the id of a job")
    parser.add_argument("--connect", help="endpoint of the daemon")
    parser.add_argument("--segment", type=int, default=4096, help="samples in a segment (4096)")
    parser.add_argument("--png", help="draw the last spectrum into this file")
    arguments = parser.parse_args()
    daemon = scree.connect(arguments.connect)
    job = daemon.submit(arguments.job) if os.path.exists(arguments.job) else daemon.job(arguments.job)
    welch, shown, chunk = Welch(arguments.segment), 0.0, None
    for chunk in job.chunks("basal_force"):
        welch.add(chunk.column("Fz"), chunk.dt_s)
        if time.monotonic() - shown > 1:
            shown = time.monotonic()
            show(job, chunk.t[-1], welch, chunk.dt_s)
    if chunk is None:
        sys.exit(f"{job.id} has no basal force")
    show(job, chunk.t[-1], welch, chunk.dt_s)
    if arguments.png:
        draw(arguments.png, welch, chunk.dt_s)


if __name__ == "__main__":
    main()
