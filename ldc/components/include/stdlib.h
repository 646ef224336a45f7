/* For components: absolute values. There is no heap: memory of a component is its state. */
#ifndef LDC_STDLIB_H
#define LDC_STDLIB_H
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif
int abs(int value);
long labs(long value);
long long llabs(long long value);
#ifdef __cplusplus
}
#endif
#endif
