/* SPDX-License-Identifier: GPL-3.0-or-later */
/* envelope_read and the other readers of small messages: ids that are let through
 * are safe as names; errors and base64 from a peer cannot do harm. */
#include "check.h"
#include "protocol/frame.h"

static void read_base64(const uint8_t *data, size_t size)
{
    char *out = malloc(size + 1), *text = malloc(size + 1);
    CHECK(out && text);
    size_t bytes = base64_decode((const char *)data, size, out);
    if (bytes != SIZE_MAX) { // then it is the one text for these bytes
        CHECK(bytes <= size);
        CHECK(base64_encode(out, bytes, text) == size);
        CHECK(memcmp(text, data, size) == 0);
    }
    free(out);
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct scree_error err = {0}, peer = {0};
    struct envelope envelope;
    cJSON *tree = NULL;
    if (envelope_read((const char *)data, size, &envelope, &err))
        check_refusal(&err);
    else
        CHECK(protocol_id_valid(envelope.id) && strlen(envelope.op) < sizeof envelope.op);
    CHECK(envelope.id[0] == 0 || protocol_id_valid(envelope.id));
    if (!json_read((const char *)data, size, "fuzz", &tree, NULL)) {
        CHECK(error_read(tree, &peer) != SCREE_OK);
        check_text(peer.message);
        check_text(peer.path);
        check_text(peer.hint);
    }
    cJSON_Delete(tree);
    read_base64(data, size);
    CHECK(crc32c(0, data, size) == crc32c_plain(0, data, size));
    return 0;
}
