/* The transfer of data between two processors over shared memory: the sequence U* of docs/protocol.md, which
   loses nothing, gives nothing twice and stops nowhere, with one writer for every word. Envelope, codes and
   words are those of runtime/protocol, so that either side may be in C or in Python.

   Needs no system: each call makes one step and returns. It works over any memory that both sides see: the
   shared RAM of a chip, or memory shared by processes. */
#ifndef LDC_P_HANDSHAKE_H
#define LDC_P_HANDSHAKE_H

#include <stdint.h>

/* One direction of one slot. Flags are words with a bit (`mask`) for every slot; `begin`, `running` and the
   slot are written by the sender alone, the others by the receiver alone. `slot` holds `size` bytes, a
   multiple of 4: the envelope and its data. */
typedef struct {
    volatile uint32_t *begin, *running;
    volatile uint32_t *busy, *ack, *nack;
    volatile uint32_t *status, *last; /* code and token of the answer; read-back of a RESET */
    volatile uint32_t *slot;
    uint32_t size, mask;
} p_channel;

/* The areas of one slave (memory.toml); where both directions of a slot lie in them. */
typedef struct {
    volatile uint32_t *smd, *msd, *mpf, *spf, *mpa, *spa;
} p_areas;
void p_to_slave(p_channel *channel, const p_areas *areas, uint32_t slot, uint32_t size);
void p_to_master(p_channel *channel, const p_areas *areas, uint32_t slot, uint32_t size);

typedef struct {
    uint32_t seq, aid;
    uint16_t cmd, attempt;
    uint32_t len, crc;
} p_envelope;

enum { P_HEAD = 20, P_LAST_SEQ = 0x7FFFFF, P_RETRIES = 2 };
enum { P_START = 1, P_UPDATE = 2, P_STOP = 3, P_RESET = 4 };
/* Why data are refused. The last two a sender finds by itself: no answer after all attempts; flags of the
   receiver that stay 1. */
enum { P_LEN = 1, P_CRC, P_SEQ, P_AID, P_PID, P_TYPE, P_RANGE, P_STATE, P_STALE, P_SILENT, P_STUCK };
/* What a step returns: to be called again; finished; or one of the codes above. */
enum { P_BUSY = -1, P_DONE = 0 };

typedef struct {
    const p_channel *channel;
    uint32_t patience;        /* T_ack and T_clr in units of `elapsed`; 0: for ever */
    uint32_t seq, open;       /* the last transfer; the one whose fate is not known, 0: none */
    uint32_t last, delivered; /* of a reset: what the receiver took last; whether `open` was that */
    uint32_t resets, resetting, step, attempt, waited, code;
} p_sender;

/* One algorithm that a receiver knows; `parameters` are of p_parameters.h. */
typedef struct {
    uint32_t aid, count; /* its data are `count` pairs of pid and value */
    const struct p_parameter *parameters;
    const double *values; /* what the parameters are now, NaN: not known; 0: nothing is known */
    uint32_t running, ended;    /* `ended`: by itself, so that its sender may not know yet */
    uint32_t stamp, max_age_ms; /* `stamp`: the pid of the time of the data, 0: there is none */
} p_algorithm;

typedef struct {
    const p_channel *channel;
    const p_algorithm *algorithms; /* 0: aid is below `count`, data of any length, all execute */
    uint32_t count;
    /* Codes 5 to 9 of data (p_judge); 0: they are not looked into. */
    uint32_t (*judge)(const p_algorithm *known, const p_envelope *e, const uint8_t *data, uint32_t now_ms);
    uint32_t now_ms;
    uint8_t *frame, *data; /* `channel->size` bytes each: what is being checked; the data taken last, which
                              nobody changes, for a repetition is known by its content */
    p_envelope envelope;   /* of the message taken last */
    uint32_t taken, step, code, token, fresh;
} p_receiver;

uint16_t p_crc(uint16_t crc, const uint8_t *data, uint32_t size);

/* One step of sending; `elapsed`: time since the step before. `data` stay as they are until the result is not
   P_BUSY. After a code the link stands, and every call gives that code again, until p_reset is P_DONE. */
int32_t p_send(p_sender *sender, uint32_t aid, uint16_t cmd, const uint8_t *data, uint32_t len,
               uint32_t elapsed);

/* One step of making the link new, from any state: after a fault, or at a start on memory that was in use. */
int32_t p_reset(p_sender *sender, uint32_t elapsed);

/* One step of receiving; P_DONE: `envelope` and `data` hold a message that was not there before, data for an
   algorithm or a RESET. */
int32_t p_receive(p_receiver *receiver);

/* Code 8 or 0. `algorithm`: 0 when it is not known whether it executes. */
uint32_t p_of_state(const p_algorithm *algorithm, uint32_t cmd);

/* Makes the flags of a receiver without work 0: at a start, and from time to time, so that one that was
   disturbed does not stay. */
void p_scrub(p_receiver *receiver);

#endif
