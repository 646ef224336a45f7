/* What the parameters of an algorithm may be (docs/protocol.md, codes 5 to 9). */
#ifndef LDC_P_PARAMETERS_H
#define LDC_P_PARAMETERS_H

#include "p_handshake.h"

enum { P_F32, P_I32, P_U32, P_BOOL32 };

/* `rate`: the most that a value may differ from the one before. */
typedef struct p_parameter {
    uint32_t pid, type;
    double min, max, rate;
} p_parameter;

/* The value of four bytes of a type. */
double p_value(const uint8_t *raw, uint32_t type);

/* For p_receiver.judge: the first of the codes 5 to 9 that fails, 0 when none does. */
uint32_t p_judge(const p_algorithm *algorithm, const p_envelope *e, const uint8_t *data, uint32_t now_ms);

#endif
