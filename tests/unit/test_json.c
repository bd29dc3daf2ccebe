/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The strict reader: what it accepts is JSON, what it refuses it refuses with a
 * place; numbers survive printing to the bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "protocol/json.h"

static void refused(const char *text, size_t size, const char *where, const char *why)
{
    cJSON *json = NULL;
    struct scree_error error = {0};
    assert_int_equal(json_read(text, size, "t", &json, &error), SCREE_INVALID);
    assert_null(json);
    if (strncmp(error.message, where, strlen(where)) != 0 || !strstr(error.message, why))
        fail_msg("\"%s\" refused with \"%s\", expected \"%s ... %s\"", text, error.message, where, why);
}

static void grammar_is_that_of_rfc_8259(void **state)
{
    (void)state;
    static const struct {
        const char *text, *where, *why;
    } bad[] = {
        {"", "t:1:1", "value"},
        {"{\"a\": 1,}", "t:1:9", "key in double quotes"},
        {"{\"a\" 1}", "t:1:6", "\":\" is expected"},
        {"{\n  \"a\": tru\n}", "t:2:8", "value is expected"},
        {"[1 2]", "t:1:4", "\",\" or \"]\""},
        {"[01]", "t:1:3", "superfluous 0"},
        {"[1.]", "t:1:4", "digit is missing"},
        {"[-]", "t:1:2", "digit is missing"},
        {"[1e]", "t:1:4", "digit is missing"},
        {"[NaN]", "t:1:2", "NaN"},
        {"[Infinity]", "t:1:2", "NaN and Infinity"},
        {"[1e400]", "t:1:2", "beyond the range"},
        {"[-1e400]", "t:1:2", "beyond the range"},
        {"{} {}", "t:1:4", "behind the end"},
        {"\"abc", "t:1:5", "no end"},
        {"\"a\tb\"", "t:1:3", "control character"},
        {"\"\\x\"", "t:1:2", "unknown escape"},
        {"\"\\u12g4\"", "t:1:2", "hexadecimal"},
        {"\"\\u0000\"", "t:1:2", "\\u0000"},
        {"\"\\ud800\"", "t:1:8", "surrogate"},
        {"\"\\udc00\"", "t:1:2", "surrogate"},
        {"\"\xc0\xaf\"", "t:1:2", "UTF-8"},
        {"\"\xed\xa0\x80\"", "t:1:2", "UTF-8"},
        {"\"\xf5\x80\x80\x80\"", "t:1:2", "UTF-8"},
        {"\"\xe2\x82\"", "t:1:2", "UTF-8"},
        {"// comment\n{}", "t:1:1", "value"},
        {"{'a': 1}", "t:1:2", "double quotes"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        refused(bad[k].text, strlen(bad[k].text), bad[k].where, bad[k].why);
    refused("{\"a\":1}\0", 8, "t:1:8", "behind the end"); // a zero byte is not white space
}

static void duplicate_keys_are_named_by_their_path(void **state)
{
    (void)state;
    cJSON *json;
    struct scree_error error;
    static const char text[] = "{\"a\": [{\"b\": 1, \"\\u0062\": 2}]}"; // \u0062 is b
    assert_int_equal(json_read(text, strlen(text), "t", &json, &error), SCREE_INVALID);
    assert_string_equal(error.path, "a[0].b");
    assert_string_equal(error.message, "a[0].b: the key \"b\" stands twice");
}

static void depth_and_size_are_bounded(void **state)
{
    (void)state;
    char deep[2 * JSON_DEPTH_MAX + 8];
    memset(deep, '[', JSON_DEPTH_MAX + 1);
    memset(deep + JSON_DEPTH_MAX + 1, ']', JSON_DEPTH_MAX + 1);
    refused(deep, 2 * (JSON_DEPTH_MAX + 1), "t:1:", "nested too deeply");
    cJSON *json = NULL;
    assert_int_equal(json_read(deep + 1, 2 * JSON_DEPTH_MAX, "t", &json, NULL), SCREE_OK);
    cJSON_Delete(json);
    char *large = calloc(1, JSON_BYTES_MAX + 1);
    memset(large, ' ', JSON_BYTES_MAX + 1);
    refused(large, JSON_BYTES_MAX + 1, "t:", "more than");
    free(large);
}

static void valid_text_is_read(void **state)
{
    (void)state;
    static const char text[] = " { \"\xc3\xa9\": [true, false, null, -0.5e-3, \"\\ud83d\\ude00\\n\"] } \n";
    cJSON *json = NULL;
    assert_int_equal(json_read(text, strlen(text), "t", &json, NULL), SCREE_OK);
    const cJSON *list = json_get(json, "\xc3\xa9");
    assert_int_equal(cJSON_GetArraySize(list), 5);
    assert_true(cJSON_GetArrayItem(list, 3)->valuedouble == -0.5e-3);
    cJSON_Delete(json);
}

/* cJSON alone would print 0.30000000000000004 as 0.3. */
static void numbers_survive_printing(void **state)
{
    (void)state;
    struct rng rng = rng_start(3, 3);
    for (int k = 0; k < 100000; k++) {
        double value;
        uint64_t bits = rng_next(&rng);
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        if (k == 0)
            value = 0.1 + 0.2;
        if (k == 1)
            value = -0.0;
        if (k == 2)
            value = DBL_MAX;
        if (k == 3)
            value = 5e-324;
        if (k == 4)
            value = 9007199254740993.0;
        cJSON *object = cJSON_CreateObject(), *back = NULL;
        json_put_real(object, "v", value);
        char *text = json_print(object, k % 2);
        assert_int_equal(json_read(text, strlen(text), "t", &back, NULL), SCREE_OK);
        double read = json_number(back, "v", 1);
        assert_memory_equal(&read, &value, sizeof value);
        free(text);
        cJSON_Delete(object);
        cJSON_Delete(back);
    }
}

static void keys_are_compared_with_case(void **state)
{
    (void)state;
    cJSON *json = NULL;
    assert_int_equal(json_read("{\"Seed\": 1}", 11, "t", &json, NULL), SCREE_OK);
    assert_null(json_get(json, "seed"));
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grammar_is_that_of_rfc_8259), cmocka_unit_test(duplicate_keys_are_named_by_their_path),
        cmocka_unit_test(depth_and_size_are_bounded),  cmocka_unit_test(valid_text_is_read),
        cmocka_unit_test(numbers_survive_printing),    cmocka_unit_test(keys_are_compared_with_case),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
