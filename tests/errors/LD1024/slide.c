#include <math.h>
#include "slide.h"

/* The speed from which the slope stops the slide within a distance; the next step is driven before it acts. */
static float stopping(float distance, float step, float slope)
{
    return sqrtf(2.0f * slope * fmaxf(fabsf(distance) - fabsf(step), 0.0f));
}

void slide(const slide_in *in, slide_out *out, slide_state *state, uint32_t dt_us)
{
    const float dt = (float)dt_us * 1e-6f;
    const float rest = in->target - out->position;
    const float change = in->slope * dt;
    float wanted = 0.0f;
    if (in->enable) {
        wanted = fminf(in->limit, stopping(rest, out->speed * dt, in->slope));
        if (rest < 0.0f)
            wanted = -wanted;
    }
    out->speed += fminf(fmaxf(wanted - out->speed, -change), change);
    float step = out->speed * dt;
    if (in->enable && fabsf(rest) <= fabsf(step) + 0.01f && fabsf(out->speed) <= 2.0f * change) {
        step = rest;
        out->speed = 0.0f;
    }
    out->position += step;
    state->path += fabsf(step);
    out->there = in->enable && out->speed == 0.0f && fabsf(in->target - out->position) < 0.001f;
}
