/* Variables that are RETAIN: copied after each scan into memory that a restart leaves alone, and back after
   one. There are two copies, so that one is whole whenever the power goes. */
#include "firmware.h"
#include "p_handshake.h"

/* Two places of `ldc_retain_words`: number of the copy, key of the program, checksum, the time of the program
   (two words), the bytes. */
enum { NUMBER, KEY, CHECK, TIME, DATA = TIME + 2 };

static uint32_t *place(uint32_t number) { return ldc_retained + (number & 1) * ldc_retain_words; }

static uint32_t check_of(const uint32_t *copy) {
    uint16_t crc = p_crc(0xFFFF, (const uint8_t *)copy, 8);
    return p_crc(crc, (const uint8_t *)(copy + TIME), (ldc_retain_words - TIME) * 4);
}

static int whole(const uint32_t *copy) {
    return copy[KEY] == ldc_retain_key && copy[CHECK] == check_of(copy);
}

static uint32_t last;

int64_t ldc_restore(void) {
    int first = whole(place(0)), second = whole(place(1));
    last = 0;
    if (!first && !second) return 0;
    last = place(!first || (second && place(1)[NUMBER] - place(0)[NUMBER] == 1))[NUMBER];
    const uint8_t *from = (const uint8_t *)(place(last) + DATA);
    for (uint32_t i = 0; i < ldc_range_count; i++) {
        __builtin_memcpy(ldc_block + ldc_ranges[2 * i], from, ldc_ranges[2 * i + 1]);
        from += ldc_ranges[2 * i + 1];
    }
    int64_t now;
    __builtin_memcpy(&now, place(last) + TIME, sizeof now);
    return now;
}

void ldc_keep(int64_t now) {
    uint32_t *copy = place(++last);
    uint8_t *to = (uint8_t *)(copy + DATA);
    copy[CHECK] = ~copy[CHECK]; /* not whole from here on */
    for (uint32_t i = 0; i < ldc_range_count; i++) {
        __builtin_memcpy(to, ldc_block + ldc_ranges[2 * i], ldc_ranges[2 * i + 1]);
        to += ldc_ranges[2 * i + 1];
    }
    __builtin_memcpy(copy + TIME, &now, sizeof now);
    copy[NUMBER] = last;
    copy[KEY] = ldc_retain_key;
    copy[CHECK] = check_of(copy);
}
