/* See p_handshake.h. M0 to M5 and S1 to S5 are the steps of docs/firmware.md. */
#include "p_handshake.h"

#define HEAD 20u
#define FENCE() __atomic_thread_fence(__ATOMIC_SEQ_CST)

static uint32_t is(const p_channel *c, const volatile uint32_t *word) { return *word & 1u << c->bit; }

/* Only the one writer of a word changes it, so that reading before is safe. */
static void set(const p_channel *c, volatile uint32_t *word) {
    FENCE();
    *word = *word | 1u << c->bit;
    FENCE();
}

static void clear(const p_channel *c, volatile uint32_t *word) {
    FENCE();
    *word = *word & ~(1u << c->bit);
    FENCE();
}

/* CRC-16/MODBUS, four bits at a time. */
uint16_t p_crc(uint16_t crc, const uint8_t *data, uint32_t size) {
    static const uint16_t table[16] = { 0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401,
                                        0xA001, 0x6C00, 0x7800, 0xB401, 0x5000, 0x9C01, 0x8801, 0x4400 };
    while (size--) {
        crc = (uint16_t)(crc >> 4 ^ table[(crc ^ *data) & 15]);
        crc = (uint16_t)(crc >> 4 ^ table[(crc ^ *data++ >> 4) & 15]);
    }
    return crc;
}

static uint32_t crc_of(const p_envelope *envelope, const uint8_t *data) {
    return p_crc(p_crc(0xFFFF, (const uint8_t *)envelope, HEAD - 4), data, envelope->len);
}

static void copied_out(volatile uint8_t *to, const uint8_t *from, uint32_t size) {
    while (size--) *to++ = *from++;
}

static void copied_in(uint8_t *to, const volatile uint8_t *from, uint32_t size) {
    while (size--) *to++ = *from++;
}

/* The slot is given up; the same message again, or no more. */
static int32_t failed(p_sender *s, uint32_t code) {
    clear(s->channel, s->channel->running);
    s->step = 0;
    s->waited = 0;
    if ((code == P_CRC || code == P_SEQ || code == P_SILENT) && s->attempt < P_RETRIES) {
        s->attempt++;
        return P_BUSY;
    }
    s->attempt = 0;
    return (int32_t)code;
}

int32_t p_send(p_sender *s, uint32_t aid, uint16_t cmd, const uint8_t *data, uint32_t len, uint32_t elapsed) {
    const p_channel *c = s->channel;
    switch (s->step) {
    case 0: /* M0 */
        if (len > c->size - HEAD || len % 4) return P_LEN;
        if (is(c, c->running) || is(c, c->ack) || is(c, c->nack) || is(c, c->state)) break;
        s->step = 1;
        return P_BUSY;
    case 1: /* M1 */
        set(c, c->begin);
        s->step = 2;
        return P_BUSY;
    case 2: /* M2 */
        set(c, c->running);
        s->step = 3;
        return P_BUSY;
    case 3: { /* M3 */
        p_envelope envelope = { s->seq + 1, aid, cmd, (uint16_t)s->attempt, len, 0 };
        envelope.crc = crc_of(&envelope, data);
        copied_out(c->slot, (const uint8_t *)&envelope, HEAD);
        copied_out(c->slot + HEAD, data, len);
        s->step = 4;
        return P_BUSY;
    }
    case 4: /* M4 */
        clear(c, c->begin);
        s->waited = 0;
        s->step = 5;
        return P_BUSY;
    case 5: /* M5 */
        if (is(c, c->state) || !(is(c, c->ack) || is(c, c->nack))) break;
        if (is(c, c->nack)) return failed(s, *c->code);
        clear(c, c->running);
        s->seq++;
        s->step = s->attempt = 0;
        return P_DONE;
    }
    s->waited += elapsed;
    if (s->patience && s->waited > s->patience) return failed(s, P_SILENT);
    return P_BUSY;
}

static uint32_t checked(p_receiver *r) {
    const p_channel *c = r->channel;
    copied_in((uint8_t *)&r->envelope, c->slot, HEAD);
    const p_envelope *e = &r->envelope;
    if (e->len > c->size - HEAD || e->len % 4) return P_LEN;
    copied_in(r->data, c->slot + HEAD, e->len);
    if (e->crc != crc_of(e, r->data)) return P_CRC;
    if (e->cmd != P_RESET && e->seq != r->seq && e->seq != r->seq + 1) return P_SEQ;
    return e->aid < r->algorithms ? 0 : P_AID;
}

int32_t p_receive(p_receiver *r) {
    const p_channel *c = r->channel;
    switch (r->step) {
    case 0: /* S1 */
        if (!is(c, c->running) || is(c, c->begin)) return P_BUSY;
        set(c, c->state);
        r->step = 1;
        return P_BUSY;
    case 1: /* S2 */
        r->code = checked(r);
        /* The last message again: its answer was lost, so it is answered but not taken twice. */
        r->fresh = !r->code && (r->envelope.seq != r->seq || r->envelope.cmd == P_RESET);
        if (!r->code) r->seq = r->envelope.seq;
        r->step = 2;
        return P_BUSY;
    case 2: /* S3 */
        *c->code = r->code;
        set(c, r->code ? c->nack : c->ack);
        r->step = 3;
        return P_BUSY;
    case 3: /* S4 */
        clear(c, c->state);
        r->step = 4;
        return P_BUSY;
    default: /* S5 */
        if (is(c, c->running)) return P_BUSY;
        clear(c, c->ack);
        clear(c, c->nack);
        r->step = 0;
        return r->fresh ? P_DONE : P_BUSY;
    }
}
