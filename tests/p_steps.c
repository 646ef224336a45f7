/* The machines of p_handshake.c, one access to shared memory a call, for tests/test_protocol_c_model.py.

   A step of theirs makes several accesses. One that is stopped between two of them is begun anew and goes
   through what it did before: what it read is given to it again, what it wrote is not written again. So all that
   there is to know of it is its state at the begin of the step and what it has read since. */
#include <setjmp.h>
#include <string.h>
#include "p_handshake.h"

enum { T_ACCESSES = 32, T_INSIDE = -3 };

/* The accesses of the step in work: `values` are what was read, 0 of what was written. */
typedef struct {
    uint32_t count, values[T_ACCESSES];
} t_replay;

static jmp_buf stopped;
static t_replay *replay;
static uint32_t at, fresh;
static uint32_t retries = 2;

/* Whether the access is one that is made now; one further would be too much. */
static int is_new(void) {
    if (at < replay->count) return 0;
    if (fresh) longjmp(stopped, 1);
    return fresh = 1;
}

static uint32_t t_load(const volatile uint32_t *word) {
    if (is_new()) replay->values[replay->count++] = *word;
    return replay->values[at++];
}

static void t_store(volatile uint32_t *word, uint32_t value) {
    if (is_new()) {
        *word = value;
        replay->values[replay->count++] = 0;
    }
    at++;
}

#define P_LOAD(word, order) t_load(word)
#define P_STORE(word, value, order) t_store(word, value)
#define P_RETRIES retries
#include "p_handshake.c"

void t_retries(uint32_t most);
void t_retries(uint32_t most) { retries = most; }

enum { T_SEND, T_RESET, T_RECEIVE, T_SCRUB };

static int32_t called(uint32_t what, void *machine, uint32_t aid, const uint8_t *data, uint32_t len,
                      uint32_t elapsed) {
    switch (what) {
    case T_SEND: return p_send(machine, aid, P_UPDATE, data, len, elapsed);
    case T_RESET: return p_reset(machine, elapsed);
    case T_RECEIVE: return p_receive(machine);
    default: p_scrub(machine); return P_BUSY;
    }
}

/* The next access of a step, and what follows it up to the one behind it: what the step returns, or T_INSIDE.
   `state` is restored then: it is that of the begin of the step, of `size` bytes. */
int32_t t_step(uint32_t what, void *machine, uint8_t *state, uint32_t size, t_replay *done, uint32_t aid,
               const uint8_t *data, uint32_t len, uint32_t elapsed);
int32_t t_step(uint32_t what, void *machine, uint8_t *state, uint32_t size, t_replay *done, uint32_t aid,
               const uint8_t *data, uint32_t len, uint32_t elapsed) {
    static uint8_t before[1024];
    memcpy(before, state, size);
    replay = done;
    at = fresh = 0;
    if (setjmp(stopped)) {
        memcpy(state, before, size);
        return T_INSIDE;
    }
    int32_t result = called(what, machine, aid, data, len, elapsed);
    done->count = 0;
    return result;
}
