/* See p_handshake.h. M0 to M5 and S1 to S5 are the steps of docs/protocol.md. */
#include "p_handshake.h"

/* All accesses to words that the other side sees or writes. Whoever goes through every interleaving of two
   machines (tests/p_steps.c) has accesses of its own. */
#ifndef P_LOAD
#define P_LOAD(word, order) __atomic_load_n(word, order)
#define P_STORE(word, value, order) __atomic_store_n(word, value, order)
#endif

static uint32_t load(const volatile uint32_t *word) { return P_LOAD(word, __ATOMIC_ACQUIRE); }

static void store(volatile uint32_t *word, uint32_t value) { P_STORE(word, value, __ATOMIC_RELEASE); }

static uint32_t is(const p_channel *c, const volatile uint32_t *word) { return load(word) & c->mask; }

/* Only the one writer of a word changes it, so that reading before is safe. */
static void set(const p_channel *c, volatile uint32_t *word) { store(word, *word | c->mask); }
static void clear(const p_channel *c, volatile uint32_t *word) { store(word, *word & ~c->mask); }

/* Where a store has to be seen before the loads behind it are made: what one side withdraws the other side
   may be about to take. */
static void settle(void) { __atomic_thread_fence(__ATOMIC_SEQ_CST); }

static void placed(p_channel *c, volatile uint32_t *from, volatile uint32_t *to, volatile uint32_t *answer,
                   volatile uint32_t *data, uint32_t slot, uint32_t size) {
    p_channel made = { from, from + 1, to + 3, to + 2, to + 4, answer + 2 * slot, answer + 2 * slot + 1,
                       data + slot * (size / 4), size, 1u << slot };
    *c = made;
}

void p_to_slave(p_channel *c, const p_areas *a, uint32_t slot, uint32_t size) {
    placed(c, a->mpf, a->spf, a->spa, a->smd, slot, size);
}

void p_to_master(p_channel *c, const p_areas *a, uint32_t slot, uint32_t size) {
    placed(c, a->spf, a->mpf, a->mpa, a->msd, slot, size);
}

/* CRC-16/MODBUS, a byte at a time: what its lower and its upper four bits leave. */
uint16_t p_crc(uint16_t crc, const uint8_t *data, uint32_t size) {
    static const uint16_t low[16] = { 0x0000, 0xC0C1, 0xC181, 0x0140, 0xC301, 0x03C0, 0x0280, 0xC241,
                                      0xC601, 0x06C0, 0x0780, 0xC741, 0x0500, 0xC5C1, 0xC481, 0x0440 };
    static const uint16_t high[16] = { 0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401,
                                       0xA001, 0x6C00, 0x7800, 0xB401, 0x5000, 0x9C01, 0x8801, 0x4400 };
    while (size--) {
        uint32_t byte = (crc ^ *data++) & 255u;
        crc = (uint16_t)(crc >> 8 ^ low[byte & 15] ^ high[byte >> 4]);
    }
    return crc;
}

static uint32_t crc_of(const p_envelope *envelope, const uint8_t *data) {
    return p_crc(p_crc(0xFFFF, (const uint8_t *)envelope, P_HEAD - 4), data, envelope->len);
}

static void copied_out(volatile uint32_t *to, const void *from, uint32_t size) {
    const uint8_t *bytes = from;
    for (uint32_t n = 0; n < size; n += 4) {
        uint32_t word;
        __builtin_memcpy(&word, bytes + n, 4);
        P_STORE(to + n / 4, word, __ATOMIC_RELAXED);
    }
}

static void copied_in(void *to, const volatile uint32_t *from, uint32_t size) {
    uint8_t *bytes = to;
    for (uint32_t n = 0; n < size; n += 4) {
        uint32_t word = P_LOAD(from + n / 4, __ATOMIC_RELAXED);
        __builtin_memcpy(bytes + n, &word, 4);
    }
}

static uint32_t token(uint32_t seq, uint32_t aid, uint32_t cmd) {
    return cmd == P_RESET ? 0x800000u | (aid & 0x7FFFFFu) : seq & 0xFFFFFFu;
}

static uint32_t successor(uint32_t seq) { return seq < P_LAST_SEQ ? seq + 1 : 1; }

enum { IDLE, REST, BEGIN, RUN, COPY, COMPLETE, ANSWER, CLOSE, WITHDRAW, FAULT };

static int32_t fault(p_sender *s, uint32_t code) {
    s->step = FAULT;
    s->code = code;
    return (int32_t)code;
}

/* The flags of this side are 0: taken, once more, or given up. */
static int32_t judged(p_sender *s) {
    uint32_t again = s->resetting || s->code == P_CRC || s->code == P_SEQ || s->code == P_SILENT;
    if (s->code && !(again && s->attempt < P_RETRIES)) return fault(s, s->code);
    s->waited = 0;
    if (s->code) {
        s->attempt++;
        s->step = REST;
        return P_BUSY;
    }
    s->step = IDLE;
    if (s->resetting) {
        s->delivered = s->open && s->open == s->last;
        s->seq = s->resetting = 0;
    }
    s->open = 0;
    return P_DONE;
}

static int32_t waits(p_sender *s, uint32_t elapsed) {
    s->waited += elapsed;
    if (!s->patience || s->waited <= s->patience) return P_BUSY;
    if (s->step == REST) return fault(s, P_STUCK);
    s->step = WITHDRAW;
    s->code = P_SILENT;
    return P_BUSY;
}

/* What the answer says. An answer to another transfer is none to this one. */
static uint32_t answered(p_sender *s, uint32_t aid, uint32_t cmd) {
    uint32_t word = load(s->channel->status), code = word & 255u;
    uint32_t ours = code == P_CRC || code == P_SEQ || word >> 8 == token(s->seq, aid, cmd);
    if (code > P_STALE || !ours) return P_SILENT;
    if (!code && cmd == P_RESET) s->last = load(s->channel->last);
    return code;
}

static int32_t sent(p_sender *s, uint32_t aid, uint16_t cmd, const uint8_t *data, uint32_t len,
                    uint32_t elapsed) {
    const p_channel *c = s->channel;
    switch (s->step) {
    case REST: /* M0 */
        if (is(c, c->ack) || is(c, c->nack) || is(c, c->busy)) return waits(s, elapsed);
        s->waited = 0;
        break;
    case BEGIN: /* M1 */
        set(c, c->begin);
        break;
    case RUN: /* M2 */
        set(c, c->running);
        break;
    case COPY: { /* M3: the number comes last */
        p_envelope envelope = { cmd == P_RESET ? 0 : s->seq, aid, cmd, (uint16_t)s->attempt, len, 0 };
        envelope.crc = crc_of(&envelope, data);
        copied_out(c->slot + P_HEAD / 4, data, len);
        copied_out(c->slot + 1, &envelope.aid, P_HEAD - 4);
        store(c->slot, envelope.seq);
        break;
    }
    case COMPLETE: /* M4 */
        clear(c, c->begin);
        break;
    case ANSWER: /* M5 */
        if (!(is(c, c->ack) || is(c, c->nack)) || is(c, c->busy)) return waits(s, elapsed);
        s->code = answered(s, aid, cmd);
        break;
    case CLOSE:
        clear(c, c->running);
        return judged(s);
    default: /* WITHDRAW */
        clear(c, c->begin);
        clear(c, c->running);
        settle();
        return judged(s);
    }
    s->step++;
    return P_BUSY;
}

int32_t p_send(p_sender *s, uint32_t aid, uint16_t cmd, const uint8_t *data, uint32_t len, uint32_t elapsed) {
    if (s->step == FAULT) return (int32_t)s->code;
    if (s->step != IDLE) return sent(s, aid, cmd, data, len, elapsed);
    if (len > s->channel->size - P_HEAD || len % 4) return P_LEN;
    s->seq = s->open = successor(s->seq);
    s->attempt = s->waited = 0;
    s->step = REST;
    return P_BUSY;
}

int32_t p_reset(p_sender *s, uint32_t elapsed) {
    if (s->resetting && s->step != FAULT) return sent(s, s->resets, P_RESET, 0, 0, elapsed);
    /* One that has failed is the same again, so that a receiver that knows it still tells what it had. */
    if (!s->resetting) s->resets++;
    s->resetting = 1;
    s->attempt = s->waited = s->code = 0;
    clear(s->channel, s->channel->begin);
    clear(s->channel, s->channel->running);
    settle();
    s->step = REST;
    return P_BUSY;
}

static const p_algorithm *known(const p_receiver *r, uint32_t aid) {
    for (uint32_t n = 0; r->algorithms && n < r->count; n++)
        if (r->algorithms[n].aid == aid) return r->algorithms + n;
    return 0;
}

uint32_t p_of_state(const p_algorithm *a, uint32_t cmd) {
    if (cmd < P_START || cmd > P_STOP) return P_STATE;
    if (!a || cmd == P_STOP) return 0;
    return (cmd == P_START ? a->running : !a->running && !a->ended) ? P_STATE : 0;
}

static int again(const p_receiver *r, const p_envelope *e) {
    const p_envelope *t = &r->envelope;
    return r->taken && e->seq == t->seq && e->aid == t->aid && e->cmd == t->cmd && e->len == t->len
        && !__builtin_memcmp(r->frame, r->data, e->len);
}

/* S2: the first code that fails. `e` and the frame get what lies in the slot. */
static uint32_t checked(p_receiver *r, p_envelope *e) {
    const p_channel *c = r->channel;
    copied_in(e, c->slot, P_HEAD);
    r->token = token(e->seq, e->aid, e->cmd);
    r->fresh = 0;
    const p_algorithm *a = known(r, e->aid);
    uint32_t due = e->cmd == P_STOP || e->cmd == P_RESET ? 0 : a ? 8 * a->count : e->len;
    if (e->len > c->size - P_HEAD || e->len % 4 || e->len != due) return P_LEN;
    copied_in(r->frame, c->slot + P_HEAD / 4, e->len);
    if (e->crc != crc_of(e, r->frame)) return P_CRC;
    if (again(r, e)) return 0;
    if (e->seq != (e->cmd == P_RESET ? 0 : successor(r->taken ? r->envelope.seq : 0))) return P_SEQ;
    if (e->cmd != P_RESET) {
        if (r->algorithms ? !a : e->aid >= r->count) return P_AID;
        uint32_t code = a && r->judge ? r->judge(a, e, r->frame, r->now_ms) : p_of_state(a, e->cmd);
        if (code) return code;
    }
    r->fresh = 1;
    return 0;
}

int32_t p_receive(p_receiver *r) {
    const p_channel *c = r->channel;
    switch (r->step) {
    case 0: /* S1 */
        if (!is(c, c->running) || is(c, c->begin)) return P_BUSY;
        set(c, c->busy);
        settle();
        break;
    case 1: { /* S2. What is taken is taken here: whatever happens to the answer, it is not given again. */
        p_envelope e;
        r->code = checked(r, &e);
        if (!r->fresh) break;
        if (e.cmd == P_RESET) store(c->last, r->taken ? r->envelope.seq : 0);
        r->envelope = e;
        r->taken = 1;
        __builtin_memcpy(r->data, r->frame, e.len);
        break;
    }
    case 2: /* S3 */
        store(c->status, r->token << 8 | r->code);
        set(c, r->code ? c->nack : c->ack);
        break;
    case 3: /* S4 */
        clear(c, c->busy);
        break;
    default: /* S5 */
        if (is(c, c->running)) return P_BUSY;
        clear(c, c->ack);
        clear(c, c->nack);
        r->step = 0;
        return r->fresh ? P_DONE : P_BUSY;
    }
    r->step++;
    return P_BUSY;
}

void p_scrub(p_receiver *r) {
    if (r->step) return;
    clear(r->channel, r->channel->busy);
    clear(r->channel, r->channel->ack);
    clear(r->channel, r->channel->nack);
}
