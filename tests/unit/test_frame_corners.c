/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Corners of what goes into the frames: whole messages of refused headers, every
 * error code there and back, checksums and base64 against published vectors. */
#include "unit.h"

#include <stdio.h>

#include "base/rng.h"
#include "protocol/frame.h"

/* Ids become file names, keys of a database and parts of topics. */
static void ids_are_plain(void **state)
{
    (void)state;
    char longest[PROTOCOL_ID_MAX + 2];
    memset(longest, 'a', sizeof longest);
    longest[PROTOCOL_ID_MAX] = 0;
    assert_true(protocol_id_valid("A"));
    assert_true(protocol_id_valid("aZ09._-"));
    assert_true(protocol_id_valid(longest));
    longest[PROTOCOL_ID_MAX] = 'a';
    longest[PROTOCOL_ID_MAX + 1] = 0;
    assert_false(protocol_id_valid(longest));
    assert_false(protocol_id_valid(""));
    assert_false(protocol_id_valid(NULL));
    assert_false(protocol_id_valid("a/b"));
    assert_false(protocol_id_valid("a b"));
    assert_false(protocol_id_valid("\xc3\xa9"));
}

static enum scree_status header(const char *text, struct envelope *out, struct scree_error *err)
{
    return envelope_read(text, strlen(text), out, err);
}

/* Bad headers are told apart; an id that could be read is kept, so that the answer finds its question. */
static void envelopes_are_checked(void **state)
{
    (void)state;
    const char *bad_id = "id: 1 to 64 characters of [A-Za-z0-9._-] are expected";
    const char *bad_op = "op: the name of an operation is expected";
    const struct {
        const char *text, *path, *message, *id;
    } cases[] = {
        {"{\"id\":\"x\"}", "op", bad_op, "x"},
        {"{\"id\":\"x\",\"op\":3}", "op", bad_op, "x"},
        {"{\"id\":\"x\",\"op\":\"12345678901234567890123456789012\"}", "op", bad_op, "x"},
        {"{\"op\":\"ping\"}", "id", bad_id, ""},
        {"{\"id\":\"\",\"op\":\"ping\"}", "id", bad_id, ""},
        {"{\"id\":\"a b\",\"op\":\"ping\"}", "id", bad_id, ""},
        {"{\"id\":7,\"op\":\"ping\"}", "id", bad_id, ""},
        {"{\"ID\":\"x\",\"op\":\"ping\"}", "id", bad_id, ""},
        {"[\"id\",\"op\"]", "id", bad_id, ""},
        {"null", "id", bad_id, ""},
        {"{\"id\":\"x\",\"id\":\"y\",\"op\":\"ping\"}", "id", "id: the key \"id\" stands twice", ""},
        {"{\"id\":\"x\"", "", "header:1:10: \",\" or \"}\" is expected", ""},
        {"", "", "header:1:1: a value is missing at the end", ""},
    };
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct envelope envelope;
        struct scree_error err = {0};
        assert_int_equal(header(cases[k].text, &envelope, &err), SCREE_INVALID);
        assert_error(&err, SCREE_INVALID, cases[k].path, cases[k].message);
        assert_string_equal(envelope.id, cases[k].id);
        assert_string_equal(envelope.op, "");
    }
}

/* A client shows the daemon's words: nothing may be lost or changed on the way. */
static void errors_round_trip(void **state)
{
    (void)state;
    for (int status = SCREE_INVALID; status <= SCREE_INTERNAL; status++) {
        struct scree_error sent, got = {0};
        scree_fail(&sent, (enum scree_status)status, "params.nx", "\"quoted\" \\ 100%% %s", "\xc3\xa9");
        scree_hint(&sent, "a hint");
        cJSON *reply = reply_error("r1", scree_status_word(sent.status), &sent), *back = NULL;
        char *text = json_print(reply, false);
        assert_int_equal(json_read(text, strlen(text), "reply", &back, NULL), SCREE_OK);
        assert_false(json_bool(back, "ok", true));
        assert_string_equal(json_text(back, "id"), "r1");
        assert_int_equal(error_read(json_get(back, "error"), &got), status);
        assert_error(&got, sent.status, sent.path, sent.message);
        assert_string_equal(got.hint, "a hint");
        free(text);
        cJSON_Delete(reply);
        cJSON_Delete(back);
    }
}

/* The wire has codes that are no status of ours, and a later daemon may have more. */
static void foreign_error_codes_are_read(void **state)
{
    (void)state;
    const struct {
        const char *code;
        enum scree_status status;
    } cases[] = {
        {"bad_request", SCREE_INVALID}, {"conflict", SCREE_CONFLICT}, {"from_the_future", SCREE_INTERNAL}, {"ok", SCREE_INTERNAL}};
    for (size_t k = 0; k < COUNT(cases); k++) {
        struct scree_error sent, got;
        scree_fail(&sent, SCREE_INVALID, NULL, "m");
        cJSON *json = error_json(cases[k].code, &sent);
        assert_int_equal(error_read(json, &got), cases[k].status);
        assert_string_equal(got.message, "m");
        cJSON_Delete(json);
    }
    struct scree_error got;
    assert_int_equal(error_read(NULL, &got), SCREE_INTERNAL);
    assert_string_equal(got.message, "the daemon gave no reason");
}

/* An operation without a result still answers with an object. */
static void replies_have_a_result(void **state)
{
    (void)state;
    cJSON *reply = reply_ok("r2", NULL);
    char *text = json_print(reply, false);
    assert_string_equal(text, "{\"id\":\"r2\",\"ok\":true,\"result\":{}}");
    free(text);
    cJSON_Delete(reply);
}

/* Vectors of RFC 3720, B.4, and the customary one: readers in other languages must agree. */
static void crc_matches_published_vectors(void **state)
{
    (void)state;
    unsigned char zeros[32] = {0}, ones[32], rising[32], falling[32];
    for (unsigned k = 0; k < 32; k++) {
        ones[k] = 0xff;
        rising[k] = (unsigned char)k;
        falling[k] = (unsigned char)(31 - k);
    }
    uint32_t (*const both[])(uint32_t, const void *, size_t) = {crc32c, crc32c_plain};
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(both[k](0, "123456789", 9), 0xe3069283u);
        assert_int_equal(both[k](0, zeros, 32), 0x8a9136aau);
        assert_int_equal(both[k](0, ones, 32), 0x62a8ab43u);
        assert_int_equal(both[k](0, rising, 32), 0x46dd794eu);
        assert_int_equal(both[k](0, falling, 32), 0x113fdb5cu);
        assert_int_equal(both[k](0, "", 0), 0);
    }
}

/* Both ways to compute it agree at every length and alignment, in one piece or two. */
static void crc_is_the_same_both_ways(void **state)
{
    (void)state;
    unsigned char data[300];
    struct rng rng = rng_start(3, 1);
    for (size_t k = 0; k < sizeof data; k++)
        data[k] = (unsigned char)rng_next(&rng);
    for (size_t start = 0; start < 9; start++)
        for (size_t size = 0; size + start <= sizeof data; size++) {
            uint32_t whole = crc32c(0, data + start, size);
            size_t cut = size ? rng_next(&rng) % size : 0;
            assert_int_equal(whole, crc32c_plain(0, data + start, size));
            assert_int_equal(whole, crc32c(crc32c(0, data + start, cut), data + start + cut, size - cut));
        }
    uint32_t before = crc32c(0, data, sizeof data);
    data[123] ^= 0x10;
    assert_int_not_equal(before, crc32c(0, data, sizeof data));
}

/* Vectors of RFC 4648, section 10. */
static void base64_matches_published_vectors(void **state)
{
    (void)state;
    const char *plain = "foobar";
    const char *const coded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
    for (size_t size = 0; size <= 6; size++) {
        char text[16], back[16];
        assert_int_equal(base64_encode(plain, size, text), strlen(coded[size]));
        assert_string_equal(text, coded[size]);
        assert_int_equal(base64_decode(text, strlen(text), back), size);
        assert_memory_equal(back, plain, size);
    }
}

/* Pieces of a result file come back unchanged, whatever their bytes and length. */
static void base64_round_trips(void **state)
{
    (void)state;
    unsigned char data[400], back[400];
    char text[4 * ((sizeof data + 2) / 3) + 1];
    struct rng rng = rng_start(11, 1);
    for (int k = 0; k < 2000; k++) {
        size_t size = rng_next(&rng) % sizeof data;
        for (size_t b = 0; b < size; b++)
            data[b] = (unsigned char)rng_next(&rng);
        size_t length = base64_encode(data, size, text);
        assert_int_equal(length, 4 * ((size + 2) / 3));
        assert_int_equal(base64_decode(text, length, back), size);
        assert_memory_equal(back, data, size);
    }
}

/* A damaged piece is noticed where the alphabet can tell. */
static void base64_refuses_what_it_never_writes(void **state)
{
    (void)state;
    const char *const bad[] = {
        "Z", "Zg", "Zg=", "Z===", "====", "Zg==Zg==", "Zm9v=", "Zm 9", "Zm9v\n", "Zm9-", "Z=9v", "Zg=v", "Zh==", "Zm9="};
    for (size_t k = 0; k < COUNT(bad); k++) {
        char out[16];
        if (base64_decode(bad[k], strlen(bad[k]), out) != SIZE_MAX)
            fail_msg("accepted: %s", bad[k]);
    }
    char out[16];
    assert_true(base64_decode("Zm\0v", 4, out) == SIZE_MAX);
}

/* The order in which a runtime directory is looked for is a promise of the protocol. */
static void runtime_directory_follows_the_environment(void **state)
{
    (void)state;
    char out[64], small[8];
    struct scree_error err;
    setenv("SCREE_RUNTIME", "/run/own", 1);
    setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
    assert_int_equal(protocol_runtime_dir(out, sizeof out, &err), SCREE_OK);
    assert_string_equal(out, "/run/own");
    setenv("SCREE_RUNTIME", "", 1);
    assert_int_equal(protocol_runtime_dir(out, sizeof out, &err), SCREE_OK);
    assert_string_equal(out, "/run/user/7/scree");
    assert_int_equal(protocol_runtime_dir(small, sizeof small, &err), SCREE_INVALID);
    unsetenv("XDG_RUNTIME_DIR");
    assert_int_equal(protocol_runtime_dir(out, sizeof out, &err), SCREE_OK);
    assert_int_equal(strncmp(out, "/tmp/scree-", 11), 0);
}

/* A Unix socket's path holds 107 characters; the kernel's own message would not say so. */
static void endpoints_fit_a_socket(void **state)
{
    (void)state;
    char directory[128], out[256];
    struct scree_error err;
    assert_int_equal(protocol_endpoint("/run/scree", "control", out, sizeof out, &err), SCREE_OK);
    assert_string_equal(out, "ipc:///run/scree/control");
    memset(directory, 'd', sizeof directory);
    directory[107 - strlen("/control")] = 0;
    assert_int_equal(protocol_endpoint(directory, "control", out, sizeof out, &err), SCREE_OK);
    directory[107 - strlen("/control")] = 'd';
    directory[108 - strlen("/control")] = 0;
    assert_int_equal(protocol_endpoint(directory, "control", out, sizeof out, &err), SCREE_INVALID);
    assert_non_null(strstr(err.message, "is too long for a socket (107 characters)"));
    assert_int_equal(protocol_endpoint("/run/scree", "control", out, 10, &err), SCREE_INVALID);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ids_are_plain),
        cmocka_unit_test(envelopes_are_checked),
        cmocka_unit_test(errors_round_trip),
        cmocka_unit_test(foreign_error_codes_are_read),
        cmocka_unit_test(replies_have_a_result),
        cmocka_unit_test(crc_matches_published_vectors),
        cmocka_unit_test(crc_is_the_same_both_ways),
        cmocka_unit_test(base64_matches_published_vectors),
        cmocka_unit_test(base64_round_trips),
        cmocka_unit_test(base64_refuses_what_it_never_writes),
        cmocka_unit_test(runtime_directory_follows_the_environment),
        cmocka_unit_test(endpoints_fit_a_socket),
    };
    return cmocka_run_group_tests_name("frame_corners", tests, NULL, NULL);
}
