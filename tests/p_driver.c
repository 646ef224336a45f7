/* Drives both sides of p_handshake.c: steps in a random order, or each side in a thread of its own. */
#include <pthread.h>
#include <string.h>
#include "p_handshake.h"

enum { SIZE = 148, COPIED = 5 };
static volatile uint32_t master[8], slave[8];
static volatile uint32_t words[SIZE / 4];
static volatile uint8_t *const slot = (volatile uint8_t *)words;
static uint8_t taken[SIZE], frame[SIZE];
static const p_channel channel = { master, master + 1, slave + 3, slave + 2, slave + 4, slave + 5, slave + 6,
                                   words, SIZE, 8 };
static uint64_t dice;

static uint32_t drawn(uint64_t *from, uint32_t below) {
    *from ^= *from << 13;
    *from ^= *from >> 7;
    *from ^= *from << 17;
    return (uint32_t)(*from >> 33) % below;
}

static uint32_t message(uint32_t number, uint8_t *data) {
    uint64_t own = number * 2654435761u + 1;
    uint32_t len = 4 + drawn(&own, (SIZE - 20) / 4) * 4;
    for (uint32_t i = 0; i < len; i++) data[i] = (uint8_t)drawn(&own, 256);
    return len;
}

static int same(const p_receiver *r, uint32_t number) {
    uint8_t wanted[SIZE];
    uint32_t len = message(number, wanted);
    return r->envelope.len == len && r->envelope.seq == number + 1 && !memcmp(wanted, r->data, len);
}

static void cleared(void) {
    for (int i = 0; i < 8; i++) master[i] = slave[i] = 0;
}

/* How many of `count` messages arrived wrong, twice, not at all, or were given up. `damage`: how often of
   1000 a byte in the slot (of the envelope, but not the length, or of the data) changes while data are on
   their way. */
uint32_t random_order(uint32_t count, uint64_t seed, uint32_t damage) {
    p_sender sender = { .channel = &channel };
    p_receiver receiver = { .channel = &channel, .count = 1, .frame = frame, .data = taken };
    uint32_t sent = 0, received = 0, wrong = 0;
    uint8_t data[SIZE];
    cleared();
    dice = seed;
    uint32_t len = message(0, data);
    while (sent < count) {
        if (drawn(&dice, 2)) {
            uint32_t before = sender.step;
            int32_t result = p_send(&sender, 0, P_UPDATE, data, len, 1);
            if (before == COPIED - 1 && drawn(&dice, 1000) < damage) slot[(drawn(&dice, 20) + 16) % 28] ^= 1;
            if (result == P_BUSY) continue;
            if (result != P_DONE) return wrong + count - sent; /* given up */
            len = message(++sent, data);
        } else if (p_receive(&receiver) == P_DONE) {
            wrong += !same(&receiver, received++);
        }
    }
    for (int i = 0; i < 8; i++) received += p_receive(&receiver) == P_DONE;
    for (int i = 0; i < 5; i++) wrong += (master[i] | slave[i]) != 0;
    return wrong + (received != count);
}

static uint32_t wanted, wrong_in_thread;

static void *receiving(void *unused) {
    p_receiver receiver = { .channel = &channel, .count = 1, .frame = frame, .data = taken };
    for (uint32_t n = 0; n < wanted;)
        if (p_receive(&receiver) == P_DONE) wrong_in_thread += !same(&receiver, n++);
    return unused;
}

uint32_t two_threads(uint32_t count) {
    p_sender sender = { .channel = &channel };
    uint8_t data[SIZE];
    pthread_t thread;
    cleared();
    wanted = count;
    wrong_in_thread = 0;
    if (pthread_create(&thread, 0, receiving, 0)) return UINT32_MAX;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t len = message(n, data);
        while (p_send(&sender, 0, P_UPDATE, data, len, 1) == P_BUSY) { }
    }
    pthread_join(thread, 0);
    return wrong_in_thread;
}

/* The code of one refused message; `kind`: 1 length, 2 checksum, 3 number, 4 algorithm, 8 command, 10 no answer,
   11 a flag that stays. */
int32_t refused(uint32_t kind) {
    p_sender sender = { .channel = &channel, .patience = 50 };
    p_receiver receiver = { .channel = &channel, .count = 1, .frame = frame, .data = taken };
    uint8_t data[SIZE];
    cleared();
    if (kind == P_SEQ) sender.seq = 7;
    if (kind == P_STUCK) slave[2] = channel.mask;
    for (int32_t result = P_BUSY; ;) {
        result = p_send(&sender, kind == P_AID, kind == P_STATE ? 5 : P_UPDATE, data, kind == P_LEN ? 6 : 8, 1);
        if (kind == P_CRC && sender.step == COPIED) slot[22] ^= 1;
        if (result != P_BUSY) return result;
        if (kind < P_SILENT) p_receive(&receiver);
    }
}
