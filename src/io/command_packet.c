#include "command_packet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    VERSION_AT = 4,
    KIND_AT = 6,
    FLAG_AT = 7,
    ID_AT = 8,
    LEASE_AT = 12,
    TEXT_AT = 16,
    ANY_VERSION_SIZE = 12,
    DIGEST_AT = 16,
    FROM_AT = DIGEST_AT + 8,
    TO_AT = FROM_AT + 8 * LOOP_GAINS
};
static const char request_magic[] = "HEXC", answer_magic[] = "HEXA";
static const double longest_lease_s = 3600.0;

static void put(unsigned char *at, int bytes, uint32_t value) {
    for (int i = 0; i < bytes; i++) at[i] = (unsigned char)(value >> 8 * (bytes - 1 - i));
}

static uint32_t take(const unsigned char *at, int bytes) {
    uint32_t value = 0;
    for (int i = 0; i < bytes; i++) value = value << 8 | at[i];
    return value;
}

static void put_gains(unsigned char *at, const struct gains *gains) {
    for (int i = 0; i < LOOP_GAINS; i++) {
        uint64_t bits;
        memcpy(&bits, &gains->value[i], sizeof bits);
        put(at + 8 * i, 4, (uint32_t)(bits >> 32)), put(at + 8 * i + 4, 4, (uint32_t)bits);
    }
}

static uint64_t take_word(const unsigned char *at) { return (uint64_t)take(at, 4) << 32 | take(at + 4, 4); }

static void take_gains(const unsigned char *at, struct gains *gains) {
    for (int i = 0; i < LOOP_GAINS; i++) {
        uint64_t bits = take_word(at + 8 * i);
        memcpy(&gains->value[i], &bits, sizeof bits);
    }
}

size_t command_request_encode(const struct command_request *r, unsigned char packet[COMMAND_SET_SIZE]) {
    memset(packet, 0, COMMAND_SET_SIZE);
    memcpy(packet, request_magic, sizeof request_magic - 1);
    put(packet + VERSION_AT, 2, COMMAND_VERSION);
    put(packet + KIND_AT, 1, r->command);
    put(packet + FLAG_AT, 1, r->renew);
    put(packet + ID_AT, 4, r->id);
    if (!r->sets) return COMMAND_REQUEST_SIZE;
    put(packet + DIGEST_AT, 4, (uint32_t)(r->change.digest >> 32)), put(packet + DIGEST_AT + 4, 4, (uint32_t)r->change.digest);
    put_gains(packet + FROM_AT, &r->change.from);
    put_gains(packet + TO_AT, &r->change.to);
    return COMMAND_SET_SIZE;
}

bool command_request_decode(const unsigned char *packet, size_t size, struct command_request *request) {
    if (size < ANY_VERSION_SIZE || memcmp(packet, request_magic, sizeof request_magic - 1) != 0) return false;
    uint32_t command = take(packet + KIND_AT, 1), flag = take(packet + FLAG_AT, 1);
    struct command_request r = {.id = take(packet + ID_AT, 4), .command = (enum command)command, .renew = flag == 1};
    bool stops = flag == 0 && (command == COMMAND_STOP || command == COMMAND_PARK);
    bool sets = size == COMMAND_SET_SIZE && command == COMMAND_SET;
    bool same = (size == COMMAND_REQUEST_SIZE || sets) && take(packet + VERSION_AT, 2) == COMMAND_VERSION;
    bool known = flag == 0 ? command > COMMAND_NONE && command < COMMANDS : flag == 1 && command == COMMAND_NONE;
    if (!stops && !(same && known)) return false;
    r.sets = sets;
    if (sets) {
        r.change.digest = take_word(packet + DIGEST_AT);
        take_gains(packet + FROM_AT, &r.change.from), take_gains(packet + TO_AT, &r.change.to);
    }
    *request = r;
    return true;
}

void command_answer_encode(const struct command_answer *a, unsigned char packet[COMMAND_ANSWER_SIZE]) {
    memset(packet, 0, COMMAND_ANSWER_SIZE);
    memcpy(packet, answer_magic, sizeof answer_magic - 1);
    put(packet + VERSION_AT, 2, COMMAND_VERSION);
    put(packet + KIND_AT, 1, a->outcome);
    put(packet + FLAG_AT, 1, a->state);
    put(packet + ID_AT, 4, a->id);
    put(packet + LEASE_AT, 4, (uint32_t)lround(a->lease_s * 1e3));
    snprintf((char *)packet + TEXT_AT, COMMAND_TEXT_SIZE, "%.*s", COMMAND_TEXT_SIZE - 1, a->text);
}

bool command_answer_decode(const unsigned char *packet, size_t size, struct command_answer *answer) {
    if (size != COMMAND_ANSWER_SIZE || memcmp(packet, answer_magic, sizeof answer_magic - 1) != 0) return false;
    struct command_answer a = {.id = take(packet + ID_AT, 4), .lease_s = take(packet + LEASE_AT, 4) * 1e-3};
    uint32_t outcome = take(packet + KIND_AT, 1), state = take(packet + FLAG_AT, 1);
    bool ended = memchr(packet + TEXT_AT, '\0', COMMAND_TEXT_SIZE) != NULL;
    if (take(packet + VERSION_AT, 2) != COMMAND_VERSION || outcome >= OUTCOMES || state >= STATES || !ended || a.lease_s > longest_lease_s)
        return false;
    a.outcome = (enum outcome)outcome;
    a.state = (enum state)state;
    memcpy(a.text, packet + TEXT_AT, COMMAND_TEXT_SIZE);
    *answer = a;
    return true;
}
