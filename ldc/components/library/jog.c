#include "jog.h"

void jog(const jog_in *in, jog_out *out, jog_state *state, uint32_t dt_us)
{
    (void)out;
    (void)dt_us;
    if (in->enable) {
        PLC_D(jog_speed) = in->speed;
        PLC_D(jog_pressure) = in->pressure;
    } else if (state->active) {
        PLC_D(jog_speed) = 0.0f;
        PLC_D(jog_pressure) = 0.0f;
    }
    state->active = in->enable;
}
