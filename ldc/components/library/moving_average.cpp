#include "moving_average.h"

void moving_average(const moving_average_in *in, moving_average_out *out, moving_average_state *state, uint32_t)
{
    if (!in->enable || state->count > in->window) {
        state->count = 0;
        state->next = 0;
    }
    if (!in->enable) {
        out->output = in->input;
        return;
    }
    state->values[state->next] = in->input;
    state->next = static_cast<uint16_t>((state->next + 1u) % in->window);
    if (state->count < in->window)
        state->count++;
    double sum = 0.0; // summed anew each time: rounding does not add up over days
    for (uint16_t i = 0; i < state->count; i++)
        sum += static_cast<double>(state->values[i]);
    out->output = static_cast<float>(sum / state->count);
}
