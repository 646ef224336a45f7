#include "axis_scurve.h"

#include <math.h>

enum { REST, MOVES, BRAKES };

typedef struct {
    double x, v, a;
} motion;

/* Where a motion with constant jerk is after a time. */
static motion after(motion from, double jerk, double t)
{
    motion to;
    to.x = from.x + t * (from.v + t * (from.a / 2 + t * jerk / 6));
    to.v = from.v + t * (from.a + t * jerk / 2);
    to.a = from.a + t * jerk;
    return to;
}

static void segment(axis_scurve_state *state, int number, double time, double jerk)
{
    state->times[number] = time > 0 ? time : 0;
    state->jerks[number] = jerk;
}

static double duration(const axis_scurve_state *state)
{
    double sum = 0;
    for (int i = 0; i < 7; i++)
        sum += state->times[i];
    return sum;
}

static void begin(axis_scurve_state *state, int phase, motion from)
{
    state->phase = (uint8_t)phase;
    state->clock = 0;
    state->x0 = from.x;
    state->v0 = from.v;
    state->a0 = from.a;
}

/* From rest to rest over a distance: limits that a short way does not reach are lowered. */
static void plan_move(const axis_scurve_in *in, axis_scurve_state *state, double distance)
{
    const double way = fabs(distance), v = in->max_velocity, a = in->max_acceleration, j = in->max_jerk;
    const double jerk = distance < 0 ? -j : j;
    double ramp = a / j, rise, cruise = 0;
    if (v * j < a * a) { /* the velocity is reached before the acceleration */
        ramp = sqrt(v / j);
        rise = 2 * ramp;
    } else {
        rise = ramp + v / a;
    }
    if (way >= v * rise) {
        cruise = way / v - rise;
    } else if (v * j >= a * a && way >= 2 * a * ramp * ramp) {
        rise = ramp / 2 + sqrt(ramp * ramp / 4 + way / a);
    } else { /* neither is reached, or only a peak of the acceleration */
        ramp = cbrt(way / (2 * j));
        rise = 2 * ramp;
    }
    segment(state, 0, ramp, jerk);
    segment(state, 1, rise - 2 * ramp, 0);
    segment(state, 2, ramp, -jerk);
    segment(state, 3, cruise, 0);
    segment(state, 4, ramp, -jerk);
    segment(state, 5, rise - 2 * ramp, 0);
    segment(state, 6, ramp, jerk);
}

/* From any velocity and acceleration to rest. */
static void plan_stop(const axis_scurve_in *in, axis_scurve_state *state, motion from)
{
    const double a = in->max_acceleration, j = in->max_jerk;
    const double left = from.v + from.a * fabs(from.a) / (2 * j); /* velocity once the acceleration is gone */
    const double way = left < 0 ? -1 : 1, v = way * from.v, a0 = way * from.a;
    const double under_root = j * v + a0 * a0 / 2;
    double peak = sqrt(under_root > 0 ? under_root : 0), hold = 0;
    if (peak > a) {
        peak = a;
        hold = (v + a0 * a0 / (2 * j) - a * a / j) / a;
    }
    segment(state, 0, (a0 + peak) / j, -way * j);
    segment(state, 1, hold, 0);
    segment(state, 2, peak / j, way * j);
    for (int i = 3; i < 7; i++)
        segment(state, i, 0, 0);
}

static motion now(const axis_scurve_state *state)
{
    motion m = { state->x0, state->v0, state->a0 };
    double left = state->clock;
    for (int i = 0; i < 7 && left > 0; i++) {
        const double t = left < state->times[i] ? left : state->times[i];
        m = after(m, state->jerks[i], t);
        left -= t;
    }
    return m;
}

void axis_scurve(const axis_scurve_in *in, axis_scurve_out *out, axis_scurve_state *state, uint32_t dt_us)
{
    motion m = { out->position, out->velocity, out->acceleration };
    if (state->phase != REST)
        state->clock += (double)dt_us * 1e-6;
    if (state->phase == MOVES && (!in->enable || in->target != state->goal)) {
        m = now(state);
        plan_stop(in, state, m);
        begin(state, BRAKES, m);
    } else if (state->phase != REST) {
        m = now(state);
        if (state->clock >= duration(state)) {
            if (state->phase == MOVES)
                m.x = state->goal;
            m.v = m.a = 0;
            state->phase = REST;
        }
    }
    if (state->phase == REST && in->enable && in->target != m.x) {
        state->goal = in->target;
        plan_move(in, state, in->target - m.x);
        begin(state, MOVES, m);
    }
    out->position = m.x;
    out->velocity = m.v;
    out->acceleration = m.a;
    out->moving = state->phase != REST;
    out->done = in->enable && state->phase == REST && m.x == in->target;
}
