/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Power spectra of a force, and the theory's shape of them.
 *
 * Convention (targets S0-30): two-sided, P(f) = |F~(f)|^2 / Dt with F~ the
 * continuous transform and the mean removed, N2/Hz: the integral over all f, both
 * signs, is the variance, and a Poisson train of rate r of impacts of impulse J
 * has P = r J^2 zeta(f tau). */
#ifndef SCREE_MEASURE_SPECTRUM_H
#define SCREE_MEASURE_SPECTRUM_H

#include <stddef.h>

#include "base/status.h"

/* ---- theory: one Hertz impact (seed 000 S6) ---- */

#define ZETA_T0       3.218065459719 // duration in tau: 2 (2/5)(5/4)^(2/5) B(2/5, 1/2) (eq. 43)
#define ZETA_CORNER   0.199664       // f_c = min{f: zeta(2f) < zeta(f) / 10}; printed as 0.200
#define ZETA_INTEGRAL 0.216272       // of zeta over f > 0

/* zeta (eq. 44) by quadrature; f in 1/tau, at least 0. Exact to 1e-7 for f below 8 / T0. */
double zeta(double f);

/* Time scale of an impact at speed v (eq. 42) of a sphere of diameter d on a fixed one; of two free ones it is
 * 4^(-1/5) of that. E* here is E / (1 - nu^2). m, kg/m3, Pa, m/s; s. */
double impact_time(double diameter, double density, double young, double poisson, double speed);

/* ---- estimate ---- */

enum { SPECTRUM_SEGMENT_MIN = 16, SPECTRUM_SEGMENTS_MAX = 64 };

/* Samples that `segments` half-overlapping segments need at least. */
size_t spectrum_samples_needed(size_t segments);
/* Length of each of `segments` half-overlapping ones out of n samples; even. The spectrum has length / 2 + 1 bins, at k / (length
 * dt). */
size_t spectrum_segment(size_t n, size_t segments);

/* Welch's estimate: Hann windows, half overlap, mean of all n samples removed. x[k * stride], dt apart; `power` has a
 * value for each bin. SCREE_INVALID says how many samples are needed. */
enum scree_status spectrum_welch(const double *x, size_t n, size_t stride, double dt, size_t segments, double *power,
                                 struct scree_error *err);

/* What a mean over blocks of dt leaves of power at f: sinc^2(f dt). */
double spectrum_block_gain(double f, double dt);

/* Bands [b width, (b + 1) width) of `bins` bins, df apart: how many; the mean frequency of a band's bins (of its ends
 * where it has none). The bin at 0 is of no band, nor is the highest where it alone would be one. */
size_t spectrum_band_count(size_t bins, double df, double width);
double spectrum_band_middle(size_t b, size_t bins, double df, double width);
/* Means over these bands. Returns how many, at most `room`; their middles into f. Bands without a bin are 0. */
size_t spectrum_bands(const double *power, size_t bins, double df, double width, double *f, double *band, size_t room);
/* The same over octaves below the highest frequency, lowest first: each [top / 2^(k+1), top / 2^k) that has a bin; f is its
 * geometric middle. */
size_t spectrum_octaves(const double *power, size_t bins, double df, double *f, double *band, size_t room);

/* ---- fit ---- */

struct spectrum_fit {
    double power;  // P_F^0, N2/Hz
    double tau;    // s; the corner frequency is ZETA_CORNER / tau
    double misfit; // root mean square of what is left, see spectrum_fit
    size_t used;   // frequencies
};
/* ln(P / P_F^0 + e) against ln(zeta(f tau) + e), least squares in two parameters over `range` in Hz, every frequency alike
 * (protocols 1.10). e is 2 %: impacts of a flow differ, so its spectrum lacks zeta's zeros, and what lies that far under
 * P_F^0 must not decide. SCREE_INVALID where fewer than 8 frequencies can be used, or power falls from the lowest 8 on, as
 * chains of lasting contacts make it: then there is no plateau to take P_F^0 from. */
enum scree_status spectrum_fit(const double *f, const double *power, size_t n, const double range[2], struct spectrum_fit *out,
                               struct scree_error *err);

#endif
