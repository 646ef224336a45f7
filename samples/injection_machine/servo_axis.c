#include "servo_axis.h"

#include <math.h>

enum { REST, MOVES, BRAKES, STEPS = 8 };

typedef struct {
    double x, v, a;
} motion;

/* A profile is a start and steps of the jerk: each adds a cubic from its time on. */
static motion at(const servo_axis_state *state, double t)
{
    motion m;
    m.x = state->x0 + t * (state->v0 + t * state->a0 / 2);
    m.v = state->v0 + t * state->a0;
    m.a = state->a0;
    for (int i = 0; i < STEPS; i++) {
        const double s = t - state->times[i];
        if (s > 0) {
            m.a += state->steps[i] * s;
            m.v += state->steps[i] * s * s / 2;
            m.x += state->steps[i] * s * s * s / 6;
        }
    }
    return m;
}

static void begin(servo_axis_state *state, int phase, motion from)
{
    state->phase = (uint8_t)phase;
    state->clock = 0;
    state->x0 = from.x;
    state->v0 = from.v;
    state->a0 = from.a;
    for (int i = 0; i < STEPS; i++)
        state->times[i] = state->steps[i] = 0;
}

/* From rest to rest: ramps of the jerk `ramp` long, `rise` from rest to the velocity, then `cruise`. Limits that a
 * short way does not reach are lowered. */
static void move(const servo_axis_in *in, servo_axis_state *state, double from)
{
    const double v = in->max_velocity, a = in->max_acceleration, j = in->max_jerk;
    const double distance = state->goal - from, way = fabs(distance), jerk = distance < 0 ? -j : j;
    double ramp = fmin(a / j, sqrt(v / j)), cruise = 0;
    double rise = ramp + v / (j * ramp);
    if (way >= v * rise) {
        cruise = way / v - rise;
    } else {
        ramp = fmin(a / j, cbrt(way / (2 * j)));
        rise = ramp / 2 + sqrt(ramp * ramp / 4 + way / (j * ramp));
    }
    const double turn = rise + cruise;
    const double times[STEPS] = { 0, ramp, rise - ramp, rise, turn, turn + ramp, turn + rise - ramp, turn + rise };
    const double signs[STEPS] = { 1, -1, -1, 1, -1, 1, 1, -1 };
    begin(state, MOVES, (motion){ from, 0, 0 });
    for (int i = 0; i < STEPS; i++) {
        state->times[i] = times[i];
        state->steps[i] = jerk * signs[i];
    }
    state->ends = turn + rise;
}

/* From any motion to rest: the deceleration rises to its peak, stays, and falls to nothing. */
static void brake(const servo_axis_in *in, servo_axis_state *state, motion from)
{
    const double most = in->max_acceleration, j = in->max_jerk;
    const double over = from.v + from.a * fabs(from.a) / (2 * j); /* velocity once the acceleration is gone */
    const double way = over < 0 ? -1 : 1, v = way * from.v, a = way * from.a;
    double peak = sqrt(fmax(0, j * v + a * a / 2)), stay = 0;
    if (peak > most) {
        peak = most;
        stay = (v + a * a / (2 * j) - most * most / j) / most;
    }
    const double rise = (a + peak) / j, fall = peak / j;
    begin(state, BRAKES, from);
    state->steps[0] = -way * j;
    state->steps[1] = state->steps[2] = way * j;
    state->steps[3] = -way * j;
    state->times[1] = rise;
    state->times[2] = rise + stay;
    state->times[3] = state->ends = rise + stay + fall;
}

void servo_axis(const servo_axis_in *in, servo_axis_out *out, servo_axis_state *state, uint32_t dt_us)
{
    if (state->phase == REST && in->enable && in->target != state->goal) {
        const bool stands = fabs(state->goal - in->measured) <= in->tolerance;
        const double from = stands ? state->goal : in->measured;
        state->goal = in->target;
        move(in, state, from);
    } else if (state->phase != REST) {
        state->clock += (double)dt_us * 1e-6;
        if (state->phase == MOVES && (!in->enable || in->target != state->goal))
            brake(in, state, at(state, state->clock));
        if (state->clock >= state->ends) {
            if (state->phase == BRAKES)
                state->goal = at(state, state->ends).x;
            state->phase = REST;
        }
    }
    if (state->phase == REST && !in->enable) {
        out->done = false;
        out->reference = out->speed = 0;
        return;
    }
    motion m = { state->goal, 0, 0 };
    if (state->phase != REST)
        m = at(state, state->clock);
    out->wanted = (float)m.x;
    out->speed = (float)m.v;
    out->position = in->measured;
    out->reference = (float)(m.v + in->stiffness * (m.x - in->measured));
    out->done = in->enable && state->phase == REST && fabs(m.x - in->measured) <= in->tolerance;
}
