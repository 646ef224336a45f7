#include "press_force.h"

static float at_depth(float depth, float surface, float stiffness)
{
    return depth > surface ? (depth - surface) * stiffness : 0.0f;
}

void press_force(const press_force_in *in, press_force_out *out, press_force_state *state, uint32_t dt_us)
{
    (void)dt_us;
    out->force = in->enable ? at_depth((float)in->depth, in->surface, in->stiffness) : 0.0f;
    if (!in->enable)
        state->highest = 0.0f;
    else if (out->force > state->highest)
        state->highest = out->force;
    if (out->force > PLC_D(force_limit))
        PLC_M(overload) = true;
}
