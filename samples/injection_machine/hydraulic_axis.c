#include "hydraulic_axis.h"

#include <math.h>

enum { REST, MOVES, OVER };

static float least(float a, float b)
{
    return a < b ? a : b;
}

/* The velocity from which the creep velocity is reached within a way. */
static float braking(const hydraulic_axis_in *in, float way)
{
    return way > 0 ? sqrtf(in->creep * in->creep + 2 * in->acceleration * way) : in->creep;
}

void hydraulic_axis(const hydraulic_axis_in *in, hydraulic_axis_out *out, hydraulic_axis_state *state, uint32_t dt_us)
{
    const float dt = (float)dt_us * 1e-6f;
    const float most = in->acceleration * dt;

    if (!in->enable) {
        out->done = false;
        state->phase = REST;
        state->speed = state->speed > most ? state->speed - most : 0;
        out->reference = state->way * state->speed;
        return;
    }
    if (state->phase == REST) {
        state->phase = MOVES;
        state->way = in->target < in->measured ? -1.0f : 1.0f;
    }
    if (state->phase == MOVES) {
        const float left = state->way * (in->target - in->measured);
        if (left <= in->creep * (in->lead + dt / 2)) { /* it would be seen half a period late on average */
            state->phase = OVER;
            state->speed = 0;
        } else {
            const float limit = least(in->velocity, braking(in, left - in->creep_distance));
            state->speed = least(limit, state->speed + most);
        }
    }
    out->position = in->measured;
    out->reference = state->way * state->speed;
    out->done = state->phase == OVER;
}
