/* See p_parameters.h. Pairs of pid and value come in any order, each pid once. */
#include "p_parameters.h"

static uint32_t word(const uint8_t *at) {
    uint32_t value;
    __builtin_memcpy(&value, at, 4);
    return value;
}

double p_value(const uint8_t *raw, uint32_t type) {
    uint32_t bits = word(raw);
    float single;
    __builtin_memcpy(&single, &bits, 4);
    return type == P_F32 ? (double)single : type == P_I32 ? (double)(int32_t)bits : (double)bits;
}

/* Where the value of a pid lies; 0 when it is missing. There are as many pairs as parameters: when none is
   missing, none is there twice or foreign. */
static const uint8_t *found(const p_algorithm *a, const uint8_t *data, uint32_t pid) {
    for (uint32_t n = 0; n < a->count; n++)
        if (word(data + 8 * n) == pid) return data + 8 * n + 4;
    return 0;
}

static uint32_t judged(const p_algorithm *a, const uint8_t *data) {
    for (uint32_t n = 0; n < a->count; n++)
        if (!found(a, data, a->parameters[n].pid)) return P_PID;
    for (uint32_t n = 0; n < a->count; n++) {
        const p_parameter *p = a->parameters + n;
        uint32_t bits = word(found(a, data, p->pid));
        if (p->type == P_F32 && (bits & 0x7F800000u) == 0x7F800000u) return P_TYPE;
        if (p->type == P_BOOL32 && bits > 1) return P_TYPE;
    }
    for (uint32_t n = 0; n < a->count; n++) {
        const p_parameter *p = a->parameters + n;
        double value = p_value(found(a, data, p->pid), p->type);
        if (!(p->min <= value && value <= p->max)) return P_RANGE;
        if (a->values && (value - a->values[n] > p->rate || a->values[n] - value > p->rate)) return P_RANGE;
    }
    return 0;
}

uint32_t p_judge(const p_algorithm *a, const p_envelope *e, const uint8_t *data, uint32_t now_ms) {
    uint32_t code = e->cmd == P_STOP ? 0 : judged(a, data);
    if (!code) code = p_of_state(a, e->cmd);
    if (code) return code;
    const uint8_t *stamp = a->stamp && e->cmd != P_STOP ? found(a, data, a->stamp) : 0;
    return stamp && now_ms - word(stamp) > a->max_age_ms ? P_STALE : 0;
}
