/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the kernels of contact laws share: vectors a lane, and the walk over a
 * list of touching pairs in groups of four. Included by sources that are
 * compiled once per instruction set, named by ISA. */
#ifndef SCREE_DEM_LANES_H
#define SCREE_DEM_LANES_H

#include "base/lanes.h"
#include "dem/law.h"

/* Evaluates four pairs into four results; `ledger` is a constant after inlining. */
typedef void lanes_group(const struct law_coefs *c, const struct pair_batch *b, const uint32_t p[4],
                         struct contact_out *const out[4], struct contact_loss *const loss[4], int ledger);

/* All whole groups in place, the rest padded with its last contact into spare rows. */
SIMD_INLINE void lanes_batch(const struct law_coefs *c, const struct pair_batch *b, lanes_group *group, int ledger)
{
    size_t k = 0;
    for (; k + 4 <= b->active_count; k += 4) {
        struct contact_out *out[4] = {&b->out[k], &b->out[k + 1], &b->out[k + 2], &b->out[k + 3]};
        struct contact_loss *loss[4] = {0};
        if (ledger)
            for (int l = 0; l < 4; l++)
                loss[l] = &b->loss[k + (size_t)l];
        group(c, b, &b->active[k], out, loss, ledger);
    }
    if (k < b->active_count) {
        uint32_t p[4];
        _Alignas(32) struct contact_out spare_out;
        _Alignas(32) struct contact_loss spare_loss;
        struct contact_out *out[4];
        struct contact_loss *loss[4];
        for (size_t l = 0; l < 4; l++) {
            size_t at = k + l < b->active_count ? k + l : b->active_count - 1;
            p[l] = b->active[at];
            out[l] = k + l < b->active_count ? &b->out[at] : &spare_out;
            loss[l] = !ledger || k + l >= b->active_count ? &spare_loss : &b->loss[at];
        }
        group(c, b, p, out, loss, ledger);
    }
}

#endif
