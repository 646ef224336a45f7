/* A call is two transfers: time, inputs, outputs and state to the slave; number of the call, outputs and
   state back. The state of a component stays with its instance in the master, so that the slave may be
   started anew at any moment. */
#include "link.h"
#include "board.h"

#define MASTER ((volatile uint32_t *)LDC_MPF)
#define SLAVE ((volatile uint32_t *)LDC_SPF)
#define SYSTICK ((volatile uint32_t *)0xE000E010u)

static const p_channel to_slave = { MASTER + 0, MASTER + 1, SLAVE + 2, SLAVE + 3, SLAVE + 4, SLAVE + 5,
                                    (volatile uint8_t *)LDC_SMD, LDC_SLOT, 0 };
static const p_channel to_master = { SLAVE + 0, SLAVE + 1, MASTER + 2, MASTER + 3, MASTER + 4, MASTER + 5,
                                     (volatile uint8_t *)LDC_MSD, LDC_SLOT, 0 };
static uint8_t sent[LDC_SLOT] __attribute__((aligned(8))), taken[LDC_SLOT] __attribute__((aligned(8)));

/* The structures lie one behind the other, each at a multiple of 8. */
static uint32_t wide(uint32_t size) { return (size + 7) & ~7u; }

static void pause(void) { __asm__ volatile("sev\nwfe\nwfe" ::: "memory"); }

#ifdef LDC_SLAVE

void ldc_serve(void) {
    static p_receiver receiver = { .channel = &to_slave, .data = taken };
    static p_sender sender = { .channel = &to_master };
    receiver.algorithms = ldc_remote_count;
    for (;;) {
        while (p_receive(&receiver) == P_BUSY) pause();
        const ldc_remote *r = &ldc_remotes[receiver.envelope.aid];
        uint8_t *in = taken + 8, *out = in + wide(r->in), *state = out + wide(r->out);
        uint32_t microseconds;
        __builtin_memcpy(&microseconds, taken, 4);
        r->entry(in, out, state, microseconds);
        /* Before the outputs: which call this answers. The inputs are not needed any more. */
        __builtin_memcpy(out - 8, &receiver.envelope.seq, 4);
        uint32_t size = 8 + wide(r->out) + wide(r->state);
        while (p_send(&sender, receiver.envelope.aid, P_UPDATE, out - 8, size, 0) == P_BUSY) pause();
    }
}

#else

/* Cycles of SysTick since the last call; without scans in real time nobody has started it yet. */
static uint32_t elapsed(void) {
    static uint32_t last;
    if (!(SYSTICK[0] & 1)) {
        SYSTICK[1] = 0xFFFFFF;
        SYSTICK[2] = 0;
        SYSTICK[0] = 5;
    }
    uint32_t now = SYSTICK[2], passed = now <= last ? last - now : last + SYSTICK[1] + 1 - now;
    last = now;
    return passed;
}

void ldc_second(void) {
    for (uint32_t i = 0; i < 8; i++) MASTER[i] = SLAVE[i] = 0;
    *(volatile uint32_t *)LDC_SECOND_TABLE = LDC_SECOND_VECTORS;
    __asm__ volatile("dsb" ::: "memory");
    *(volatile uint32_t *)LDC_SECOND_WAIT = 0;
}

void ldc_call(uint32_t number, const void *in, void *out, void *state, uint32_t microseconds) {
    static p_sender sender = { .channel = &to_slave, .patience = LDC_PATIENCE };
    static p_receiver receiver = { .channel = &to_master, .data = taken };
    const ldc_remote *r = &ldc_remotes[number];
    uint8_t *to_in = sent + 8, *to_out = to_in + wide(r->in), *to_state = to_out + wide(r->out);
    receiver.algorithms = ldc_remote_count;
    __builtin_memcpy(sent, &microseconds, 4);
    __builtin_memcpy(to_in, in, r->in);
    __builtin_memcpy(to_out, out, r->out);
    __builtin_memcpy(to_state, state, r->state);
    uint32_t size = (uint32_t)(to_state + wide(r->state) - sent);
    int32_t done;
    elapsed();
    while ((done = p_send(&sender, number, P_UPDATE, sent, size, elapsed())) == P_BUSY) pause();
    for (uint32_t waited = 0; done == P_DONE; waited += elapsed()) {
        int32_t received = p_receive(&receiver);
        /* An answer to an earlier call, which was given up, is none to this one. */
        if (received == P_DONE && !__builtin_memcmp(taken, &sender.seq, 4)) break;
        if (waited > LDC_PATIENCE) done = P_SILENT;
        pause();
    }
    if (done != P_DONE) {
        uint16_t code = (uint16_t)done;
        __builtin_memcpy((uint8_t *)out + r->error, &code, 2);
        return;
    }
    __builtin_memcpy(out, taken + 8, r->out);
    __builtin_memcpy(state, taken + 8 + wide(r->out), r->state);
}

#endif
