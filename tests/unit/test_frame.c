/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Envelopes, checksums, base64, endpoints. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "protocol/frame.h"

static void crc_is_castagnolis(void **state)
{
    (void)state;
    unsigned char data[4096];
    struct rng rng = rng_start(1, 1);
    assert_int_equal(crc32c(0, "123456789", 9), 0xe3069283u);
    assert_int_equal(crc32c_plain(0, "123456789", 9), 0xe3069283u);
    for (size_t k = 0; k < sizeof data; k++)
        data[k] = (unsigned char)rng_next(&rng);
    for (size_t size = 0; size < sizeof data; size += 37) // every tail length, and in two parts
        assert_int_equal(crc32c(crc32c(0, data, size / 3), data + size / 3, size - size / 3), crc32c_plain(0, data, size));
}

static void base64_goes_both_ways(void **state)
{
    (void)state;
    char text[64];
    unsigned char back[64];
    static const char *const known[][2] = {{"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}};
    for (size_t k = 0; k < 5; k++) {
        base64_encode(known[k][0], strlen(known[k][0]), text);
        assert_string_equal(text, known[k][1]);
        assert_int_equal(base64_decode(text, strlen(text), back), strlen(known[k][0]));
        assert_memory_equal(back, known[k][0], strlen(known[k][0]));
    }
    static const char *const bad[] = {"Zg=", "Zg", "Z===", "Zg==Zg==", "Z g=", "Zm9*"};
    for (size_t k = 0; k < 6; k++)
        assert_true(base64_decode(bad[k], strlen(bad[k]), back) == SIZE_MAX);
}

static void envelopes_are_checked(void **state)
{
    (void)state;
    struct envelope envelope;
    struct scree_error error;
    static const char good[] = "{\"id\":\"a.B-1_\",\"op\":\"ping\"}";
    assert_int_equal(envelope_read(good, strlen(good), &envelope, &error), SCREE_OK);
    assert_string_equal(envelope.id, "a.B-1_");
    assert_string_equal(envelope.op, "ping");
    static const char *const bad[] = {"{}",
                                      "{\"id\":\"\",\"op\":\"x\"}",
                                      "{\"id\":\"a b\",\"op\":\"x\"}",
                                      "{\"id\":\"a\"}",
                                      "[]",
                                      "null",
                                      "{\"id\":1,\"op\":\"x\"}",
                                      "{\"id\":\"a\",\"op\":\"0123456789012345678901234567890123456789\"}"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(envelope_read(bad[k], strlen(bad[k]), &envelope, &error), SCREE_INVALID);
    char id[PROTOCOL_ID_MAX + 2];
    memset(id, 'x', sizeof id);
    id[PROTOCOL_ID_MAX + 1] = 0;
    assert_false(protocol_id_valid(id));
    id[PROTOCOL_ID_MAX] = 0;
    assert_true(protocol_id_valid(id));
}

static void errors_come_back_as_they_went(void **state)
{
    (void)state;
    struct scree_error error, back;
    scree_fail(&error, SCREE_BUSY, "a.b", "no room for %d", 3);
    scree_hint(&error, "wait");
    cJSON *json = error_json(scree_status_word(error.status), &error);
    assert_int_equal(error_read(json, &back), SCREE_BUSY);
    assert_string_equal(back.path, "a.b");
    assert_string_equal(back.message, "no room for 3");
    assert_string_equal(back.hint, "wait");
    cJSON_Delete(json);
}

static void socket_paths_are_bounded(void **state)
{
    (void)state;
    char out[512], long_path[300];
    struct scree_error error;
    assert_int_equal(protocol_endpoint("/run/x", "control", out, sizeof out, &error), SCREE_OK);
    assert_string_equal(out, "ipc:///run/x/control");
    memset(long_path, 'd', sizeof long_path);
    long_path[0] = '/';
    long_path[110] = 0;
    assert_int_equal(protocol_endpoint(long_path, "control", out, sizeof out, &error), SCREE_INVALID);
}

static void runtime_directory_follows_the_environment(void **state)
{
    (void)state;
    char out[256];
    setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
    unsetenv("SCREE_RUNTIME");
    assert_int_equal(protocol_runtime_dir(out, sizeof out, NULL), SCREE_OK);
    assert_string_equal(out, "/run/user/7/scree");
    setenv("SCREE_RUNTIME", "/x/y", 1);
    assert_int_equal(protocol_runtime_dir(out, sizeof out, NULL), SCREE_OK);
    assert_string_equal(out, "/x/y");
    assert_int_equal(protocol_runtime_dir(out, 3, NULL), SCREE_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc_is_castagnolis),       cmocka_unit_test(base64_goes_both_ways),
        cmocka_unit_test(envelopes_are_checked),    cmocka_unit_test(errors_come_back_as_they_went),
        cmocka_unit_test(socket_paths_are_bounded), cmocka_unit_test(runtime_directory_follows_the_environment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
