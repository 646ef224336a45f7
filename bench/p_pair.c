/* Both ends of a slot in C, each called by a process of its own over memory that both have mapped: for the
   benchmark and for tests with the other end in Python. */
#define _GNU_SOURCE
#include <sched.h>
#include <string.h>
#include <time.h>
#include "p_parameters.h"

enum { SIZE = 128, ALGORITHM = 0x02000001, PARAMETERS = 9, DATA = 8 * PARAMETERS, LOOKS = 200 };
/* Offsets in the shared memory (memory.toml). */
enum { SMD = 0, MSD = 0x1000, MPF = 0x8000, SPF = 0x9000, MPA = 0x8400, SPA = 0x9400 };

static p_areas areas_of(uint8_t *shared) {
    p_areas a = { (void *)(shared + SMD), (void *)(shared + MSD), (void *)(shared + MPF),
                  (void *)(shared + SPF), (void *)(shared + MPA), (void *)(shared + SPA) };
    return a;
}

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000ll + t.tv_nsec;
}

/* Looks again and again, and lets others run in between. */
static void relax(uint32_t *looked) {
    if (++*looked % LOOKS == 0) sched_yield();
}

/* 72 bytes that tell every transfer from the others, as tests/protocol_pair.py makes them. */
static void payload(uint32_t number, uint32_t salt, uint8_t *data) {
    uint32_t first = number * 2654435761u + salt * 40503u;
    for (uint32_t pid = 1; pid <= PARAMETERS; pid++) {
        uint32_t pair[2] = { pid, first ^ pid * 0x9E3779B1u };
        memcpy(data + 8 * (pid - 1), pair, 8);
    }
}

static p_parameter parameters[PARAMETERS];
static p_algorithm algorithm = {
    .aid = ALGORITHM, .count = PARAMETERS, .parameters = parameters, .running = 1 };

static void described(void) {
    for (uint32_t n = 0; n < PARAMETERS; n++) {
        p_parameter p = { n + 1, P_U32, 0, 4294967295.0, 1e300 };
        parameters[n] = p;
    }
}

/* Sends `count` payloads to the slave or, `salt` 0, to the master; the time of each in `ns` unless it is 0.
   Returns how many were refused or lost. */
uint32_t p_sends(uint8_t *shared, uint32_t salt, uint32_t count, uint32_t *ns) {
    p_areas areas = areas_of(shared);
    p_channel channel;
    (salt ? p_to_slave : p_to_master)(&channel, &areas, 0, SIZE);
    p_sender sender = { .channel = &channel };
    uint8_t data[DATA];
    uint32_t bad = 0, looked = 0;
    for (uint32_t n = 0; n < count; n++) {
        payload(n, salt, data);
        int64_t start = ns ? now() : 0;
        int32_t done;
        while ((done = p_send(&sender, ALGORITHM, P_UPDATE, data, DATA, 1)) == P_BUSY)
            if (sender.step == 6) relax(&looked);
        if (ns) ns[n] = (uint32_t)(now() - start);
        if (done == P_DONE) continue;
        bad++;
        while (p_reset(&sender, 1) == P_BUSY) relax(&looked);
    }
    return bad;
}

/* Receives `count` payloads; how many were other than expected. */
uint32_t p_receives(uint8_t *shared, uint32_t salt, uint32_t count) {
    p_areas areas = areas_of(shared);
    p_channel channel;
    (salt ? p_to_slave : p_to_master)(&channel, &areas, 0, SIZE);
    static uint8_t frame[SIZE], taken[SIZE];
    p_receiver r = { .channel = &channel, .algorithms = &algorithm, .count = 1, .judge = p_judge,
                     .frame = frame, .data = taken };
    uint8_t wanted[DATA];
    uint32_t bad = 0, looked = 0;
    described();
    for (uint32_t n = 0; n < count;) {
        uint32_t before = r.step;
        if (p_receive(&r) == P_DONE) {
            payload(n++, salt, wanted);
            bad += r.envelope.len != DATA || memcmp(wanted, taken, DATA) != 0;
        } else if (r.step == before) relax(&looked);
    }
    return bad;
}

/* The yardstick: 92 bytes and a number there, the number back; `first`: this side begins. */
void p_copies(uint8_t *shared, uint32_t first, uint32_t count, uint32_t *ns) {
    volatile uint32_t *there = (void *)(shared + MPF), *back = (void *)(shared + SPF);
    uint8_t frame[P_HEAD + DATA] = { 1 };
    uint32_t looked = 0;
    for (uint32_t n = 1; n <= count; n++) {
        int64_t start = ns ? now() : 0;
        if (first) {
            memcpy(shared, frame, sizeof frame);
            __atomic_store_n(there, n, __ATOMIC_RELEASE);
        }
        while (__atomic_load_n(first ? back : there, __ATOMIC_ACQUIRE) != n) relax(&looked);
        if (!first) {
            memcpy(frame, shared, sizeof frame);
            __atomic_store_n(back, n, __ATOMIC_RELEASE);
        }
        if (ns) ns[n - 1] = (uint32_t)(now() - start);
    }
}
