/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See history.h: when the instants are full every second one is dropped. */
#include "measure/history.h"

#include <string.h>

enum scree_status history_start(struct history *h, struct measure_buffer *buffers, size_t width, struct scree_error *err)
{
    *h = (struct history){.width = width, .every = 1};
    buffers[HISTORY_NOW].most = width;
    buffers[HISTORY_KEPT].most = HISTORY_INSTANTS * (width + 1);
    return measure_buffer_resize(&buffers[HISTORY_NOW], width, err);
}

double *history_sums(struct measure_buffer *buffers)
{
    return buffers[HISTORY_NOW].values;
}

enum scree_status history_keep(struct history *h, struct measure_buffer *buffers, double time_s, struct scree_error *err)
{
    struct measure_buffer *kept = &buffers[HISTORY_KEPT];
    size_t stride = h->width + 1, count = kept->count / stride;
    if (++h->added % h->every)
        return SCREE_OK;
    if (count == HISTORY_INSTANTS) {
        /* Instants at every, 2 every, ...: the second, fourth, ... stay. */
        for (size_t k = 0; k < count / 2; k++)
            memmove(kept->values + k * stride, kept->values + (2 * k + 1) * stride, stride * sizeof *kept->values);
        count /= 2;
        kept->count = count * stride;
        h->every *= 2;
        if (h->added % h->every)
            return SCREE_OK;
    }
    enum scree_status status = measure_buffer_resize(kept, (count + 1) * stride, err);
    if (status)
        return status;
    kept->values[count * stride] = time_s;
    memcpy(kept->values + count * stride + 1, buffers[HISTORY_NOW].values, h->width * sizeof *kept->values);
    return SCREE_OK;
}

double history_since(const struct history *h, const struct measure_buffer *buffers, double from_s, double *out)
{
    const struct measure_buffer *now = &buffers[HISTORY_NOW], *kept = &buffers[HISTORY_KEPT];
    size_t stride = h->width + 1, count = kept->count / stride;
    const double *then = NULL;
    /* Times are products of steps: an instant that rounding put after from_s is at it. */
    for (size_t k = 0; k < count && kept->values[k * stride] <= from_s * (1 + 1e-12); k++)
        if (memcmp(kept->values + k * stride + 1, now->values, h->width * sizeof *now->values) != 0)
            then = kept->values + k * stride;
    for (size_t v = 0; v < h->width; v++)
        out[v] = now->values[v] - (then ? then[v + 1] : 0);
    return then ? then[0] : 0;
}

bool history_sound(const struct history *h, const struct measure_buffer *buffers, size_t width)
{
    return h->width == width && h->every > 0 && buffers[HISTORY_NOW].count == width &&
           buffers[HISTORY_KEPT].count % (width + 1) == 0;
}
