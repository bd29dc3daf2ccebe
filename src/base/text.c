/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as text: tries precisions from short to long. UTF-8 by table 3-7 of
 * the Unicode standard: the second byte's range depends on the first. */
#include "base/text.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *text_real(double value, char out[TEXT_REAL_MAX])
{
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(out, TEXT_REAL_MAX, "%.*g", digits, value);
        if (strtod(out, NULL) == value)
            break;
    }
    return out;
}

size_t text_utf8_length(const char *text, const char *end)
{
    const unsigned char *p = (const unsigned char *)text;
    size_t left = (size_t)(end - text), length;
    unsigned char low = 0x80, high = 0xbf; // of the second byte
    if (left == 0)
        return 0;
    if (p[0] < 0x80)
        return 1;
    if (p[0] >= 0xc2 && p[0] <= 0xdf) {
        length = 2;
    } else if (p[0] >= 0xe0 && p[0] <= 0xef) {
        length = 3;
        low = p[0] == 0xe0 ? 0xa0 : low;   // below: overlong
        high = p[0] == 0xed ? 0x9f : high; // above: surrogates
    } else if (p[0] >= 0xf0 && p[0] <= 0xf4) {
        length = 4;
        low = p[0] == 0xf0 ? 0x90 : low;   // below: overlong
        high = p[0] == 0xf4 ? 0x8f : high; // above: beyond U+10FFFF
    } else {
        return 0;
    }
    if (left < length || p[1] < low || p[1] > high)
        return 0;
    for (size_t k = 2; k < length; k++)
        if ((p[k] & 0xc0) != 0x80)
            return 0;
    return length;
}

void text_clean(char *text)
{
    char *to = text;
    for (const char *from = text, *end = text + strlen(text); from < end;) {
        size_t length = text_utf8_length(from, end);
        unsigned char first = (unsigned char)from[0], second = (unsigned char)from[1];
        bool control = first < 0x20 || first == 0x7f || (first == 0xc2 && second < 0xa0);
        if (length == 0 || control) {
            *to++ = '?';
            from += length ? length : 1;
        } else {
            memmove(to, from, length);
            to += length;
            from += length;
        }
    }
    *to = 0;
}
