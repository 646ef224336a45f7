#include "low_pass.h"

#include <math.h>

void low_pass(const low_pass_in *in, low_pass_out *out, low_pass_state *state, uint32_t dt_us)
{
    const double input = static_cast<double>(in->input);
    if (!in->enable || !state->started || in->time_constant <= 0.0f) {
        state->value = input;
        state->started = true;
    } else {
        const double dt = dt_us * 1e-6;
        state->value += (1.0 - exp(-dt / static_cast<double>(in->time_constant))) * (input - state->value);
    }
    out->output = static_cast<float>(state->value);
}
