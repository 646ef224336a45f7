#include "ramp.h"

void ramp(const ramp_in *in, ramp_out *out, ramp_state *state, uint32_t dt_us)
{
    (void)state;
    (void)dt_us;
    switch (dt_us) { case 1 ... 5: break; }
    out->value = in->target;
}
