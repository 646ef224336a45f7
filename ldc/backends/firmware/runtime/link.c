/* A call is two transfers: time, inputs, outputs and state to the slave; number of the call, outputs and
   state back. The state of a component stays with its instance in the master, so that the slave may be
   started anew at any moment. */
#include "link.h"
#include "board.h"

#define MASTER ((volatile uint32_t *)LDC_MPF)
#define SLAVE ((volatile uint32_t *)LDC_SPF)
#define SYSTICK ((volatile uint32_t *)0xE000E010u)

static const p_areas areas = { (volatile uint32_t *)LDC_SMD, (volatile uint32_t *)LDC_MSD, MASTER, SLAVE,
                               (volatile uint32_t *)LDC_MPA, (volatile uint32_t *)LDC_SPA };
static p_channel to_slave, to_master;
static uint8_t sent[LDC_SLOT] __attribute__((aligned(8))), taken[LDC_SLOT] __attribute__((aligned(8)));
static uint8_t frame[LDC_SLOT];

static void placed(void) {
    p_to_slave(&to_slave, &areas, 0, LDC_SLOT);
    p_to_master(&to_master, &areas, 0, LDC_SLOT);
}

/* The structures lie one behind the other, each at a multiple of 8. */
static uint32_t wide(uint32_t size) { return (size + 7) & ~7u; }

static void pause(void) { __asm__ volatile("sev\nwfe\nwfe" ::: "memory"); }

#ifdef LDC_SLAVE

/* Until the master has it; a master that was started anew is linked anew first. */
static void answer(p_sender *sender, uint32_t aid, const uint8_t *data, uint32_t size) {
    for (;;) {
        int32_t done;
        while ((done = p_send(sender, aid, P_UPDATE, data, size, 0)) == P_BUSY) pause();
        if (done == P_DONE) return;
        while (p_reset(sender, 0) != P_DONE) pause();
    }
}

/* The time since the last call, in steps of the component's period. One that tells an error is not executed
   any more in this call. */
static void executed(const ldc_remote *r, const uint8_t *in, uint8_t *out, uint8_t *state,
                     uint32_t microseconds) {
    uint16_t error;
    do {
        uint32_t step = r->period && r->period < microseconds ? r->period : microseconds;
        r->entry(in, out, state, step);
        microseconds -= step;
        __builtin_memcpy(&error, out + r->error, 2);
    } while (microseconds && !error);
}

void ldc_serve(void) {
    static p_receiver receiver = { .channel = &to_slave, .frame = frame, .data = taken };
    static p_sender sender = { .channel = &to_master };
    receiver.count = ldc_remote_count;
    placed();
    p_scrub(&receiver);
    for (;;) {
        while (p_receive(&receiver) != P_DONE) pause();
        if (receiver.envelope.cmd != P_UPDATE) continue;
        const ldc_remote *r = &ldc_remotes[receiver.envelope.aid];
        __builtin_memcpy(sent, taken, receiver.envelope.len);
        uint8_t *in = sent + 8, *out = in + wide(r->in), *state = out + wide(r->out);
        uint32_t microseconds;
        __builtin_memcpy(&microseconds, sent, 4);
        executed(r, in, out, state, microseconds);
        /* Before the outputs: which call this answers. The inputs are not needed any more. */
        __builtin_memcpy(out - 8, &receiver.envelope.seq, 4);
        answer(&sender, receiver.envelope.aid, out - 8, 8 + wide(r->out) + wide(r->state));
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
    placed();
    *(volatile uint32_t *)LDC_SECOND_TABLE = LDC_SECOND_VECTORS;
    __asm__ volatile("dsb" ::: "memory");
    *(volatile uint32_t *)LDC_SECOND_WAIT = 0;
}

/* While it sends: an answer that comes too late is taken, for the slave waits until it is. */
static void listen(p_receiver *receiver) {
    p_receive(receiver);
    pause();
}

void ldc_call(uint32_t number, const void *in, void *out, void *state, uint32_t microseconds) {
    static p_sender sender = { .channel = &to_slave, .patience = LDC_PATIENCE };
    static p_receiver receiver = { .channel = &to_master, .frame = frame, .data = taken };
    const ldc_remote *r = &ldc_remotes[number];
    uint8_t *to_in = sent + 8, *to_out = to_in + wide(r->in), *to_state = to_out + wide(r->out);
    receiver.count = ldc_remote_count;
    __builtin_memcpy(sent, &microseconds, 4);
    __builtin_memcpy(to_in, in, r->in);
    __builtin_memcpy(to_out, out, r->out);
    __builtin_memcpy(to_state, state, r->state);
    uint32_t size = (uint32_t)(to_state + wide(r->state) - sent);
    int32_t done = P_DONE;
    elapsed();
    if (sender.code) { /* an earlier call failed */
        while ((done = p_reset(&sender, elapsed())) == P_BUSY) listen(&receiver);
    }
    if (done == P_DONE) {
        while ((done = p_send(&sender, number, P_UPDATE, sent, size, elapsed())) == P_BUSY) listen(&receiver);
    }
    for (uint32_t waited = 0; done == P_DONE; waited += elapsed()) {
        int32_t received = p_receive(&receiver);
        /* An answer to an earlier call, which was given up, is none to this one. */
        int ours = received == P_DONE && receiver.envelope.cmd == P_UPDATE;
        if (ours && !__builtin_memcmp(taken, &sender.seq, 4)) break;
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
