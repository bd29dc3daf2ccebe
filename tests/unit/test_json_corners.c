/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Corners of the JSON reader: whole messages, every UTF-8 sequence, cut texts,
 * files. Texts are handed over in buffers of their exact size, so that a
 * sanitizer sees a reader that looks behind the end. */
#include "unit.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "base/rng.h"
#include "base/text.h"
#include "protocol/json.h"

static enum scree_status read_bytes(const char *text, size_t size, cJSON **out, struct scree_error *err)
{
    char *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    memcpy(exact, text, size);
    enum scree_status status = json_read(exact, size, "t", out, err);
    free(exact);
    return status;
}

static void accepted(const char *text, const char *printed)
{
    struct scree_error err = {0};
    cJSON *tree = NULL;
    if (read_bytes(text, strlen(text), &tree, &err))
        fail_msg("%s: %s", text, err.message);
    char *again = json_print(tree, false);
    assert_string_equal(again, printed ? printed : text);
    free(again);
    cJSON_Delete(tree);
}

static void refused_bytes(const char *text, size_t size, const char *message)
{
    struct scree_error err = {0};
    cJSON *tree = NULL;
    if (!read_bytes(text, size, &tree, &err))
        fail_msg("was accepted: %.*s", (int)size, text);
    assert_null(tree);
    assert_error(&err, SCREE_INVALID, "", message);
}

static void refused(const char *text, const char *message)
{
    refused_bytes(text, strlen(text), message);
}

/* Every kind of value the grammar knows is read, at the root too. */
static void reads_the_grammar(void **state)
{
    (void)state;
    accepted("null", NULL);
    accepted(" \t\r\n true \n", "true");
    accepted("[]", NULL);
    accepted("{}", NULL);
    accepted("[ ]", "[]");
    accepted("{ }", "{}");
    accepted("[1,-2,0,-0.5,1e3,1E+3,25e-1]", "[1,-2,0,-0.5,1000,1000,2.5]");
    accepted("{\"a\":{\"b\":[false,null]}}", NULL);
    accepted("\"\\\"\\\\\\/\\b\\f\\n\\r\\t\"", "\"\\\"\\\\/\\b\\f\\n\\r\\t\"");
    accepted("\"\\u00e9\\uD83D\\uDE00\"", "\"\xc3\xa9\xf0\x9f\x98\x80\"");
    accepted("\"\xc3\xa9\xf0\x9f\x98\x80\"", NULL);
    accepted("{\"\":1}", NULL);
}

/* What other readers let pass is refused, and the message says where. */
static void refuses_bad_grammar(void **state)
{
    (void)state;
    refused("", "t:1:1: a value is missing at the end");
    refused("   ", "t:1:4: a value is missing at the end");
    refused("{\n  \"a\": 1,\n}", "t:3:1: a key in double quotes is expected");
    refused("{\"a\":1,}", "t:1:8: a key in double quotes is expected");
    refused("{a:1}", "t:1:2: a key in double quotes is expected");
    refused("{\"a\" 1}", "t:1:6: \":\" is expected behind a key");
    refused("{\"a\":1 \"b\":2}", "t:1:8: \",\" or \"}\" is expected");
    refused("{\"a\":}", "t:1:6: a value is expected");
    refused("[1 2]", "t:1:4: \",\" or \"]\" is expected");
    refused("[1,]", "t:1:4: a value is expected");
    refused("[1", "t:1:3: \",\" or \"]\" is expected");
    refused("[,1]", "t:1:2: a value is expected");
    refused("1 2", "t:1:3: text behind the end of the JSON value");
    refused("{}}", "t:1:3: text behind the end of the JSON value");
    refused("'a'", "t:1:1: a value is expected");
    refused("tru", "t:1:1: a value is expected");
    refused("True", "t:1:1: a value is expected");
    refused("// c\n1", "t:1:1: a value is expected");
    refused("\f1", "t:1:1: a value is expected");
    refused_bytes("1\0", 2, "t:1:2: text behind the end of the JSON value");
    refused_bytes("\0", 1, "t:1:1: a value is expected");
}

/* cJSON takes most of these; a spec must not depend on who reads it. */
static void refuses_bad_numbers(void **state)
{
    (void)state;
    refused("01", "t:1:2: a number starts with a superfluous 0");
    refused("-01", "t:1:3: a number starts with a superfluous 0");
    refused("+1", "t:1:1: a value is expected");
    refused(".5", "t:1:1: a value is expected");
    refused("1.", "t:1:3: a digit is missing in a number");
    refused("1.e5", "t:1:3: a digit is missing in a number");
    refused("1e", "t:1:3: a digit is missing in a number");
    refused("1e+", "t:1:4: a digit is missing in a number");
    refused("-", "t:1:2: a digit is missing in a number");
    refused("[-x]", "t:1:2: a digit is missing in a number");
    refused("0x10", "t:1:2: text behind the end of the JSON value");
    refused("NaN", "t:1:1: NaN and Infinity are not numbers in JSON");
    refused("[Infinity]", "t:1:2: NaN and Infinity are not numbers in JSON");
    refused("[-Infinity]", "t:1:2: NaN and Infinity are not numbers in JSON");
}

/* 1e400 is a number for the grammar and infinity for a double. */
static void refuses_numbers_beyond_double(void **state)
{
    (void)state;
    refused("{\n \"a\": [1,\n  1e400]}", "t:3:3: a number beyond the range of double precision");
    refused("-1e400", "t:1:1: a number beyond the range of double precision");
    refused("1.8e308", "t:1:1: a number beyond the range of double precision");
    accepted("1.7976931348623157e308", "1.7976931348623157e+308");
    accepted("1e-400", "0");
    refused("0.0000000000000000000000000000000000000000000000000000000000000001", "t:1:1: a number of more than 63 characters");
}

/* Strings hold characters: no raw control bytes, no half surrogates, no NUL that would cut them short. */
static void refuses_bad_strings(void **state)
{
    (void)state;
    refused("\"a", "t:1:3: a string has no end");
    refused("\"a\\", "t:1:3: unknown escape in a string");
    refused("\"\\x41\"", "t:1:2: unknown escape in a string");
    refused_bytes("\"\\\0\"", 4, "t:1:2: unknown escape in a string");
    refused("\"\\u12g4\"", "t:1:2: \\u wants four hexadecimal digits");
    refused("\"\\u12", "t:1:2: \\u wants four hexadecimal digits");
    refused("\"\\u0000\"", "t:1:2: \\u0000 is not accepted in a string");
    refused("{\"\\u0000\":1}", "t:1:3: \\u0000 is not accepted in a string");
    refused("\"\\uD800\"", "t:1:8: half of a surrogate pair in a string");
    refused("\"\\uD800\\u0041\"", "t:1:8: half of a surrogate pair in a string");
    refused("\"\\uDC00\"", "t:1:2: half of a surrogate pair in a string");
    refused("\"a\nb\"", "t:1:3: a control character in a string");
    refused_bytes("\"a\0b\"", 5, "t:1:3: a control character in a string");
    refused("\"\xc3\xa9\x80\"", "t:1:3: invalid UTF-8"); // columns count characters
    refused("\"\xc0\xaf\"", "t:1:2: invalid UTF-8");
    refused("\"\xed\xa0\x80\"", "t:1:2: invalid UTF-8");
    refused("\"\xf4\x90\x80\x80\"", "t:1:2: invalid UTF-8");
    refused("\"\xf0\x9f\x98", "t:1:2: invalid UTF-8");
    refused("\xef\xbb\xbf{}", "t:1:1: a value is expected"); // a byte order mark
}

/* Sequences of up to three bytes, all of them, and the corners of four, against
 * the definition: a code point's own encoding and no other. */
static void utf8_is_exact(void **state)
{
    (void)state;
    static char valid[1 << 24];
    memset(valid, 0, sizeof valid);
    for (unsigned code = 0; code < 0x10000; code++) {
        if (code >= 0xd800 && code <= 0xdfff)
            continue;
        if (code < 0x80)
            valid[code << 16] = 1;
        else if (code < 0x800)
            valid[(0xc0 | code >> 6) << 16 | (0x80 | (code & 63)) << 8] = 2;
        else
            valid[(0xe0 | code >> 12) << 16 | (0x80 | (code >> 6 & 63)) << 8 | (0x80 | (code & 63))] = 3;
    }
    for (unsigned bits = 0; bits < 1 << 24; bits++) {
        const char text[3] = {(char)(bits >> 16), (char)(bits >> 8), (char)bits};
        char expected = valid[bits] | valid[bits & 0xffff00] | valid[bits & 0xff0000];
        if (text_utf8_length(text, text + 3) != (size_t)expected)
            fail_msg("%06x: length %zu, not %d", bits, text_utf8_length(text, text + 3), expected);
    }
    const struct {
        const char *text;
        size_t length;
    } four[] = {{"\xf0\x8f\xbf\xbf", 0}, {"\xf0\x90\x80\x80", 4}, {"\xf4\x8f\xbf\xbf", 4}, {"\xf4\x90\x80\x80", 0},
                {"\xf5\x80\x80\x80", 0}, {"\xf1\x80\x80\x7f", 0}, {"\xf1\x80\xc0\x80", 0}, {"\xf1\x80\x80\x80", 4}};
    for (size_t k = 0; k < COUNT(four); k++)
        assert_int_equal(text_utf8_length(four[k].text, four[k].text + 4), four[k].length);
    for (size_t cut = 0; cut < 4; cut++)
        assert_int_equal(text_utf8_length(four[1].text, four[1].text + cut), 0);
}

/* Two values for one key: which one counts would depend on the reader. Keys are compared as what they mean. */
static void refuses_duplicate_keys(void **state)
{
    (void)state;
    const struct {
        const char *text, *path, *message;
    } cases[] = {
        {"{\"a\":1,\"a\":1}", "a", "a: the key \"a\" stands twice"},
        {"{\"a\":1,\"b\":2,\"\\u0061\":3}", "a", "a: the key \"a\" stands twice"},
        {"{\"p\":{\"q\":[0,{\"x\":1,\"y\":2,\"x\":3}]}}", "p.q[1].x", "p.q[1].x: the key \"x\" stands twice"},
        {"[{\"\":1,\"\":2}]", "[0].", "[0].: the key \"\" stands twice"},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct scree_error err = {0};
        cJSON *tree = NULL;
        assert_int_equal(read_bytes(cases[k].text, strlen(cases[k].text), &tree, &err), SCREE_INVALID);
        assert_null(tree);
        assert_error(&err, SCREE_INVALID, cases[k].path, cases[k].message);
    }
    accepted("{\"a\":1,\"A\":2}", NULL);
    accepted("[{\"a\":1},{\"a\":1}]", NULL);
}

/* Recursion is bounded by the format, not by the stack. */
static void refuses_deep_nesting(void **state)
{
    (void)state;
    char text[2 * JSON_DEPTH_MAX + 8];
    for (int depth = JSON_DEPTH_MAX; depth <= JSON_DEPTH_MAX + 1; depth++) {
        memset(text, '[', (size_t)depth);
        text[depth] = '1';
        memset(text + depth + 1, ']', (size_t)depth);
        text[2 * depth + 1] = 0;
        if (depth == JSON_DEPTH_MAX)
            accepted(text, NULL);
        else
            refused(text, "t:1:33: nested too deeply");
    }
    static char tower[JSON_BYTES_MAX];
    memset(tower, '[', sizeof tower);
    refused_bytes(tower, sizeof tower, "t:1:33: nested too deeply");
}

/* The limit in bytes is a limit, and the last allowed byte is allowed. */
static void refuses_long_texts(void **state)
{
    (void)state;
    static char text[JSON_BYTES_MAX + 1];
    memset(text, ' ', sizeof text);
    text[0] = '7';
    struct scree_error err;
    cJSON *tree = NULL;
    assert_int_equal(read_bytes(text, JSON_BYTES_MAX, &tree, &err), SCREE_OK);
    cJSON_Delete(tree);
    refused_bytes(text, sizeof text, "t: 1048577 bytes are more than the 1048576 that are accepted");
}

/* No prefix of a document is a document: a cut connection cannot be mistaken for a short spec. */
static void refuses_every_prefix(void **state)
{
    (void)state;
    const char *text = "{\"scenario\":\"incline\",\"p\":{\"a\":[1.5e-7,true,null,\"\\u00e9\xc3\xa9\"]}}";
    for (size_t size = 0; size < strlen(text); size++) {
        struct scree_error err = {0};
        cJSON *tree = NULL;
        if (!read_bytes(text, size, &tree, &err))
            fail_msg("accepted: %.*s", (int)size, text);
        assert_null(tree);
    }
}

/* A client reads a spec, changes it and sends it on: what it did not change must arrive to the bit. */
static void numbers_read_are_printed_to_the_bit(void **state)
{
    (void)state;
    accepted("[0.30000000000000004,2.2250738585072014e-308,9007199254740991,-0]", NULL);
    struct rng rng = rng_start(5, 1);
    for (int k = 0; k < 20000; k++) {
        char text[64];
        double value;
        uint64_t bits = rng_next(&rng);
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        snprintf(text, sizeof text, "{\"a\":[%.17g]}", value);
        cJSON *first = NULL, *second = NULL;
        assert_int_equal(read_bytes(text, strlen(text), &first, NULL), SCREE_OK);
        char *printed = json_print(first, k % 2);
        assert_int_equal(read_bytes(printed, strlen(printed), &second, NULL), SCREE_OK);
        assert_memory_equal(&json_get(second, "a")->child->valuedouble, &value, sizeof value);
        assert_true(cJSON_IsNumber(json_get(first, "a")->child)); // the tree itself is left alone
        free(printed);
        cJSON_Delete(first);
        cJSON_Delete(second);
    }
}

/* People read specs: 0.3 is "0.3" and a count has no fraction. */
static void numbers_are_short(void **state)
{
    (void)state;
    const struct {
        double value;
        const char *text;
    } cases[] = {{0.3, "0.3"},        {0.1 + 0.2, "0.30000000000000004"},
                 {2.5e-7, "2.5e-07"}, {1000000, "1000000"},
                 {23.5, "23.5"},      {9007199254740992., "9007199254740992"},
                 {-3, "-3"},          {74e9, "74000000000"},
                 {-0.0, "-0"},        {NAN, "null"},
                 {INFINITY, "null"}};
    for (size_t k = 0; k < COUNT(cases); k++) {
        cJSON *number = json_real(cases[k].value);
        char *text = json_print(number, false);
        assert_string_equal(text, cases[k].text);
        free(text);
        cJSON_Delete(number);
    }
}

/* cJSON's plain look-up ignores case; ours must not, or "Seed" would be "seed" here and unknown there. */
static void look_ups_are_exact(void **state)
{
    (void)state;
    cJSON *object = cJSON_CreateObject();
    json_put_real(object, "Seed", 1);
    json_put_text(object, "word", "w");
    json_put_bool(object, "flag", true);
    assert_null(json_get(object, "seed"));
    assert_non_null(json_get(object, "Seed"));
    assert_string_equal(json_text(object, "word"), "w");
    assert_null(json_text(object, "Seed"));
    assert_true(json_bool(object, "flag", false));
    assert_true(json_bool(object, "word", true));
    assert_true(json_number(object, "word", 3) == 3);
    assert_null(json_get(NULL, "x"));
    cJSON_Delete(object);
}

/* A file that cannot be read is an I/O error that names it, not bad JSON. */
static void files_say_why(void **state)
{
    (void)state;
    struct scree_error err;
    cJSON *tree = NULL;
    assert_int_equal(json_read_file("no/such/file.json", &tree, &err), SCREE_IO);
    assert_string_equal(err.message, "cannot read no/such/file.json: No such file or directory");
    assert_int_equal(json_read_file(".", &tree, &err), SCREE_IO);
    assert_string_equal(err.message, "cannot read .: Is a directory");
    assert_null(tree);
    char path[] = "test-json-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0 && write(file, "{\n\"a\":\n  nope}", 14) == 14);
    close(file);
    assert_int_equal(json_read_file(path, &tree, &err), SCREE_INVALID);
    unlink(path);
    char expected[64];
    snprintf(expected, sizeof expected, "%s:3:3: a value is expected", path);
    assert_string_equal(err.message, expected);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_the_grammar),
        cmocka_unit_test(refuses_bad_grammar),
        cmocka_unit_test(refuses_bad_numbers),
        cmocka_unit_test(refuses_numbers_beyond_double),
        cmocka_unit_test(refuses_bad_strings),
        cmocka_unit_test(utf8_is_exact),
        cmocka_unit_test(refuses_duplicate_keys),
        cmocka_unit_test(refuses_deep_nesting),
        cmocka_unit_test(refuses_long_texts),
        cmocka_unit_test(refuses_every_prefix),
        cmocka_unit_test(numbers_read_are_printed_to_the_bit),
        cmocka_unit_test(numbers_are_short),
        cmocka_unit_test(look_ups_are_exact),
        cmocka_unit_test(files_say_why),
    };
    return cmocka_run_group_tests_name("json_corners", tests, NULL, NULL);
}
