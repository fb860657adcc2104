/* Modbus requests in a stream: whole, in parts, several at once, and invalid ones. The bytes are
 * from the standard's examples. */
#include "support.h"

#include <string.h>

#include "modbus_adu.h"

/* The frames on TCP: transaction, protocol 0, length, unit 1; then the PDU. */
static const uint8_t read_three[] = {0x15, 0x01, 0, 0, 0, 6, 1, 3, 0x00, 0x6b, 0x00, 0x03};
static const uint8_t write_two[] = {0x15, 0x02, 0, 0, 0, 11, 1, 16, 0x00, 0x01, 0x00, 0x02, 4, 0x00, 0x0a, 0x01, 0x02};
static const uint8_t exchange[] = {0, 1, 0, 0, 0, 17, 1, 23, 0, 3, 0, 6, 0, 14, 0, 3, 6, 0, 255, 0, 255, 0, 255};

static void a_whole_request_is_taken_apart(void **unused) {
    (void)unused;
    struct adu a;
    assert_int_equal(adu_take_tcp(read_three, sizeof read_three, &a), ADU_REQUEST);
    assert_int_equal(a.transaction, 0x1501);
    assert_int_equal(a.unit, 1);
    assert_int_equal(a.pdu_size, 5);
    assert_ptr_equal(a.pdu, read_three + 7);
    assert_int_equal(a.used, sizeof read_three);
    assert_int_equal(adu_take_tcp(exchange, sizeof exchange, &a), ADU_REQUEST);
}

/* A client sends byte by byte: nothing is accepted before the last byte, and then the request
 * exactly once. */
static void part_of_a_request_waits_for_the_rest(void **unused) {
    (void)unused;
    struct adu a;
    for (size_t size = 0; size < sizeof exchange; size++) {
        uint8_t part[sizeof exchange]; /* exact size, so that a sanitizer sees an overrun */
        memcpy(part, exchange, size);
        assert_int_equal(adu_take_tcp(part, size, &a), ADU_MORE);
    }
}

static void requests_behind_each_other_are_taken_one_by_one(void **unused) {
    (void)unused;
    uint8_t stream[sizeof read_three + sizeof write_two + sizeof exchange];
    struct adu a;
    memcpy(stream, read_three, sizeof read_three);
    memcpy(stream + sizeof read_three, write_two, sizeof write_two);
    memcpy(stream + sizeof read_three + sizeof write_two, exchange, sizeof exchange);
    static const int functions[] = {3, 16, 23};
    size_t at = 0;
    for (int i = 0; i < 3; i++, at += a.used) {
        assert_int_equal(adu_take_tcp(stream + at, sizeof stream - at, &a), ADU_REQUEST);
        assert_int_equal(a.pdu[0], functions[i]);
    }
    assert_int_equal(at, sizeof stream);
}

static void another_protocol_is_discarded_and_what_follows_is_taken(void **unused) {
    (void)unused;
    uint8_t stream[2 * sizeof read_three];
    struct adu a;
    memcpy(stream, read_three, sizeof read_three);
    memcpy(stream + sizeof read_three, read_three, sizeof read_three);
    for (int at = 2; at <= 3; at++) {
        stream[at] = 1;
        assert_int_equal(adu_take_tcp(stream, sizeof stream, &a), ADU_DISCARD);
        assert_int_equal(a.used, sizeof read_three);
        assert_int_equal(adu_take_tcp(stream + a.used, sizeof stream - a.used, &a), ADU_REQUEST);
        stream[at] = 0;
    }
}

/* Unit and function take 2 bytes, the longest PDU with the unit 254; other lengths cannot be
 * right. */
static void a_length_that_cannot_be_breaks_the_stream(void **unused) {
    (void)unused;
    for (unsigned length = 0; length < 65536; length++) {
        uint8_t bytes[ADU_MAX] = {0, 1, 0, 0, (uint8_t)(length >> 8), (uint8_t)length, 1, 0x41};
        struct adu a;
        enum adu_result expected = length < 2 || length > 254 ? ADU_BROKEN : ADU_REQUEST;
        assert_int_equal(adu_take_tcp(bytes, sizeof bytes, &a), expected);
        if (expected == ADU_REQUEST) assert_int_equal(a.used, 6 + length);
    }
}

/* The header states more or fewer bytes than the function's request has. */
static void a_length_that_is_not_the_functions_is_discarded(void **unused) {
    (void)unused;
    static const struct {
        const uint8_t *request;
        size_t size;
    } good[] = {{read_three, sizeof read_three}, {write_two, sizeof write_two}, {exchange, sizeof exchange}};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        for (size_t length = 2; length <= 254; length++) {
            uint8_t bytes[ADU_MAX] = {0};
            struct adu a;
            memcpy(bytes, good[i].request, good[i].size);
            bytes[5] = (uint8_t)length;
            assert_int_equal(adu_take_tcp(bytes, sizeof bytes, &a), length == good[i].size - 6 ? ADU_REQUEST : ADU_DISCARD);
            assert_int_equal(a.used, 6 + length);
        }
}

/* The framing accepts a wrong byte count, and the server answers it with exception 3. */
static void a_byte_count_that_is_not_the_quantitys_is_a_request(void **unused) {
    (void)unused;
    uint8_t bytes[sizeof exchange];
    struct adu a;
    memcpy(bytes, exchange, sizeof exchange);
    for (int count = 0; count < 256; count++) {
        bytes[16] = (uint8_t)count;
        assert_int_equal(adu_take_tcp(bytes, sizeof bytes, &a), ADU_REQUEST);
    }
}

static void no_full_buffer_waits_for_more(void **unused) {
    (void)unused;
    uint8_t bytes[ADU_MAX];
    uint64_t state = 5;
    struct adu a;
    for (int n = 0; n < 100000; n++) {
        for (int i = 0; i < ADU_MAX; i++) bytes[i] = (uint8_t)random_below(&state, n % 2 ? 256 : 3);
        enum adu_result tcp = adu_take_tcp(bytes, ADU_MAX, &a);
        assert_int_not_equal(tcp, ADU_MORE);
        if (tcp != ADU_BROKEN) assert_true(a.used >= 8 && a.used <= ADU_MAX);
        assert_int_not_equal(adu_take_rtu(bytes, ADU_MAX, false, &a), ADU_MORE);
        assert_true(a.used >= 4 && a.used <= ADU_MAX);
    }
}

/* The checksums come from other programs: 01 03 00 00 00 0A C5 CD is in most manuals. */
static const uint8_t rtu_read[] = {1, 3, 0, 0, 0, 10, 0xc5, 0xcd};

static void a_serial_request_is_taken_when_its_function_has_all_its_bytes(void **unused) {
    (void)unused;
    struct adu a;
    for (size_t size = 1; size < sizeof rtu_read; size++) assert_int_equal(adu_take_rtu(rtu_read, size, false, &a), ADU_MORE);
    assert_int_equal(adu_take_rtu(rtu_read, sizeof rtu_read, false, &a), ADU_REQUEST);
    assert_int_equal(a.unit, 1);
    assert_int_equal(a.pdu_size, 5);
    assert_int_equal(a.used, sizeof rtu_read);
}

static void a_serial_request_cut_short_is_discarded_when_the_line_is_silent(void **unused) {
    (void)unused;
    struct adu a;
    for (size_t size = 1; size < sizeof rtu_read; size++) {
        assert_int_equal(adu_take_rtu(rtu_read, size, true, &a), ADU_DISCARD);
        assert_int_equal(a.used, size);
    }
}

static void a_wrong_checksum_is_waited_out_and_discarded(void **unused) {
    (void)unused;
    for (size_t bit = 0; bit < 8 * sizeof rtu_read; bit++) {
        uint8_t bytes[sizeof rtu_read];
        struct adu a;
        memcpy(bytes, rtu_read, sizeof bytes);
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_int_equal(adu_take_rtu(bytes, sizeof bytes, false, &a), ADU_MORE);
        assert_int_equal(adu_take_rtu(bytes, sizeof bytes, true, &a), ADU_DISCARD);
        assert_int_equal(a.used, sizeof bytes);
    }
}

/* The length of such a request is unknown, so it ends with the silence. */
static void a_serial_request_with_an_unknown_function_is_taken_in_the_silence(void **unused) {
    (void)unused;
    static const uint8_t pdu[] = {0x41, 1, 2, 3};
    uint8_t bytes[ADU_MAX];
    struct adu a = {.unit = 9};
    size_t size = adu_put_rtu(&a, pdu, sizeof pdu, bytes);
    assert_int_equal(adu_take_rtu(bytes, size, false, &a), ADU_MORE);
    assert_int_equal(adu_take_rtu(bytes, size, true, &a), ADU_REQUEST);
    assert_int_equal(a.unit, 9);
    assert_int_equal(a.pdu_size, sizeof pdu);
    assert_memory_equal(a.pdu, pdu, sizeof pdu);
}

/* The junk is of lengths and kinds found on shared lines. It must not swallow the following
 * request, nor require a silence. */
static void a_request_behind_junk_is_found_without_a_silence(void **unused) {
    (void)unused;
    static const struct {
        size_t size;
        uint8_t bytes[64];
    } junk[] = {
        {1, {0x00}},
        {1, {0xff}},
        {3, {0x00, 0xff, 0x00}},
        {7, {2, 3, 2, 0xbe, 0xef, 0xfd, 0xa8}},        /* another device's answer */
        {8, {2, 3, 0, 0, 0, 10, 0xc5, 0xcd}},          /* a request with a wrong checksum */
        {7, {1, 3, 2, 0x48, 0x45, 0x4f, 0xb7}},        /* our own answer, echoed */
        {5, {1, 3, 0, 0, 0}},                          /* half a request */
    };
    for (size_t k = 0; k < sizeof junk / sizeof *junk; k++) {
        uint8_t bytes[ADU_MAX];
        size_t size = junk[k].size;
        struct adu a;
        memcpy(bytes, junk[k].bytes, size);
        /* nothing is discarded too early */
        assert_int_equal(adu_take_rtu(bytes, size, false, &a), ADU_MORE);
        memcpy(bytes + size, rtu_read, sizeof rtu_read);
        size += sizeof rtu_read;
        for (enum adu_result r; (r = adu_take_rtu(bytes, size, false, &a)) != ADU_REQUEST;) {
            if (r != ADU_DISCARD) fail_msg("junk %zu: no request found", k);
            size -= a.used;
            memmove(bytes, bytes + a.used, size);
        }
        assert_int_equal(a.unit, 1);
        assert_int_equal(a.used, sizeof rtu_read);
        assert_int_equal(size, sizeof rtu_read);
    }
}

/* Bytes inside an incomplete request belong to it, even if they look like a request. */
static void a_request_that_grows_is_not_cut_by_what_it_carries(void **unused) {
    (void)unused;
    uint8_t pdu[ADU_PDU_MAX] = {16, 0, 0x15, 0, 6, 12}, bytes[ADU_MAX];
    struct adu a = {.unit = 1};
    memcpy(pdu + 6, rtu_read, sizeof rtu_read);
    size_t whole = adu_put_rtu(&a, pdu, 18, bytes);
    for (size_t size = 1; size < whole; size++) assert_int_equal(adu_take_rtu(bytes, size, false, &a), ADU_MORE);
    assert_int_equal(adu_take_rtu(bytes, whole, false, &a), ADU_REQUEST);
    assert_int_equal(a.used, whole);
}

static void answers_are_framed_as_their_requests(void **unused) {
    (void)unused;
    static const uint8_t pdu[] = {3, 2, 0x12, 0x34}, expected[] = {0x15, 0x01, 0, 0, 0, 5, 1, 3, 2, 0x12, 0x34};
    uint8_t bytes[ADU_MAX];
    struct adu a;
    adu_take_tcp(read_three, sizeof read_three, &a);
    assert_int_equal(adu_put_tcp(&a, pdu, sizeof pdu, bytes), sizeof expected);
    assert_memory_equal(bytes, expected, sizeof expected);
    adu_take_rtu(rtu_read, sizeof rtu_read, false, &a);
    assert_int_equal(adu_put_rtu(&a, rtu_read + 1, 5, bytes), sizeof rtu_read);
    assert_memory_equal(bytes, rtu_read, sizeof rtu_read);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_whole_request_is_taken_apart),
        cmocka_unit_test(part_of_a_request_waits_for_the_rest),
        cmocka_unit_test(requests_behind_each_other_are_taken_one_by_one),
        cmocka_unit_test(another_protocol_is_discarded_and_what_follows_is_taken),
        cmocka_unit_test(a_length_that_cannot_be_breaks_the_stream),
        cmocka_unit_test(a_length_that_is_not_the_functions_is_discarded),
        cmocka_unit_test(a_byte_count_that_is_not_the_quantitys_is_a_request),
        cmocka_unit_test(no_full_buffer_waits_for_more),
        cmocka_unit_test(a_serial_request_is_taken_when_its_function_has_all_its_bytes),
        cmocka_unit_test(a_serial_request_cut_short_is_discarded_when_the_line_is_silent),
        cmocka_unit_test(a_wrong_checksum_is_waited_out_and_discarded),
        cmocka_unit_test(a_serial_request_with_an_unknown_function_is_taken_in_the_silence),
        cmocka_unit_test(a_request_behind_junk_is_found_without_a_silence),
        cmocka_unit_test(a_request_that_grows_is_not_cut_by_what_it_carries),
        cmocka_unit_test(answers_are_framed_as_their_requests),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
