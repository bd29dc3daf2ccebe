/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `screed bench`: how fast the bare engine steps a given state. */
#ifndef SCREE_SERVER_BENCH_H
#define SCREE_SERVER_BENCH_H

int bench_main(int argc, char **argv);

#endif
