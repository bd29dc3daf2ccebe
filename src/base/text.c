/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as text: tries precisions from short to long. */
#include "base/text.h"

#include <stdio.h>
#include <stdlib.h>

char *text_real(double value, char out[TEXT_REAL_MAX])
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(out, TEXT_REAL_MAX, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return out;
}
