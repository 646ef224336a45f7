#include "glide.h"

void glide(const glide_in *in, glide_out *out, glide_state *state, uint32_t dt_us)
{
    (void)state;
    (void)dt_us;
    switch (dt_us) { case 1 ... 5: break; }
    out->value = in->target;
}
