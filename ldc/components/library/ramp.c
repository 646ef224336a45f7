#include "ramp.h"

void ramp(const ramp_in *in, ramp_out *out, ramp_state *state, uint32_t dt_us)
{
    const float dt = (float)dt_us * 1e-6f;
    const float wanted = in->enable ? in->target : 0.0f;
    (void)state;
    if (out->value < wanted)
        out->value = wanted - out->value > in->rise * dt ? out->value + in->rise * dt : wanted;
    else
        out->value = out->value - wanted > in->fall * dt ? out->value - in->fall * dt : wanted;
    out->reached = out->value == in->target;
}
