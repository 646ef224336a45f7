/* What generated code calls: the meaning of IL where it is not that of C (docs/semantics.md).

   Freestanding: needs no header but stdint.h, and of libc only memcpy, memmove, memset and the functions of
   math.h that a program uses. Compile with -fwrapv -ffp-contract=off -fno-strict-aliasing. */
#ifndef LDC_RUNTIME_H
#define LDC_RUNTIME_H

#include <stdint.h>

#define LDC_ABI 1
#define LDC_TRACE 120

/* The begin of the block of memory. ``trace``: pairs that tell where a fault was, innermost first: rung and
   instruction in a chunk, then unit and chunk, then the same of the caller, and so on. ``spent``: what further
   passes of loops cost, added up in code that is executed piece by piece. */
typedef struct {
    int64_t now;
    uint64_t watchdog;
    uint8_t first_scan;
    uint8_t unused[3];
    uint32_t fault;
    int64_t index, low, high;
    uint32_t depth;
    uint32_t reserved;
    uint32_t trace[LDC_TRACE][2];
    uint64_t spent;
} ldc_system;

/* One execution of a PROGRAM piece by piece: what it sees of ``ldc_system``, whatever is executed between two
   pieces, and where it stands. ``part``: the one that was executed last; ``at``: the next one, LDC_BEGIN before
   the first; ``entry``: the label in it, 0: its begin. */
typedef struct {
    int64_t now;
    uint64_t watchdog, spent;
    uint32_t first_scan, part, at, entry;
    uint8_t frame[];
} ldc_pace;

#define LDC_BEGIN UINT32_MAX

enum { LDC_OK = 0, LDC_RETURN = -1, LDC_FAULT = -2 };
enum { LDC_DIVISION = 1, LDC_INDEX = 2, LDC_INDEX_UNSIGNED = 3, LDC_WATCHDOG = 4 };

#define LDC_SYSTEM(m) ((ldc_system *)(m))
#define LDC_AT(type, base, offset) (*(type *)((base) + (offset)))
#define LDC_RARE(condition) __builtin_expect((condition), 0)
#define LDC_DAY INT64_C(86400000000000)

/* The code of a component, and where its pointer to the memory of globals is. */
typedef struct {
    void (*entry)(const void *in, void *out, void *state, uint32_t microseconds);
    uint8_t **memory;
} ldc_component;

int32_t ldc_note(uint8_t *m, uint32_t first, uint32_t second);
int32_t ldc_division(uint8_t *m, uint32_t rung, uint32_t instruction);
int32_t ldc_index(uint8_t *m, uint32_t rung, uint32_t instruction, uint32_t kind, int64_t index, int64_t low,
                  int64_t high);
int32_t ldc_expired(uint8_t *m, uint32_t rung, uint32_t instruction);

/* ---- integers: quotients are cut toward zero, the least integer by -1 is itself */

#define LDC_SIGNED(name, type) \
    static inline type ldc_div_##name(type a, type b) { return b == -1 ? (type)(0 - a) : (type)(a / b); } \
    static inline type ldc_mod_##name(type a, type b) { return b == -1 ? 0 : (type)(a % b); } \
    static inline type ldc_abs_##name(type a) { return a < 0 ? (type)(0 - a) : a; } \
    static inline type ldc_max_##name(type a, type b) { return b > a ? b : a; } \
    static inline type ldc_min_##name(type a, type b) { return b < a ? b : a; }
#define LDC_UNSIGNED(name, type) \
    static inline type ldc_div_##name(type a, type b) { return (type)(a / b); } \
    static inline type ldc_mod_##name(type a, type b) { return (type)(a % b); } \
    static inline type ldc_max_##name(type a, type b) { return b > a ? b : a; } \
    static inline type ldc_min_##name(type a, type b) { return b < a ? b : a; }
#define LDC_FLOATING(name, type) \
    static inline type ldc_max_##name(type a, type b) { return b > a ? b : a; } \
    static inline type ldc_min_##name(type a, type b) { return b < a ? b : a; }

LDC_SIGNED(i8, int8_t)
LDC_SIGNED(i16, int16_t)
LDC_SIGNED(i32, int32_t)
LDC_SIGNED(i64, int64_t)
LDC_UNSIGNED(u8, uint8_t)
LDC_UNSIGNED(u16, uint16_t)
LDC_UNSIGNED(u32, uint32_t)
LDC_UNSIGNED(u64, uint64_t)
LDC_FLOATING(f32, float)
LDC_FLOATING(f64, double)

static inline uint64_t ldc_count(int64_t n) { return n > 0 ? (uint64_t)n : 0; }
static inline int64_t ldc_signed(uint64_t n) { return n > INT64_MAX ? INT64_MAX : (int64_t)n; }

/* ---- bit strings of `bits` bits */

static inline uint64_t ldc_shl(uint64_t v, uint64_t n, uint32_t bits) { return n < bits ? v << n : 0; }
static inline uint64_t ldc_shr(uint64_t v, uint64_t n, uint32_t bits) { return n < bits ? v >> n : 0; }
uint64_t ldc_rol(uint64_t v, uint64_t n, uint32_t bits);
uint64_t ldc_ror(uint64_t v, uint64_t n, uint32_t bits);
uint64_t ldc_from_bcd(uint64_t v, uint32_t digits);
uint64_t ldc_to_bcd(uint64_t v, uint32_t digits);
uint32_t ldc_bits_f32_u32(float v);
float ldc_bits_u32_f32(uint32_t v);
uint64_t ldc_bits_f64_u64(double v);
double ldc_bits_u64_f64(uint64_t v);

static inline uint8_t ldc_bit(const uint8_t *image, uint32_t at) { return image[at >> 3] >> (at & 7) & 1; }
static inline void ldc_put_bit(uint8_t *image, uint32_t at, uint8_t value) {
    image[at >> 3] = (uint8_t)((image[at >> 3] & ~(1u << (at & 7))) | (uint32_t)value << (at & 7));
}
void ldc_unpack(uint8_t *bytes, const uint8_t *image, uint32_t at, uint32_t count);
void ldc_pack(uint8_t *image, uint32_t at, const uint8_t *bytes, uint32_t count);

/* ---- times, in nanoseconds; dates in days */

static inline uint64_t ldc_day(int64_t v) {
    int64_t rest = v % LDC_DAY;
    return (uint64_t)(rest < 0 ? rest + LDC_DAY : rest);
}
int64_t ldc_div_time_u64(int64_t a, uint64_t b);
uint64_t ldc_day_ms(int64_t milliseconds);
int64_t ldc_floor_days(int64_t seconds);

/* ---- reals as integers: within the range, half to even (to) or cut (trunc), 0 for a NaN */

int64_t ldc_to_i64(double v, int64_t low, int64_t high);
uint64_t ldc_to_u64(double v, uint64_t high);
int64_t ldc_trunc_i64(double v, int64_t low, int64_t high);
uint64_t ldc_trunc_u64(double v, uint64_t high);

double ldc_sqrt(double v);
double ldc_ln(double v);
double ldc_log(double v);
double ldc_exp(double v);
double ldc_sin(double v);
double ldc_cos(double v);
double ldc_tan(double v);
double ldc_asin(double v);
double ldc_acos(double v);
double ldc_atan(double v);
double ldc_expt(double base, double exponent);

/* ---- strings: 16-bit length, then characters of `size` bytes; results hold at most `cap` of them */

static inline uint16_t ldc_length(const uint8_t *s) { return (uint16_t)(s[0] | s[1] << 8); }
static inline int16_t ldc_len(const uint8_t *s) { return (int16_t)ldc_length(s); }
void ldc_put(uint8_t *into, uint32_t cap, const uint8_t *s, uint32_t size);
void ldc_append(uint8_t *into, uint32_t cap, const uint8_t *s, uint32_t size);
int ldc_compare(const uint8_t *a, const uint8_t *b, uint32_t size);
const uint8_t *ldc_greater(const uint8_t *kept, const uint8_t *other, uint32_t size);
const uint8_t *ldc_less(const uint8_t *kept, const uint8_t *other, uint32_t size);
int64_t ldc_find(const uint8_t *s, const uint8_t *other, uint32_t size);
void ldc_left(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, uint32_t size);
void ldc_right(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, uint32_t size);
void ldc_mid(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, int64_t at, uint32_t size);
void ldc_insert(uint8_t *into, uint32_t cap, const uint8_t *s, const uint8_t *other, int64_t at, uint32_t size);
void ldc_delete(uint8_t *into, uint32_t cap, const uint8_t *s, int64_t count, int64_t at, uint32_t size);
void ldc_replace(uint8_t *into, uint32_t cap, const uint8_t *s, const uint8_t *other, int64_t count, int64_t at,
                 uint32_t size);
void ldc_widen(uint8_t *into, uint32_t cap, const uint8_t *s);
void ldc_narrow(uint8_t *into, uint32_t cap, const uint8_t *s);

/* ---- values as text and back (ldc_text.c; needs snprintf and strtod) */

void ldc_print_bool(uint8_t *into, uint32_t cap, uint32_t size, uint8_t v);
void ldc_print_i64(uint8_t *into, uint32_t cap, uint32_t size, int64_t v);
void ldc_print_u64(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v);
void ldc_print_bits(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v);
void ldc_print_single(uint8_t *into, uint32_t cap, uint32_t size, float v);
void ldc_print_real(uint8_t *into, uint32_t cap, uint32_t size, double v);
void ldc_print_time(uint8_t *into, uint32_t cap, uint32_t size, int64_t v);
void ldc_print_date(uint8_t *into, uint32_t cap, uint32_t size, uint32_t v);
void ldc_print_tod(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v);
void ldc_print_dt(uint8_t *into, uint32_t cap, uint32_t size, uint64_t v);
uint8_t ldc_read_bool(const uint8_t *s, uint32_t size);
int64_t ldc_read_i64(const uint8_t *s, uint32_t size, int64_t low, int64_t high);
uint64_t ldc_read_u64(const uint8_t *s, uint32_t size, uint64_t high);
double ldc_read_real(const uint8_t *s, uint32_t size);
float ldc_read_single(const uint8_t *s, uint32_t size);
int64_t ldc_read_time(const uint8_t *s, uint32_t size);
uint32_t ldc_read_date(const uint8_t *s, uint32_t size);
uint64_t ldc_read_tod(const uint8_t *s, uint32_t size);
uint64_t ldc_read_dt(const uint8_t *s, uint32_t size);

#endif
