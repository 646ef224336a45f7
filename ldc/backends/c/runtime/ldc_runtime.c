/* Faults, numbers and strings of generated code; see ldc_runtime.h. */
#include "ldc_runtime.h"

#include <math.h>

/* ---- faults */

int32_t ldc_note(uint8_t *m, uint32_t first, uint32_t second) {
    ldc_system *system = LDC_SYSTEM(m);
    if (system->depth < LDC_TRACE) {
        system->trace[system->depth][0] = first;
        system->trace[system->depth][1] = second;
        system->depth++;
    }
    return LDC_FAULT;
}

static int32_t begin(uint8_t *m, uint32_t fault, uint32_t rung, uint32_t instruction) {
    LDC_SYSTEM(m)->fault = fault;
    LDC_SYSTEM(m)->depth = 0;
    return ldc_note(m, rung, instruction);
}

int32_t ldc_division(uint8_t *m, uint32_t rung, uint32_t instruction) {
    return begin(m, LDC_DIVISION, rung, instruction);
}

int32_t ldc_index(uint8_t *m, uint32_t rung, uint32_t instruction, uint32_t kind, int64_t index, int64_t low,
                  int64_t high) {
    LDC_SYSTEM(m)->index = index;
    LDC_SYSTEM(m)->low = low;
    LDC_SYSTEM(m)->high = high;
    return begin(m, kind, rung, instruction);
}

int32_t ldc_expired(uint8_t *m, uint32_t rung, uint32_t instruction) {
    return begin(m, LDC_WATCHDOG, rung, instruction);
}

/* ---- bit strings */

static uint64_t mask(uint32_t bits) { return bits < 64 ? ((uint64_t)1 << bits) - 1 : UINT64_MAX; }

uint64_t ldc_rol(uint64_t v, uint64_t n, uint32_t bits) {
    n %= bits;
    return n ? ((v << n) | (v >> (bits - n))) & mask(bits) : v;
}

uint64_t ldc_ror(uint64_t v, uint64_t n, uint32_t bits) {
    n %= bits;
    return n ? ((v >> n) | (v << (bits - n))) & mask(bits) : v;
}

uint64_t ldc_from_bcd(uint64_t v, uint32_t digits) {
    uint64_t value = 0;
    for (uint32_t i = digits; i-- > 0;) {
        uint64_t digit = v >> (4 * i) & 15;
        if (digit > 9) return 0;
        value = value * 10 + digit;
    }
    return value;
}

uint64_t ldc_to_bcd(uint64_t v, uint32_t digits) {
    uint64_t value = 0;
    for (uint32_t i = 0; i < digits; i++, v /= 10) value |= v % 10 << (4 * i);
    return value;
}

uint32_t ldc_bits_f32_u32(float v) {
    uint32_t bits;
    __builtin_memcpy(&bits, &v, 4);
    return bits;
}

float ldc_bits_u32_f32(uint32_t v) {
    float value;
    __builtin_memcpy(&value, &v, 4);
    return value;
}

uint64_t ldc_bits_f64_u64(double v) {
    uint64_t bits;
    __builtin_memcpy(&bits, &v, 8);
    return bits;
}

double ldc_bits_u64_f64(uint64_t v) {
    double value;
    __builtin_memcpy(&value, &v, 8);
    return value;
}

void ldc_unpack(uint8_t *bytes, const uint8_t *image, uint32_t at, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) bytes[i] = ldc_bit(image, at + i);
}

void ldc_pack(uint8_t *image, uint32_t at, const uint8_t *bytes, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) ldc_put_bit(image, at + i, bytes[i]);
}

/* ---- times */

int64_t ldc_div_time_u64(int64_t a, uint64_t b) {
    return a < 0 ? -(int64_t)((0 - (uint64_t)a) / b) : (int64_t)((uint64_t)a / b);
}

uint64_t ldc_day_ms(int64_t milliseconds) {
    int64_t rest = milliseconds % 86400000;
    return (uint64_t)(rest < 0 ? rest + 86400000 : rest);
}

int64_t ldc_floor_days(int64_t seconds) { return seconds / 86400 - (seconds % 86400 < 0); }

/* ---- reals */

static int64_t bounded(double v, int64_t low, int64_t high, double rounded) {
    if (v != v) return 0;
    if (v <= (double)low) return low;
    return v >= (double)high ? high : (int64_t)rounded;
}

static uint64_t positive(double v, uint64_t high, double rounded) {
    if (!(v > 0)) return 0;
    return v >= (double)high ? high : (uint64_t)rounded;
}

int64_t ldc_to_i64(double v, int64_t low, int64_t high) { return bounded(v, low, high, rint(v)); }
uint64_t ldc_to_u64(double v, uint64_t high) { return positive(v, high, rint(v)); }
int64_t ldc_trunc_i64(double v, int64_t low, int64_t high) { return bounded(v, low, high, trunc(v)); }
uint64_t ldc_trunc_u64(double v, uint64_t high) { return positive(v, high, trunc(v)); }

/* Outside of the domain: the one NaN. */
static double domain(double v, double result) { return result != result && v == v ? (double)NAN : result; }

double ldc_sqrt(double v) { return domain(v, sqrt(v)); }
double ldc_ln(double v) { return domain(v, log(v)); }
double ldc_log(double v) { return domain(v, log10(v)); }
double ldc_exp(double v) { return exp(v); }
double ldc_sin(double v) { return domain(v, sin(v)); }
double ldc_cos(double v) { return domain(v, cos(v)); }
double ldc_tan(double v) { return domain(v, tan(v)); }
double ldc_asin(double v) { return domain(v, asin(v)); }
double ldc_acos(double v) { return domain(v, acos(v)); }
double ldc_atan(double v) { return atan(v); }
double ldc_expt(double base, double exponent) {
    double result = pow(base, exponent);
    return result != result && base == base && exponent == exponent ? (double)NAN : result;
}

/* ---- strings */

static void set_length(uint8_t *s, uint64_t length) {
    s[0] = (uint8_t)length;
    s[1] = (uint8_t)(length >> 8);
}

/* Adds `count` characters of `s` from `from` on. */
static void add(uint8_t *into, uint32_t cap, const uint8_t *s, uint64_t from, uint64_t count, uint32_t size) {
    uint64_t length = ldc_length(into), most = ldc_length(s);
    if (from >= most || length >= cap) return;
    if (count > most - from) count = most - from;
    if (count > cap - length) count = cap - length;
    __builtin_memmove(into + 2 + length * size, s + 2 + from * size, count * size);
    set_length(into, length + count);
}

void ldc_put(uint8_t *into, uint32_t cap, const uint8_t *s, uint32_t size) {
    uint32_t length = ldc_length(s);
    if (length > cap) length = cap;
    __builtin_memmove(into + 2, s + 2, length * size);
    set_length(into, length);
}

void ldc_append(uint8_t *into, uint32_t cap, const uint8_t *s, uint32_t size) {
    add(into, cap, s, 0, ldc_length(s), size);
}

static uint32_t character(const uint8_t *s, uint32_t at, uint32_t size) {
    return size == 1 ? s[2 + at] : (uint32_t)(s[2 + 2 * at] | s[3 + 2 * at] << 8);
}

int ldc_compare(const uint8_t *a, const uint8_t *b, uint32_t size) {
    uint32_t left = ldc_length(a), right = ldc_length(b);
    for (uint32_t i = 0; i < left && i < right; i++) {
        uint32_t x = character(a, i, size), y = character(b, i, size);
        if (x != y) return x < y ? -1 : 1;
    }
    return left < right ? -1 : left > right;
}

const uint8_t *ldc_greater(const uint8_t *kept, const uint8_t *other, uint32_t size) {
    return ldc_compare(other, kept, size) > 0 ? other : kept;
}

const uint8_t *ldc_less(const uint8_t *kept, const uint8_t *other, uint32_t size) {
    return ldc_compare(other, kept, size) < 0 ? other : kept;
}

int64_t ldc_find(const uint8_t *s, const uint8_t *other, uint32_t size) {
    uint32_t length = ldc_length(s), wanted = ldc_length(other);
    if (wanted == 0) return 0;
    for (uint32_t at = 0; at + wanted <= length; at++)
        if (!__builtin_memcmp(s + 2 + at * size, other + 2, wanted * size)) return at + 1;
    return 0;
}

void ldc_left(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, uint32_t size) {
    set_length(into, 0);
    add(into, cap, s, 0, ldc_count(count), size);
}

void ldc_right(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, uint32_t size) {
    uint64_t length = ldc_length(s), wanted = ldc_count(count);
    set_length(into, 0);
    if (wanted) add(into, cap, s, wanted < length ? length - wanted : 0, wanted, size);
}

void ldc_mid(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, int64_t at, uint32_t size) {
    set_length(into, 0);
    if (at >= 1) add(into, cap, s, (uint64_t)at - 1, ldc_count(count), size);
}

void ldc_insert(uint8_t *into, uint32_t cap, const uint8_t *s, const uint8_t *other, int64_t at, uint32_t size) {
    set_length(into, 0);
    add(into, cap, s, 0, ldc_count(at), size);
    add(into, cap, other, 0, UINT16_MAX, size);
    add(into, cap, s, ldc_count(at), UINT16_MAX, size);
}

void ldc_delete(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, int64_t at, uint32_t size) {
    set_length(into, 0);
    if (at < 1 || count < 1) {
        add(into, cap, s, 0, UINT16_MAX, size);
        return;
    }
    add(into, cap, s, 0, (uint64_t)at - 1, size);
    add(into, cap, s, (uint64_t)at - 1 + (uint64_t)count, UINT16_MAX, size);
}

void ldc_replace(uint8_t *into, uint32_t cap, const uint8_t *s, const uint8_t *other, int64_t count, int64_t at,
                 uint32_t size) {
    set_length(into, 0);
    if (at < 1 || at > ldc_length(s)) {
        add(into, cap, s, 0, UINT16_MAX, size);
        return;
    }
    add(into, cap, s, 0, (uint64_t)at - 1, size);
    add(into, cap, other, 0, UINT16_MAX, size);
    add(into, cap, s, (uint64_t)at - 1 + ldc_count(count), UINT16_MAX, size);
}

void ldc_widen(uint8_t *into, uint32_t cap, const uint8_t *s) {
    uint32_t length = ldc_length(s);
    if (length > cap) length = cap;
    for (uint32_t i = 0; i < length; i++) {
        into[2 + 2 * i] = s[2 + i];
        into[3 + 2 * i] = 0;
    }
    set_length(into, length);
}

void ldc_narrow(uint8_t *into, uint32_t cap, const uint8_t *s) {
    uint32_t length = ldc_length(s);
    if (length > cap) length = cap;
    for (uint32_t i = 0; i < length; i++) {
        uint32_t c = character(s, i, 2);
        into[2 + i] = (uint8_t)(c < 256 ? c : '?');
    }
    set_length(into, length);
}
