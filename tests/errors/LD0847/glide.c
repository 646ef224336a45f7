#include "glide.h"

void glide(const glide_in *in, glide_out *out, glide_state *state, uint32_t dt_us)
{
    (void)state;
    (void)dt_us;
    out->value = in->target;
}
