/* The transfer of data between two processors over shared memory: the sequence U* of docs/firmware.md, which
   loses nothing, gives nothing twice and stops nowhere, with one writer for every word.

   Needs no system: each call makes one step and returns. It works over any memory that both sides see: the
   shared RAM of a chip, or POSIX shared memory between processes. */
#ifndef LDC_P_HANDSHAKE_H
#define LDC_P_HANDSHAKE_H

#include <stdint.h>

/* One direction of a link. The flags are words, a bit for every slot; the first two are written by the sender
   alone, the others by the receiver alone. `slot` holds `size` bytes: the envelope and its data. */
typedef struct {
    volatile uint32_t *begin, *running;
    volatile uint32_t *ack, *state, *nack, *code;
    volatile uint8_t *slot;
    uint32_t size, bit;
} p_channel;

typedef struct {
    uint32_t seq, aid;
    uint16_t cmd, attempt;
    uint32_t len, crc;
} p_envelope;

enum { P_START = 1, P_UPDATE = 2, P_STOP = 3, P_RESET = 4 };
/* Why data are refused. P_SILENT is the sender's own: no answer after all attempts. */
enum { P_LEN = 1, P_CRC = 2, P_SEQ = 3, P_AID = 4, P_SILENT = 10 };
/* What a step returns: to be called again; finished; or the reason of a refusal, above. */
enum { P_BUSY = -1, P_DONE = 0 };
#define P_RETRIES 2

typedef struct {
    const p_channel *channel;
    uint32_t patience; /* how long to wait for an answer, in units of `elapsed`; 0: for ever */
    uint32_t seq;      /* of the last message that was taken */
    uint32_t step, attempt, waited;
} p_sender;

typedef struct {
    const p_channel *channel;
    uint32_t algorithms; /* aid must be below */
    uint32_t seq;
    uint32_t step, code, fresh;
    uint8_t *data; /* of `channel->size` bytes: the last message that was taken */
    p_envelope envelope;
} p_receiver;

uint16_t p_crc(uint16_t crc, const uint8_t *data, uint32_t size);

/* One step of sending; `elapsed`: time since the step before. `data` stay as they are until the result is not
   P_BUSY. */
int32_t p_send(p_sender *sender, uint32_t aid, uint16_t cmd, const uint8_t *data, uint32_t len,
               uint32_t elapsed);

/* One step of receiving; P_DONE: `envelope` and `data` hold a message that was not there before. */
int32_t p_receive(p_receiver *receiver);

#endif
