#include "ramp.h"

void ramp(const ramp_in *in, ramp_out *out, ramp_state *state, uint32_t dt_us)
{
    (void)state;
    (void)dt_us;
    if (in->target > 0
    out->value = in->target;
}
