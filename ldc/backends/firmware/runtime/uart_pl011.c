/* The UART PL011 (PrimeCell). */
#include "firmware.h"
#include "board.h"

#define UART ((volatile uint32_t *)LDC_UART)

static void put(char c) {
    while (UART[6] & 0x20) { }
    UART[0] = (uint8_t)c;
}

void ldc_puts(const char *text) {
    while (*text) put(*text++);
}

void ldc_put_hex(uint32_t number) {
    for (int shift = 28; shift >= 0; shift -= 4) put("0123456789abcdef"[number >> shift & 15]);
}
