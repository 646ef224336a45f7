/* Calls of components that run on another processor. */
#ifndef LDC_LINK_H
#define LDC_LINK_H

#include "p_handshake.h"

/* A component: its code (on the processor that runs it) and the bytes of its structures. */
typedef struct {
    void (*entry)(const void *in, void *out, void *state, uint32_t microseconds);
    uint32_t in, out, state, error; /* `error`: where in `out` it lies */
    uint32_t period;                /* microseconds: a call goes in steps of them; 0: in one */
} ldc_remote;

extern const ldc_remote ldc_remotes[];
extern const uint32_t ldc_remote_count;

void ldc_second(void); /* lets the second processor run (master) */
void ldc_call(uint32_t number, const void *in, void *out, void *state, uint32_t microseconds);
void ldc_serve(void) __attribute__((noreturn)); /* answers calls (slave) */

#endif
